#pragma once

// A run that is taken up again from a checkpoint, anywhere, must end in the bits and the counts of the unbroken run.

#include <phistep/io/checkpoint.hpp>
#include <phistep/phistep.hpp>

#include <cmath>
#include <iostream>
#include <random>
#include <sstream>
#include <string>
#include <vector>

#include "support/catch.hpp"

namespace restart {

/// All that a part would write: equal strings mean equal bits.
template <class... Parts>
[[nodiscard]] std::string bytes(const Parts&... parts) {
  std::ostringstream out;
  phistep::save_checkpoint(out, parts...);
  return out.str();
}

/// A place is where a run stops: one number of this seed, printed where a test fails.
[[nodiscard]] inline unsigned seed() {
  static const unsigned drawn = [] {
    const unsigned it = std::random_device{}();
    std::cout << "restart places drawn with seed " << it << '\n';
    return it;
  }();
  return drawn;
}

struct Steps {
  double dt;
  bool even = true;  ///< else of lengths that change by up to a fifth from step to step
  int count = 60;
  [[nodiscard]] double length(int n) const { return even ? dt : dt * (1 + 0.2 * std::sin(1.7 * n)); }
};

/// Runs to the end, then from 100 random places and from the first few again, each time with a stepper and a state made
/// anew. Returns what the unbroken run did.
/// @param make   makes the stepper for a state
/// @param start  makes the state
template <class Make, class Start>
phistep::Statistics check(const Steps& steps, Start start, Make make) {
  using namespace phistep;
  auto y = start();
  using Time = ScalarOf<std::remove_cvref_t<decltype(y)>>;
  auto stepper = make(y);
  Time t = 0;
  const auto go = [&steps](auto& by, auto& state, Time& now, int from) {
    for (int n = from; n < steps.count; ++n) {
      const auto dt = static_cast<Time>(steps.length(n));
      const StepReport report = by.step(state, now, dt);
      if (!report) FAIL_CHECK("step " << n << ": " << report.message());
      now += dt;
    }
  };
  std::vector<std::string> checkpoints;
  for (int n = 0; n < steps.count; ++n) {
    checkpoints.push_back(bytes(stepper, y, t));
    const auto dt = static_cast<Time>(steps.length(n));
    const StepReport report = stepper.step(y, t, dt);
    INFO(report.message());
    REQUIRE(report);
    t += dt;
  }
  const std::string end = bytes(stepper, y, t);

  std::mt19937 random(seed());
  std::uniform_int_distribution<int> anywhere(0, steps.count - 1);
  int wrong_bits = 0, wrong_counts = 0, wrong_inside = 0, wrong_copies = 0, last_wrong = -1;
  for (int k = 0; k < 105; ++k) {
    const int place = k < 5 ? k : anywhere(random);
    const std::string& from = checkpoints[static_cast<std::size_t>(place)];
    auto again = start();
    auto fresh = make(again);
    Time now = -1;
    std::istringstream in(from);
    load_checkpoint(in, fresh, again, now);
    wrong_copies += bytes(fresh, again, now) != from;
    go(fresh, again, now, place);
    const bool same = bytes(again, now) == bytes(y, t);
    wrong_bits += !same;
    wrong_counts += fresh.statistics() != stepper.statistics();
    wrong_inside += bytes(fresh, again, now) != end;
    if (!same) last_wrong = place;
  }
  CAPTURE(seed(), last_wrong);
  CHECK(wrong_bits == 0);
  CHECK(wrong_counts == 0);
  CHECK(wrong_inside == 0);  // the next checkpoint is the same too
  CHECK(wrong_copies == 0);
  return stepper.statistics();
}

}  // namespace restart

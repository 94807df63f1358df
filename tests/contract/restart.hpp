#pragma once

// A run that is taken up again from a checkpoint, anywhere, must end in the bits and the counts of the unbroken run.

#include <phistep/io/checkpoint.hpp>
#include <phistep/phistep.hpp>

#include <cmath>
#include <functional>
#include <iostream>
#include <memory>
#include <random>
#include <sstream>
#include <string>
#include <type_traits>
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

/// A stepper with its state and its time, whatever their types: the checks below are compiled once, not for each.
struct Subject {
  Subject() = default;
  Subject(const Subject&) = delete;
  virtual ~Subject() = default;
  virtual phistep::StepReport step(double dt) = 0;
  // Stepper, state and time, as parts of a checkpoint.
  virtual void save(phistep::Writer& out) const = 0;
  virtual void load(phistep::Reader& in, const std::function<void()>& then) = 0;
  [[nodiscard]] virtual std::string bytes_of_state() const = 0;  ///< and time
  [[nodiscard]] virtual phistep::Statistics statistics() const = 0;
};

template <class State, class Stepper>
class Body final : public Subject {
  using Time = phistep::ScalarOf<State>;

 public:
  Body(const auto& start, const auto& make, double t) : y_{start()}, stepper_{make(y_)}, t_{static_cast<Time>(t)} {}
  phistep::StepReport step(double length) override {
    const auto dt = static_cast<Time>(length);
    const phistep::StepReport report = stepper_.step(y_, t_, dt);
    t_ += dt;
    return report;
  }
  void save(phistep::Writer& out) const override { phistep::save_parts(out, stepper_, y_, t_); }
  void load(phistep::Reader& in, const std::function<void()>& then) override {
    auto&& y = phistep::detail::as_part(y_);  // as load_checkpoint does
    phistep::load_parts(in, then, stepper_, y, t_);
  }
  [[nodiscard]] std::string bytes_of_state() const override { return restart::bytes(y_, t_); }
  [[nodiscard]] phistep::Statistics statistics() const override { return stepper_.statistics(); }

 private:
  State y_;
  Stepper stepper_;
  Time t_;
};

inline void load(const std::string& bytes, auto& part) {
  std::istringstream in(bytes);
  phistep::load_checkpoint(in, part);
}

/// Runs to the end, then from 100 random places and from the first few again, each time with a stepper and a state made
/// anew. Returns what the unbroken run did.
/// @param make_at  makes both, at a time
inline phistep::Statistics check_subjects(const Steps& steps,
                                          const std::function<std::unique_ptr<Subject>(double)>& make_at) {
  using namespace phistep;
  const auto unbroken = make_at(0);
  std::vector<std::string> checkpoints;
  for (int n = 0; n < steps.count; ++n) {
    checkpoints.push_back(bytes(*unbroken));
    const StepReport report = unbroken->step(steps.length(n));
    INFO(report.message());
    REQUIRE(report);
  }
  const std::string end = bytes(*unbroken), end_of_state = unbroken->bytes_of_state();
  const Statistics counts = unbroken->statistics();

  std::mt19937 random(seed());
  std::uniform_int_distribution<int> anywhere(0, steps.count - 1);
  int wrong_bits = 0, wrong_counts = 0, wrong_inside = 0, wrong_copies = 0, last_wrong = -1;
  for (int k = 0; k < 105; ++k) {
    const int place = k < 5 ? k : anywhere(random);
    const std::string& from = checkpoints[static_cast<std::size_t>(place)];
    const auto fresh = make_at(-1);
    load(from, *fresh);
    wrong_copies += bytes(*fresh) != from;
    for (int n = place; n < steps.count; ++n) {
      const StepReport report = fresh->step(steps.length(n));
      if (!report) FAIL_CHECK("step " << n << ": " << report.message());
    }
    const bool same = fresh->bytes_of_state() == end_of_state;
    wrong_bits += !same;
    wrong_counts += fresh->statistics() != counts;
    wrong_inside += bytes(*fresh) != end;
    if (!same) last_wrong = place;
  }
  CAPTURE(seed(), last_wrong);
  CHECK(wrong_bits == 0);
  CHECK(wrong_counts == 0);
  CHECK(wrong_inside == 0);  // the next checkpoint is the same too
  CHECK(wrong_copies == 0);
  return counts;
}

/// @param make   makes the stepper for a state
/// @param start  makes the state
template <class Make, class Start>
phistep::Statistics check(const Steps& steps, const Start& start, const Make& make) {
  using State = std::invoke_result_t<const Start&>;
  using Stepper = std::invoke_result_t<const Make&, State&>;
  return check_subjects(steps, [&](double t) -> std::unique_ptr<Subject> {
    return std::make_unique<Body<State, Stepper>>(start, make, t);
  });
}

}  // namespace restart

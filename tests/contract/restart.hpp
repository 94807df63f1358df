#pragma once

// A run that is taken up again from a checkpoint, anywhere, must end in the bits and the counts of the run that saved it;
// where there are no Jacobians to forget, in those of a run that never saved, and else near them.

#include <phistep/io/checkpoint.hpp>
#include <phistep/phistep.hpp>

#include <algorithm>
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

/// All that a part would write: equal strings mean equal bits. Nothing is forgotten.
template <class... Parts>
[[nodiscard]] std::string bytes(const Parts&... parts) {
  std::ostringstream out;
  phistep::detail::write_checkpoint(out, parts...);
  return out.str();
}
/// Saves it, and the part forgets what is not in there.
[[nodiscard]] std::string saved(auto& part) {
  std::ostringstream out;
  phistep::save_checkpoint(out, part);
  return out.str();
}
/// By how much two states differ, relative to the largest number of each block.
template <class State>
[[nodiscard]] double apart(const State& a, const State& b) {
  double worst = 0;
  phistep::for_each_block(
      [&worst](auto, const auto& x, const auto& y) {
        double off = 0, size = 0;
        for (phistep::Index j = 0; j < x.cols(); ++j)
          for (phistep::Index i = 0; i < x.rows(); ++i) {
            off = std::max(off, std::abs(static_cast<double>(x(i, j) - y(i, j))));
            size = std::max(size, std::abs(static_cast<double>(x(i, j))));
          }
        if (off > 0) worst = std::max(worst, off / size);
      },
      phistep::Blocks<State>::all(a), phistep::Blocks<State>::all(b));
  return worst;
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
  double near = 1e-9;  ///< how far from the run that never saved, where saving forgets anything
  [[nodiscard]] double length(int n) const { return even ? dt : dt * (1 + 0.2 * std::sin(1.7 * n)); }
};

/// Where solves end at a relative 1e-4, and what some of them leave adds up: so near is a run that has other Jacobians.
inline Steps loosely(Steps steps) {
  steps.near = 1e-3;
  return steps;
}

/// A stepper with its state and its time, whatever their types: the checks below are compiled once, not for each.
struct Subject {
  Subject() = default;
  Subject(const Subject&) = delete;
  virtual ~Subject() = default;
  virtual phistep::StepReport step(double dt) = 0;
  // Stepper, state and time, as parts of a checkpoint.
  using ArchivedByParts = void;
  virtual void archive(phistep::Writer& out) = 0;
  virtual void archive(phistep::Reader& in) = 0;
  virtual void forget_unsaved() = 0;
  [[nodiscard]] virtual bool has_unsaved() const = 0;
  [[nodiscard]] virtual double apart(const Subject& other) const = 0;
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
  void archive(phistep::Writer& out) override { archive_all(out); }
  void archive(phistep::Reader& in) override { archive_all(in); }
  void forget_unsaved() override {
    if constexpr (phistep::HasUnsaved<Stepper>) stepper_.forget_unsaved();
  }
  [[nodiscard]] bool has_unsaved() const override { return phistep::HasUnsaved<Stepper>; }
  [[nodiscard]] double apart(const Subject& other) const override {
    return restart::apart(y_, static_cast<const Body&>(other).y_);
  }
  [[nodiscard]] std::string bytes_of_state() const override { return restart::bytes(y_, t_); }
  [[nodiscard]] phistep::Statistics statistics() const override { return stepper_.statistics(); }

 private:
  void archive_all(auto& ar) {
    ar(stepper_);
    ar.state("y", y_);
    ar("t", t_);
  }

  State y_;
  Stepper stepper_;
  Time t_;
};

inline void load(const std::string& bytes, auto& part) {
  std::istringstream in(bytes);
  phistep::load_checkpoint(in, part);
}

/// Goes on from step n to the end. @param saves  before each step
inline void go_on(Subject& run, const Steps& steps, int n, bool saves = false) {
  for (; n < steps.count; ++n) {
    if (saves) static_cast<void>(saved(run));
    const phistep::StepReport report = run.step(steps.length(n));
    if (!report) FAIL_CHECK("step " << n << ": " << report.message());
  }
}

/// Runs to the end, then from 100 random places and from the first few again, each time with a stepper and a state made
/// anew. Returns what the unbroken run did.
/// @param make_at  makes both, at a time
inline phistep::Statistics check_subjects(const Steps& steps,
                                          const std::function<std::unique_ptr<Subject>(double)>& make_at) {
  using namespace phistep;
  const auto unbroken = make_at(0);
  const bool forgets = unbroken->has_unsaved();
  std::vector<std::string> checkpoints;
  for (int n = 0; n < steps.count; ++n) {
    checkpoints.push_back(bytes(*unbroken));
    const StepReport report = unbroken->step(steps.length(n));
    INFO(report.message());
    REQUIRE(report);
  }
  const Statistics counts = unbroken->statistics();
  if (!forgets) {
    const auto saver = make_at(0);
    go_on(*saver, steps, 0, true);
    CHECK(bytes(*saver) == bytes(*unbroken));
  }

  std::mt19937 random(seed());
  std::uniform_int_distribution<int> anywhere(0, steps.count - 1);
  int wrong_bits = 0, wrong_counts = 0, wrong_inside = 0, wrong_copies = 0, last_wrong = -1;
  double off = 0;
  const int places = forgets ? 40 : 105;  // where saving forgets, the run that saved is done once more for each
  for (int k = 0; k < places; ++k) {
    const int place = k < 5 ? k : anywhere(random);
    const std::string& from = checkpoints[static_cast<std::size_t>(place)];
    const auto fresh = make_at(-1);
    load(from, *fresh);
    wrong_copies += bytes(*fresh) != from;
    go_on(*fresh, steps, place);
    std::unique_ptr<Subject> saver;
    if (forgets) {
      saver = make_at(0);
      for (int n = 0; n < place; ++n) static_cast<void>(saver->step(steps.length(n)));
      wrong_copies += saved(*saver) != from;
      go_on(*saver, steps, place);
      off = std::max(off, fresh->apart(*unbroken));
    }
    const Subject& other = forgets ? *saver : *unbroken;
    const bool same = fresh->bytes_of_state() == other.bytes_of_state();
    wrong_bits += !same;
    wrong_counts += fresh->statistics() != other.statistics();
    wrong_inside += bytes(*fresh) != bytes(other);
    if (!same) last_wrong = place;
  }
  CAPTURE(seed(), last_wrong);
  CHECK(wrong_bits == 0);
  CHECK(wrong_counts == 0);
  CHECK(wrong_inside == 0);  // the next checkpoint is the same too
  CHECK(wrong_copies == 0);
  CHECK(off <= steps.near);
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

#pragma once

// Runs that are saved anywhere, loaded by runs made anew, and must go on as if nothing had happened.

#include <phistep/phistep.hpp>

#include <cmath>
#include <cstddef>
#include <functional>
#include <memory>
#include <random>
#include <sstream>
#include <string>
#include <tuple>
#include <type_traits>
#include <vector>

#include "contract/restart.hpp"
#include "support/catch.hpp"

namespace restart_run {

using namespace phistep;

/// A run with all that it refers to, whatever their types: the checks below are compiled once, not for each.
struct Subject {
  Subject() = default;
  Subject(const Subject&) = delete;
  virtual ~Subject() = default;
  [[nodiscard]] virtual bool advance() = 0;
  [[nodiscard]] virtual RunReport report() const = 0;
  virtual RunReport finish() = 0;
  // The run as a part of a checkpoint.
  using ArchivedByParts = void;
  virtual void archive(Writer& out) = 0;
  virtual void archive(Reader& in) = 0;
  virtual void forget_unsaved() = 0;
  [[nodiscard]] virtual bool has_unsaved() const = 0;
  [[nodiscard]] virtual double apart(const Subject& other) const = 0;
  [[nodiscard]] virtual std::string bytes_of_state() const = 0;
  [[nodiscard]] virtual Statistics statistics() const = 0;  ///< the stepper's own
  std::vector<double> log;
};

/// `observers` makes them, for a log of what they saw.
template <class State, class Stepper, class Control, class Seen>
class Whole;
template <class State, class Stepper, class Control, class... O>
class Whole<State, Stepper, Control, std::tuple<O...>> final : public Subject {
  using TheRun = Run<Stepper, State, Control, O&...>;
  static TheRun run_of(Stepper& stepper, State& y, double t1, const Control& control, std::tuple<O...>& observers) {
    return std::apply(
        [&](auto&... one) {
          return TheRun{stepper, y, {0, static_cast<ScalarOf<State>>(t1)}, control, one...};
        },
        observers);
  }
  State y_;
  Stepper stepper_;
  std::tuple<O...> seen_;
  TheRun run_;

 public:
  Whole(const auto& start, const auto& make, double t1, const Control& control, const auto& observers)
      : y_{start()}, stepper_{make(y_)}, seen_{observers(log)}, run_{run_of(stepper_, y_, t1, control, seen_)} {}
  [[nodiscard]] bool advance() override { return run_.advance(); }
  [[nodiscard]] RunReport report() const override { return run_.report(); }
  RunReport finish() override { return run_.finish(); }
  void archive(Writer& out) override { run_.archive(out); }
  void archive(Reader& in) override { run_.archive(in); }
  void forget_unsaved() override {
    if constexpr (HasUnsaved<TheRun>) run_.forget_unsaved();
  }
  [[nodiscard]] bool has_unsaved() const override { return HasUnsaved<TheRun>; }
  [[nodiscard]] double apart(const Subject& other) const override {
    return restart::apart(y_, static_cast<const Whole&>(other).y_);
  }
  [[nodiscard]] std::string bytes_of_state() const override { return restart::bytes(y_); }
  [[nodiscard]] Statistics statistics() const override { return stepper_.statistics(); }
};

inline constexpr auto nobody = [](std::vector<double>&) { return std::tuple<>{}; };

/// To the end.
inline RunReport go_on(Subject& run, bool at_once) {
  if (at_once) return run.finish();
  while (run.advance()) {
  }
  return run.report();
}

/// Runs to its end, and again from 100 random places, each time with everything made anew. What the observers see after a
/// restart must be the rest of what they saw in the run that saved. Returns the longest step over the shortest.
/// @param near  how far from the run that never saved, where saving forgets anything
inline double check_subjects(const std::function<std::unique_ptr<Subject>()>& make, double near) {
  const auto unbroken = make();
  const bool forgets = unbroken->has_unsaved();
  std::vector<std::string> checkpoints;
  do {
    checkpoints.push_back(restart::bytes(*unbroken));
  } while (unbroken->advance());
  const RunReport report = unbroken->report();
  INFO(report.message());
  REQUIRE(report);
  if (!forgets) {
    const auto saver = make();
    do {
      static_cast<void>(restart::saved(*saver));
    } while (saver->advance());
    CHECK(restart::bytes(*saver) == restart::bytes(*unbroken));
    CHECK(saver->log == unbroken->log);
  }

  std::mt19937 random(restart::seed());
  std::uniform_int_distribution<std::size_t> anywhere(0, checkpoints.size() - 1);
  int wrong_ends = 0, wrong_bits = 0, wrong_counts = 0, wrong_logs = 0, wrong_copies = 0;
  double off = 0;
  const std::size_t places = forgets ? 41 : 103;
  for (std::size_t k = 0; k < places; ++k) {
    const std::size_t place = k < 3 ? k : anywhere(random);
    const bool at_once = k % 2 == 1;
    const auto again = make(), saver = make();
    restart::load(checkpoints[place], *again);
    wrong_copies += restart::bytes(*again) != checkpoints[place];
    for (std::size_t n = 0; n < place; ++n) static_cast<void>(saver->advance());
    wrong_copies += restart::saved(*saver) != checkpoints[place];
    const std::size_t logged = saver->log.size();
    const RunReport then = go_on(*again, at_once), other = go_on(*saver, at_once);
    wrong_ends += !then || then.t != report.t;
    wrong_bits +=
        again->bytes_of_state() != saver->bytes_of_state() || restart::bytes(*again) != restart::bytes(*saver);
    wrong_counts += then.statistics != other.statistics || again->statistics() != saver->statistics();
    if (!forgets) {
      // finish() vouches for the state where advance() looks: inside, the two differ in that.
      wrong_bits += saver->bytes_of_state() != unbroken->bytes_of_state();
      wrong_counts += other.statistics != report.statistics;
    }
    off = std::max(off, again->apart(*unbroken));
    const auto rest = saver->log.begin() + static_cast<std::ptrdiff_t>(logged);
    wrong_logs += again->log != std::vector<double>(rest, saver->log.end());
  }
  CAPTURE(restart::seed());
  CHECK(wrong_ends == 0);
  CHECK(wrong_bits == 0);
  CHECK(wrong_counts == 0);
  CHECK(wrong_logs == 0);
  CHECK(wrong_copies == 0);
  CHECK(off <= near);
  return report.largest_dt / report.smallest_dt;
}

/// How far a run may be from another one that is controlled alike.
template <class Control>
double nearness(const Control& control) {
  if constexpr (requires { control.rtol; }) return 10 * control.rtol;
  else if constexpr (requires { control.error; }) return 10 * control.error.rtol;
  else return 1e-6;
}

template <class Start, class Make, class Control, class Observers = decltype(nobody)>
double check(const Start& start, const Make& make, double t1, const Control& control,
             const Observers& observers = nobody) {
  using State = std::invoke_result_t<const Start&>;
  using Stepper = std::invoke_result_t<const Make&, State&>;
  using Seen = std::invoke_result_t<const Observers&, std::vector<double>&>;
  return check_subjects(
      [&]() -> std::unique_ptr<Subject> {
        return std::make_unique<Whole<State, Stepper, Control, Seen>>(start, make, t1, control, observers);
      },
      nearness(control));
}

template <class F, class... More>
auto steps(F f, More... more) {
  return [=](auto& y) { return PhiStepper{y, f, more...}; };
}

}  // namespace restart_run

#pragma once

// Runs that are saved anywhere, loaded by runs made anew, and must go on as if nothing had happened.

#include <phistep/phistep.hpp>

#include <cmath>
#include <cstddef>
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

/// A run with all that it refers to. `observers` makes them, for a log of what they saw.
template <class Start, class Make, class Control, class Observers>
struct Whole {
  using State = std::invoke_result_t<Start>;
  using Stepper = std::invoke_result_t<Make, State&>;
  State y;
  Stepper stepper;
  std::vector<double> log;
  using Tuple = std::invoke_result_t<Observers, std::vector<double>&>;
  Tuple seen;
  template <class... O>
  static auto run_of(Stepper& stepper, State& y, double t1, const Control& control, std::tuple<O...>& observers) {
    return std::apply(
        [&](auto&... one) {
          return std::unique_ptr<Run<Stepper, State, Control, O&...>>(new Run<Stepper, State, Control, O&...>(
              stepper, y, {0, static_cast<ScalarOf<State>>(t1)}, control, one...));
        },
        observers);
  }
  decltype(run_of(std::declval<Stepper&>(), std::declval<State&>(), 0.0, std::declval<const Control&>(),
                  std::declval<Tuple&>())) run;

  Whole(Start start, Make make, double t1, const Control& control, Observers observers)
      : y{start()}, stepper{make(y)}, seen{observers(log)}, run{run_of(stepper, y, t1, control, seen)} {}
  Whole(const Whole&) = delete;

  [[nodiscard]] std::string bytes() const { return restart::bytes(*run); }
};

inline constexpr auto nobody = [](std::vector<double>&) { return std::tuple<>{}; };

/// Runs to t1, and again from 100 random places, each time with everything made anew. What the observers see after a
/// restart must be the rest of what they saw in the unbroken run. Returns the longest step over the shortest.
template <class Start, class Make, class Control, class Observers = decltype(nobody)>
double check(Start start, Make make, double t1, const Control& control, Observers observers = nobody) {
  using All = Whole<Start, Make, Control, Observers>;
  All unbroken(start, make, t1, control, observers);
  std::vector<std::string> checkpoints;
  std::vector<std::size_t> logged;
  do {
    checkpoints.push_back(unbroken.bytes());
    logged.push_back(unbroken.log.size());
  } while (unbroken.run->advance());
  const RunReport report = unbroken.run->report();
  INFO(report.message());
  REQUIRE(report);
  const std::string end = unbroken.bytes();

  std::mt19937 random(restart::seed());
  std::uniform_int_distribution<std::size_t> anywhere(0, checkpoints.size() - 1);
  int wrong_ends = 0, wrong_bits = 0, wrong_counts = 0, wrong_logs = 0, wrong_copies = 0;
  for (std::size_t k = 0; k < 103; ++k) {
    const std::size_t place = k < 3 ? k : anywhere(random);
    All again(start, make, t1, control, observers);
    std::istringstream in(checkpoints[place]);
    load_checkpoint(in, *again.run);
    wrong_copies += again.bytes() != checkpoints[place];
    RunReport then;
    if (k % 2 == 0) {
      while (again.run->advance()) {
      }
      then = again.run->report();
    } else {
      then = again.run->finish();
    }
    wrong_ends += !then || then.t != report.t;
    wrong_bits += restart::bytes(again.y) != restart::bytes(unbroken.y);
    wrong_counts += then.statistics != report.statistics || again.stepper.statistics() != unbroken.stepper.statistics();
    // finish() vouches for the state where advance() looks: inside, the two differ in that.
    if (k % 2 == 0) wrong_bits += again.bytes() != end;
    const auto rest = unbroken.log.begin() + static_cast<std::ptrdiff_t>(logged[place]);
    wrong_logs += again.log != std::vector<double>(rest, unbroken.log.end());
  }
  CAPTURE(restart::seed());
  CHECK(wrong_ends == 0);
  CHECK(wrong_bits == 0);
  CHECK(wrong_counts == 0);
  CHECK(wrong_logs == 0);
  CHECK(wrong_copies == 0);
  return report.largest_dt / report.smallest_dt;
}

template <class F, class... More>
auto steps(F f, More... more) {
  return [=](auto& y) { return PhiStepper{y, f, more...}; };
}

}  // namespace restart_run

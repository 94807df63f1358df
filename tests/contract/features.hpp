#pragma once

// Features in company: a run with two or more of them is compared with the run that has none. What may change no bit must
// change none; what moves steps must leave the error within the tolerance.

#include <phistep/io/checkpoint.hpp>
#include <phistep/phistep.hpp>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "contract/property.hpp"
#include "support/shared_force.hpp"

namespace features {

using namespace phistep;
using property::Source;
using State = Eigen::Vector3d;

/// A damped rotation and a decay: y1 + i y2 = e^{(−a + iw)t}, y3 = e^{−d t}, in the variable t − t0.
struct Flow {
  double a, w, d;
  State operator()(const State& y) const { return {-a * y[0] - w * y[1], w * y[0] - a * y[1], -d * y[2]}; }
  [[nodiscard]] State at(double t) const {
    return {std::exp(-a * t) * std::cos(w * t), std::exp(-a * t) * std::sin(w * t), std::exp(-d * t)};
  }
};
struct Fault : std::runtime_error {
  Fault() : std::runtime_error("a force that fails once") {}
};

/// What is asked of a run beside its steps.
struct Wanted {
  bool controlled = false, backward = false;
  double rtol = 1e-5, dt = 1.0 / 64, t0 = 0;
  bool event = false, times = false;                                  // these move steps
  bool samples = false, idle_event = false, writes = false;           // these don't,
  bool halving = false, map = false, restart = false, fault = false;  // nor do these
  bool saves = false;
  double level = 0;
  std::vector<double> at;
  int middle = 0;  ///< the step after which a checkpoint is taken
  std::int64_t call = -1;
};
/// How a run went.
struct Went {
  RunReport report;
  State end;
  double off = 0;  ///< the largest error that an event or a sample saw
};

/// @tparam wraps  with states and steppers of other types, too: they cost the compiler more than all the rest
template <bool wraps, class Scheme>
Went go(const Flow& flow, Scheme scheme, const Wanted& wanted) {
  std::int64_t calls = 0;
  const std::function<State(const State&)> force = [&](const State& y) {
    if (calls++ == wanted.call) throw Fault();
    return flow(y);
  };
  const double span = wanted.backward ? -2 : 2, start = wanted.backward ? 2 : 0;
  State numbers = flow.at(start);
  Went went;
  const auto look = [&](double t, const State& y) {
    went.off = std::max(went.off, (y - flow.at(start + (t - wanted.t0))).cwiseAbs().maxCoeff());
  };
  const auto run_with = [&](auto& state, auto&& make_stepper) {
    using S = std::remove_cvref_t<decltype(state)>;
    std::vector<double> times = wanted.times ? wanted.at : std::vector<double>{};
    std::vector<double> sampled_at = wanted.samples ? wanted.at : std::vector<double>{};
    const auto make_observers = [&] {
      const std::function<double(double, const State&)> g = [&](double, const State& y) {
        return wanted.event ? y[1] - wanted.level : 1.0;
      };
      return std::tuple{event(g, {}, std::function<void(double, S&)>([&](double t, S& y) { look(t, y); })),
                        at_times(times, std::function<void(double, S&)>([](double, S&) {})),
                        sampled(sampled_at, std::function<void(double, const State&)>(look)),
                        std::function<void(double, S&)>([&](double, S& y) {
                          if (wanted.writes) y = State(y);  // the same bits
                        })};
    };
    const auto run_on = [&](const auto& control) {
      auto stepper = make_stepper(state);
      auto observers = make_observers();
      const TimeSpan<double> times_of_run{wanted.t0, wanted.t0 + span};
      std::apply(
          [&](auto&... observer) {
            Run run{stepper, state, times_of_run, control, observer...};
            int steps = 0;
            const auto advance = [&](auto& of) {
              try {
                return of.advance();
              } catch (const Fault&) {
                return true;
              }
            };
            while (advance(run)) {
              if ((wanted.restart || wanted.saves) && ++steps == wanted.middle) {
                std::stringstream file;
                save_checkpoint(file, run);
                if (!wanted.restart) continue;
                auto fresh_stepper = make_stepper(state);
                auto fresh_observers = make_observers();
                state = State(State::Zero());
                std::apply(
                    [&](auto&... fresh_observer) {
                      Run fresh{fresh_stepper, state, times_of_run, control, fresh_observer...};
                      load_checkpoint(file, fresh);
                      while (advance(fresh)) {
                      }
                      went.report = fresh.report();
                    },
                    fresh_observers);
                return;
              }
            }
            went.report = run.report();
          },
          observers);
    };
    if (wanted.controlled) run_on(tolerance{.rtol = wanted.rtol, .atol = wanted.rtol});
    else run_on(fixed(wanted.dt));
    went.end = State(state);
  };
  const auto with_halving = [&](auto& state) {
    if constexpr (wraps)
      if (wanted.halving) return run_with(state, [&](const auto& y) { return Halving{PhiStepper{y, force, scheme}}; });
    run_with(state, [&](const auto& y) { return PhiStepper{y, force, scheme}; });
  };
  if constexpr (wraps)
    if (wanted.map) {
      Eigen::Map<State> state(numbers.data());
      with_halving(state);
      return went;
    }
  with_halving(numbers);
  return went;
}

template <bool wraps = true, class Scheme>
void pair_up(Source& source, Scheme scheme, double finest) {
  Flow flow{source.real("a", 0, 0.5), source.real("w", 0.5, 6), source.real("d", 0, 0.5)};
  Wanted plain;
  plain.controlled = source.flag("controlled");
  plain.backward = source.flag("backward");
  plain.rtol = source.decades("rtol", finest, -3);
  plain.dt = std::exp2(-source.integer("2^-dt", 4, 7));
  Wanted all = plain;
  all.halving = source.flag("halving");
  all.map = source.flag("map");
  all.restart = source.flag("restart");
  all.middle = source.integer("middle", 1, 20);
  all.samples = source.flag("samples");
  all.writes = source.flag("writes the same");
  all.times = source.flag("given times");
  all.event = source.flag("event");
  all.level = source.real("level", -0.5, 0.5);
  if (source.flag("fault")) all.call = source.integer("call", 0, 100);
  // On a grid of dyadic Δt, far from zero is nowhere.
  if (source.flag("far")) all.t0 = plain.t0 = all.controlled ? 0 : std::exp2(source.integer("2^t0", 0, 38));
  Wanted near = plain;
  near.t0 = 0;
  near.saves = all.restart;  // saving forgets Jacobians
  near.middle = all.middle;
  double t = 0.1;
  for (int k = 0; k < 5; ++k, t += source.real("gap", 0.05, 0.5))
    if (t < 2) all.at.push_back(all.t0 + (all.backward ? -t : t));

  const Went expected = go<wraps>(flow, scheme, near), found = go<wraps>(flow, scheme, all);
  source.require(static_cast<bool>(expected.report), "the plain run fails: " + expected.report.message());
  source.require(static_cast<bool>(found.report), "the run fails: " + found.report.message());
  source.require(found.report.t == all.t0 + (all.backward ? -2 : 2), "the run ends elsewhere");
  const State truth = flow.at(all.backward ? 0 : 2);
  const double error = (expected.end - truth).cwiseAbs().maxCoeff();
  if (!all.event && !all.times && all.call < 0) source.require(found.end == expected.end, "bits of the end");
  // Backward e^{a t} grows, by e at most.
  const double allowed = all.controlled ? std::max(10 * 3 * all.rtol, 3 * error) : 3 * error + 1e-12;
  source.bound((found.end - truth).cwiseAbs().maxCoeff(), allowed, "error at the end");
  if (all.controlled) source.bound(found.off, allowed, "error of a look");
}

inline void explicit_euler(Source& source) { pair_up(source, forward_euler, -4); }
template <bool wraps = true>
void trapezoidal_rule(Source& source) {
  pair_up<wraps>(source, trapezoidal, -6);
}
inline void one_step(Source& source) { pair_up(source, tr_bdf2, -6); }
inline void rosenbrock(Source& source) { pair_up(source, rodas4, -8); }
inline void collocation(Source& source) { pair_up(source, radau, -10); }

}  // namespace features

// A step that an event, or a time given, cuts short is a step like any other: same scheme, same order, same error test.
#include <phistep/phistep.hpp>

#include <algorithm>
#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include "support/catch.hpp"

namespace cut_steps {

using phistep::TimeSpan;

/// A problem whose solution is known at all times; its numbers are of order 1.
template <class S>
struct Known {
  std::string name;
  std::function<S(double)> at;
};
template <class S>
[[nodiscard]] double distance(const S& a, const S& b) {
  double most = 0;
  phistep::for_each_block(
      [&](auto, const auto& x, const auto& y) { most = std::max(most, (x - y).cwiseAbs().maxCoeff()); },
      phistep::Blocks<S>::all(a), phistep::Blocks<S>::all(b));
  return most;
}

enum class Cut { none, event, times, samples, last_event };
[[nodiscard]] inline const char* to_string(Cut cut) {
  constexpr const char* names[]{"nothing", "an event without effect", "given times", "samples", "a last event"};
  return names[static_cast<int>(cut)];
}

/// How far a run was off the truth, at worst: wherever somebody looked, and at its end.
struct Seen {
  bool success = false;
  std::string message;
  double off = 0, end = 0;
  int looks = 0;
};

/// The run, cut as wanted. g(t, state) is the event's.
template <class S>
using Runs = std::function<Seen(TimeSpan<double>, double rtol, Cut)>;

template <class S>
[[nodiscard]] Runs<S> runs(Known<S> problem, auto force, auto scheme, std::function<double(double, const S&)> g) {
  return [=](TimeSpan<double> span, double rtol, Cut cut) {
    S state = problem.at(span.t0);
    phistep::PhiStepper stepper{state, force, scheme};
    const phistep::tolerance control{.rtol = rtol, .atol = rtol};
    Seen seen;
    const auto look = [&](double t, const S& y) {
      seen.off = std::max(seen.off, distance(y, problem.at(t)));
      ++seen.looks;
    };
    std::vector<double> times;
    for (double t = 0.137; t < 3 && cut == Cut::times; t += 0.29)
      times.push_back(span.t0 + std::copysign(t, span.t1 - span.t0));
    const bool has_event = cut == Cut::event || cut == Cut::last_event;
    const phistep::RunReport report = [&] {
      if (cut == Cut::none) return integrate(stepper, state, span, control);
      // One instantiation for all kinds: an event that never comes, no time given, one sample at the start.
      return integrate(stepper, state, span, control,
                       phistep::event([&](double t, const S& y) { return has_event ? g(t, y) : 1.0; }, {},
                                      [&, n = 0](double t, S& y) mutable {
                                        if (cut == Cut::event) look(t, y);
                                        return cut == Cut::event || ++n < 3;
                                      }),
                       phistep::at_times(times, [&](double t, S& y) { look(t, y); }),
                       phistep::sampled(cut == Cut::samples ? 0.1 : 100.0, [&](double t, const S& y) {
                         if (cut == Cut::samples) look(t, y);
                       }));
    }();
    seen.success =
        report.outcome == (cut == Cut::last_event ? phistep::Outcome::stopped_by_event : phistep::Outcome::success);
    seen.message = report.message();
    seen.end = distance(state, problem.at(report.t));
    return seen;
  };
}

/// @param backward  whether the problem can be run backward, too: a stiff one can't
inline void check_cuts(const std::string& name, const auto& run, std::initializer_list<double> tolerances,
                       bool backward = true) {
  for (const double rtol : tolerances)
    for (const TimeSpan<double> span : {TimeSpan<double>{0.2, 3.3}, TimeSpan<double>{3.3, 0.2}}) {
      if (span.t1 < span.t0 && !backward) continue;
      const Seen plain = run(span, rtol, Cut::none);
      for (const Cut cut : {Cut::event, Cut::times, Cut::samples, Cut::last_event}) {
        const Seen seen = run(span, rtol, cut);
        CAPTURE(name, rtol, span.t0, to_string(cut), plain.end, seen.off, seen.end, seen.looks, seen.message);
        CHECK(seen.success);
        CHECK(seen.end <= std::max(10 * rtol, 3 * plain.end));
        CHECK(seen.off <= std::max(10 * rtol, 3 * plain.end));
        CHECK((seen.looks >= 3 || cut == Cut::last_event));
      }
    }
}

using Plane = Eigen::Vector2d;
/// y' = a rotation: no damping that forgives
[[nodiscard]] inline Known<Plane> rotation() {
  return {"rotation", [](double t) { return Plane(std::cos(3 * t), std::sin(3 * t)); }};
}
inline const auto turn = [](const Plane& y) -> Plane { return Plane(-3 * y[1], 3 * y[0]); };
/// Stiff along a smooth solution (Prothero & Robinson)
[[nodiscard]] inline Known<Plane> stiff_circle() {
  return {"stiff", [](double t) { return Plane(std::cos(3 * t), std::sin(3 * t)); }};
}
inline const auto drawn_in = [](const Plane& y, double t) -> Plane {
  const Plane on(std::cos(3 * t), std::sin(3 * t));
  return Plane(-3 * on[1] - 1000 * (y[0] - on[0]), 3 * on[0] - 30 * (y[1] - on[1]));
};
inline const std::function<double(double, const Plane&)> height = [](double, const Plane& y) { return y[1] - 0.3; };

using Swing = phistep::Motion<Plane>;
/// Two oscillators, ω = 3 and 2
[[nodiscard]] inline Known<Swing> oscillators() {
  return {"oscillators", [](double t) {
            return Swing{Plane(std::cos(3 * t), std::sin(2 * t)), Plane(-3 * std::sin(3 * t), 2 * std::cos(2 * t))};
          }};
}
inline const auto pull = [](const Plane& r) -> Plane { return Plane(-9 * r[0], -4 * r[1]); };
inline const std::function<double(double, const Swing&)> crossing = [](double, const Swing& y) { return y.r[0] - 0.3; };

[[nodiscard]] inline auto of_rotation(auto scheme) { return runs<Plane>(rotation(), turn, scheme, height); }
[[nodiscard]] inline auto of_stiff(auto scheme) { return runs<Plane>(stiff_circle(), drawn_in, scheme, height); }
[[nodiscard]] inline auto of_motion(auto scheme) { return runs<Swing>(oscillators(), pull, scheme, crossing); }

}  // namespace cut_steps

using namespace cut_steps;

#if PHISTEP_FULL

TEST_CASE("events and given times change nothing of a controlled run: radau") {
  check_cuts("radau", of_rotation(phistep::radau), {1e-4, 1e-6, 1e-9});
}
TEST_CASE("events and given times change nothing of a controlled run: a scheme that estimates, one that looks back") {
  check_cuts("rodas4", of_rotation(phistep::rodas4), {1e-4, 1e-7});
  check_cuts("trapezoidal", of_rotation(phistep::trapezoidal), {1e-3, 1e-5});
}
TEST_CASE("events and given times change nothing of a controlled run: motion, steps in halves") {
  check_cuts("velocity_verlet", of_motion(phistep::velocity_verlet), {1e-3, 1e-5});
}

#elif PHISTEP_STRESS
// A step that an event, or a time given, cuts short is a step like any other: every scheme, forward and backward.

TEST_CASE("events and given times change nothing of a controlled run: first order") {
  check_cuts("radau", of_rotation(phistep::radau), {1e-2, 1e-4, 1e-6, 1e-9, 1e-12});
  check_cuts("radau(3)", of_rotation(phistep::radau(3)), {1e-2, 1e-4, 1e-6});
  check_cuts("rodas4", of_rotation(phistep::rodas4), {1e-2, 1e-4, 1e-6, 1e-8});
  check_cuts("rodas5p", of_rotation(phistep::rodas5p), {1e-2, 1e-4, 1e-6, 1e-8});
}
TEST_CASE("events and given times change nothing of a controlled run: low orders") {
  check_cuts("forward_euler", of_rotation(phistep::forward_euler), {1e-2, 1e-3});
  check_cuts("phi(0.7)", of_rotation(phistep::phi(0.7)), {1e-2, 1e-3});
  check_cuts("trapezoidal", of_rotation(phistep::trapezoidal), {1e-2, 1e-4, 1e-6});
  check_cuts("midpoint", of_rotation(phistep::midpoint), {1e-2, 1e-4, 1e-6});
  check_cuts("backward_euler", of_rotation(phistep::backward_euler), {1e-2, 1e-3});
  check_cuts("tr_bdf2", of_rotation(phistep::tr_bdf2), {1e-2, 1e-4, 1e-6});
}
TEST_CASE("events and given times change nothing of a controlled run: stiff") {
  check_cuts("radau", of_stiff(phistep::radau), {1e-2, 1e-4, 1e-6, 1e-9, 1e-12}, false);
  check_cuts("rodas4", of_stiff(phistep::rodas4), {1e-2, 1e-4, 1e-6, 1e-8}, false);
  check_cuts("trapezoidal", of_stiff(phistep::trapezoidal), {1e-2, 1e-4, 1e-6}, false);
  check_cuts("tr_bdf2", of_stiff(phistep::tr_bdf2), {1e-2, 1e-4, 1e-6}, false);
}
TEST_CASE("events and given times change nothing of a controlled run: motion") {
  check_cuts("velocity_verlet", of_motion(phistep::velocity_verlet), {1e-2, 1e-4, 1e-6});
  check_cuts("rkn86", of_motion(phistep::rkn86), {1e-3, 1e-6, 1e-9});
  check_cuts("rkn1210", of_motion(phistep::rkn1210), {1e-3, 1e-6, 1e-9});
  check_cuts("radau", of_motion(phistep::radau), {1e-4, 1e-6, 1e-9});
  check_cuts("trapezoidal", of_motion(phistep::trapezoidal), {1e-2, 1e-4, 1e-6});
  check_cuts("rodas5p", of_motion(phistep::rodas5p), {1e-4, 1e-6});
}

#endif

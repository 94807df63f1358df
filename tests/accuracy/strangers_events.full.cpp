// Programs with events as users write them, each with its right answer: closed forms, or bisection of one.
#include <phistep/phistep.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include "support/battery.hpp"
#include "support/catch.hpp"
#include "support/shared_force.hpp"

using namespace phistep;

namespace {

using Two = Eigen::Vector2d;
using Rate = shared_force::OfStateAndTime<Two>;

// ---- a ball on a floor, by the time of day ----

template <class T>
struct Bounces {
  Outcome outcome;
  int seen, due;
  double lowest;  ///< [m]
  [[nodiscard]] bool right() const { return outcome == Outcome::success && seen == due && lowest > -0.01; }
};
/// A ball falls from 1 m under 9.81 m/s² and bounces without loss: after 0.4515 s, then each 0.9030 s.
template <class T>
Bounces<T> bounce(auto scheme, double t0, double dt, double length = 10) {
  using V = Eigen::Vector<T, 1>;
  Motion<V> ball{V{T(1)}, V{T(0)}};
  PhiStepper stepper{ball, Gravity{V{T(-9.81)}}, scheme};
  auto floor =
      event([](const auto& y) { return y.r[0]; }, {.direction = Direction::falling}, [](T, auto& y) { y.v = -y.v; });
  double lowest = 1;
  const auto look = [&](T, const auto& y) { lowest = std::min(lowest, static_cast<double>(y.r[0])); };
  const RunReport report = integrate(stepper, ball, {T(t0), T(t0 + length)}, fixed(dt), floor, look);
  const int due = static_cast<int>((length - 0.451524) / 0.903047) + 1;
  return {report.outcome, static_cast<int>(floor.times().size()), due, lowest};
}

const battery::Tally& late_balls() {
  static const battery::Tally counted = [] {
    battery::Tally tally{"a ball on a floor late in the day"};
    const auto count = [&](const char* name, const auto& ball) {
      tally.count(ball.right(), std::string{name} + ": " + std::to_string(ball.seen) + " of " +
                                    std::to_string(ball.due) + " bounces, lowest " + std::to_string(ball.lowest) +
                                    " m");
    };
    // Δt is 1,048 and more, 2,621, 273, 419 and 859 ulp of the time.
    count("float from 0 s, dt 1e-3", bounce<float>(velocity_verlet, 0, 1e-3));
    count("float from 60 s, dt 1e-2", bounce<float>(velocity_verlet, 60, 1e-2));
    count("float from 1000 s, 60 frames a second", bounce<float>(velocity_verlet, 1000, 1.0 / 60));
    count("double from 1.7e9 s, dt 1e-4", bounce<double>(velocity_verlet, 1.7e9, 1e-4));
    count("double from 1.7e9 s, dt 1e-4, trapezoidal", bounce<double>(trapezoidal, 1.7e9, 1e-4));
    count("double from 1e6 s, dt 1e-7", bounce<double>(symplectic_euler, 1e6, 1e-7, 1.6));
    return tally;
  }();
  return counted;
}

// ---- two runs in a row ----

/// How often an event is seen in two runs, 0 … 1 and 1 … 2, where y₀ passes its level within `ulps` of the joint.
template <class Scheme>
int seen_at_the_joint(const Rate& f, Two y0, Scheme scheme, const auto& control, int ulps) {
  double level = 0;
  int seen = 0;
  const auto run = [&](const auto&... observers) {
    Two y = y0;
    PhiStepper stepper{y, f, scheme};
    for (const double t : {0.0, 1.0}) {
      if (!integrate(stepper, y, {t, t + 1}, control, observers...)) seen += 100;
      if (sizeof...(observers) == 0 && t == 0) level = y[0];
    }
  };
  run();
  for (int n = 0; n < std::abs(ulps); ++n) level = std::nextafter(level, ulps > 0 ? 10.0 : -10.0);
  Two y = y0;
  PhiStepper stepper{y, f, scheme};
  auto passes = event([&](const Two& x) { return x[0] - level; }, {}, [&](double, Two&) { ++seen; });
  for (const double t : {0.0, 1.0})
    if (!integrate(stepper, y, {t, t + 1}, control, passes)) seen += 100;
  return seen;
}
template <class Scheme>
battery::Tally joints(const std::string& name, Scheme scheme, const auto& control) {
  battery::Tally tally{"a root where two runs meet, " + name};
  const std::array<std::pair<Rate, Two>, 3> problems{{
      {[](const Two&, double) -> Two {
         return {1, 0};
       },
       {0, 0.5}},
      {[](const Two& y, double) -> Two {
         return {-y[1], y[0]};
       },
       {1, 0.5}},
      {[](const Two& y, double) -> Two {
         return {-3 * (y[0] - 2), -y[1]};
       },
       {1, 0.5}},
  }};
  for (std::size_t n = 0; n < problems.size(); ++n)
    for (int ulps = -12; ulps <= 12; ++ulps) {
      const int seen = seen_at_the_joint(problems[n].first, problems[n].second, scheme, control, ulps);
      tally.count(seen == 1, "problem " + std::to_string(n) + ", " + std::to_string(ulps) + " ulp: seen " +
                                 std::to_string(seen) + " times");
    }
  return tally;
}
const tolerance joint_tolerance{.rtol = 1e-6, .atol = 1e-6};
const battery::Tally& radau_joints() {
  static const battery::Tally counted = joints("radau", radau, joint_tolerance);
  return counted;
}

}  // namespace

TEST_CASE("a ball that bounces without loss: all bounces, in double from 0 and from 1.7e9 s, in float at 1/100 s") {
  for (const auto& ball : {bounce<double>(velocity_verlet, 0, 1e-3), bounce<double>(velocity_verlet, 1.7e9, 1e-3)})
    CHECK(ball.right());
  CHECK(bounce<float>(velocity_verlet, 0, 1e-2).right());
}
TEST_CASE("a ball that bounces late in the day: all bounces") { battery::none(late_balls()); }
TEST_CASE("a ball whose steps are 41 ulp of the time is refused at the start") {
  CHECK(bounce<double>(velocity_verlet, 1.7e12, 0.01).outcome == Outcome::step_too_small);
}

TEST_CASE("a root where one run ends and the next begins is seen once") {
  battery::at_most(0, joints("tsit5", tsit5, joint_tolerance));
  battery::at_most(0, joints("radau(3)", radau(3), joint_tolerance));
  battery::at_most(0, joints("tsit5, fixed steps", tsit5, fixed(0.01)));
}
TEST_CASE("a root where two runs of radau meet is seen once") { battery::none(radau_joints()); }

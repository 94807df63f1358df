// Fast bodies, thin walls and steps that are too long: a body must come back from what it hits with the speed that its law
// says, or preflight, asked before it touches, must say that something is wrong, or the run must not be called a success.
#include <phistep/particles.hpp>
#include <phistep/preflight.hpp>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "accuracy/contact_chance.hpp"
#include "instances/preflight.hpp"
#include "support/battery.hpp"
#include "support/catch.hpp"

using namespace phistep;
using namespace contact_scenes;

constexpr int members = 200;

namespace {

using Vec = Eigen::Vector3d;
using Balls = Particles<double, 3>;

bool says_so(const PreflightReport& report) { return report.verdict != Verdict::fine || !report.finding.empty(); }

/// The same type of force for all scenes.
auto grains(const Hooke& law, std::vector<Wall<3>> walls) { return Contact{law} + Walls{law, std::move(walls)}; }

struct Flight {
  bool said, success;
  double v;  // at the end, along x, of the last ball
};
Flight fly(const Hooke& law, std::vector<Wall<3>> walls, Balls y, double t1, double dt) {
  PhiStepper stepper{y, grains(law, std::move(walls)), symplectic_euler};
  Flight flight{says_so(preflight(stepper, y, dt)), false, 0};
  flight.success = static_cast<bool>(integrate(stepper, y, {0.0, t1}, fixed(dt)));
  flight.v = y.v(0, y.size() - 1);
  return flight;
}

/// One ball against a slab or a plane.
struct Shot {
  double m, R, k, v, e, half, dt, gap;
};
Shot any_shot(Chance& chance) {
  Shot s{};
  s.R = chance.ratio(1e-4, 1e-1), s.m = 4. / 3 * M_PI * std::pow(s.R, 3) * chance.between(500, 8000);
  s.v = chance.ratio(0.1, 1000), s.e = chance.between(0.4, 1);
  // The overlap would be v √(m/k) of a wall without another side: a hundredth to ten times the radius.
  s.k = s.m * std::pow(s.v / (s.R * chance.ratio(1e-3, 10)), 2);
  s.half = s.R * chance.ratio(0.05, 2), s.gap = s.R * chance.between(1, 20);
  s.dt = M_PI * std::sqrt(s.m / s.k) / chance.ratio(0.5, 100);
  return s;
}
void hit_wall(battery::Tally& tally, const Shot& s, bool slab, int n) {
  Balls y{Vec{-s.half - s.R - s.gap, 0, 0}, Vec{s.v, 0, 0}};
  y.set_mass(s.m).set_radius(s.R);
  const Hooke law{.stiffness = s.k, .restitution = s.e};
  const double impact = M_PI * std::sqrt(s.m / s.k), t1 = s.gap / s.v + 6 * impact + 4 * s.dt;
  const Vec half{s.half, 100 * s.R, 100 * s.R};
  const Wall<3> wall =
      slab ? Wall<3>{SolidBox<3>{.center = Vec::Zero(), .half = half}} : Wall<3>{Plane<3>{{-s.half, 0, 0}, {-1, 0, 0}}};
  const Flight f = fly(law, {wall}, y, t1, s.dt);
  tally.count(f.said || !f.success || std::abs(f.v + s.e * s.v) < 0.1 * s.v,
              text(n, ": ", s.v, " m/s at a wall of ", s.half / s.R, " radii, ", impact / s.dt,
                   " steps an impact: ", f.v, " m/s, for -", s.e * s.v));
}
void hit_ball(battery::Tally& tally, const Shot& s, int n) {
  Balls y{Eigen::Matrix<double, 3, 2>{{-s.R - s.gap / 2, s.R + s.gap / 2}, {0, 0}, {0, 0}},
          Eigen::Matrix<double, 3, 2>{{s.v, 0}, {0, 0}, {0, 0}}};
  y.set_mass(2 * s.m).set_radius(s.R);  // m* = m
  const double impact = M_PI * std::sqrt(s.m / s.k), t1 = s.gap / s.v + 6 * impact + 4 * s.dt;
  const Flight f = fly(Hooke{.stiffness = s.k, .restitution = s.e}, {}, y, t1, s.dt);
  const double right = (1 + s.e) * s.v / 2;
  tally.count(f.said || !f.success || std::abs(f.v - right) < 0.1 * s.v,
              text(n, ": ", s.v, " m/s at a ball, ", impact / s.dt, " steps an impact: ", f.v, " m/s, for ", right));
}

/// Asked before anything touches: silent about a short step, not about a long one.
void preflight_before(battery::Tally& tally, Chance& chance, const Shot& s, bool wall, int n) {
  const double impact = M_PI * std::sqrt(s.m / s.k);
  const double steps = chance.ratio(0.05, 100), dt = impact / steps;
  Balls y = wall ? Balls{Vec{-s.R - s.gap, 0, 0}, Vec{s.v, 0, 0}}
                 : Balls{Eigen::Matrix<double, 3, 2>{{-2 * s.R - s.gap, 2 * s.R + s.gap}, {0, 0}, {0, 0}},
                         Eigen::Matrix<double, 3, 2>{{s.v / 2, -s.v / 2}, {0, 0}, {0, 0}}};
  y.set_mass(wall ? s.m : 2 * s.m).set_radius(wall ? s.R : 2 * s.R);  // m* = m
  PhiStepper stepper{y,
                     grains(Hooke{.stiffness = s.k},
                            wall ? std::vector<Wall<3>>{Plane<3>{{0, 0, 0}, {-1, 0, 0}}} : std::vector<Wall<3>>{}),
                     symplectic_euler};
  const PreflightReport report = preflight(stepper, y, dt);
  const bool right = steps > 15  ? report.verdict == Verdict::fine
                     : steps < 8 ? report.verdict != Verdict::fine && !report.finding.empty()
                                 : true;
  tally.count(right, text(n, ": ", steps, " steps an impact: '", describe(report.verdict), "', stable to ",
                          report.stable_dt / impact, " impacts, finding '", report.finding, "'"));
}

struct Tallies {
  battery::Tally planes{.name = "balls at planes"}, slabs{.name = "balls at slabs"}, pairs{.name = "balls at balls"},
      before_touch{.name = "preflight before the touch"};
};
const Tallies& all() {
  static const Tallies counted = [] {
    Tallies tallies;
    Chance chance{8};
    for (int n = 0; n < members; ++n) {
      const Shot s = any_shot(chance);
      hit_wall(tallies.slabs, s, true, n);
      hit_wall(tallies.planes, s, false, n);
      hit_ball(tallies.pairs, s, n);
      preflight_before(tallies.before_touch, chance, s, n % 2 == 0, n);
    }
    return tallies;
  }();
  return counted;
}

}  // namespace

TEST_CASE("balls come back from planes, or preflight says so") { battery::none(all().planes); }
TEST_CASE("balls come back from slabs, or preflight says so") { battery::none(all().slabs); }
TEST_CASE("balls come back from balls, or preflight says so") { battery::none(all().pairs); }
TEST_CASE("preflight finds before the touch that a step is too long") { battery::none(all().before_touch); }

namespace {

/// A ball of 1 mm at a slab of 2 mm: whether it comes back, or preflight or the outcome says that it will not.
bool is_said_or_bounces(double v) {
  Balls y{Vec{-0.5, 0, 0}, Vec{v, 0, 0}};
  y.set_mass(1e-3).set_radius(1e-3);
  const Flight f = fly(Hooke{.stiffness = 1e5, .restitution = 0.9},
                       {SolidBox<3>{.center = {0, 0, 0}, .half = {1e-3, 1, 1}}}, y, 1.0 / v, 1e-5);
  return f.said || !f.success || std::abs(f.v + 0.9 * v) < 0.1 * v;
}

}  // namespace

TEST_CASE("a slow ball comes back from a slab") { CHECK((is_said_or_bounces(1) && is_said_or_bounces(10))); }
TEST_CASE("a ball at 100 m/s doesn't pass a slab unsaid") { CHECK(is_said_or_bounces(100)); }
TEST_CASE("a ball at 1000 m/s doesn't pass a slab unsaid") { CHECK(is_said_or_bounces(1000)); }

TEST_CASE("preflight finds a step of seven impacts, before the touch") {
  Balls y{Eigen::Matrix<double, 3, 2>{{-0.006, 0.006}, {0, 0}, {0, 0}},
          Eigen::Matrix<double, 3, 2>{{50, -50}, {0, 0}, {0, 0}}};
  y.set_radius(0.005).set_mass(0.004);
  PhiStepper stepper{y, grains(Hooke{.stiffness = 1e6}, {}), symplectic_euler};
  const auto report = preflight(stepper, y, 1e-3);
  CHECK_FALSE(report.finding.empty());
}

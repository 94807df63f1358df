// Small programs of grains, bounces and walls, each with its right value.
#include <phistep/particles.hpp>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "support/catch.hpp"

using namespace phistep;

namespace {

using Vec = Eigen::Vector3d;
using Balls = Particles<double, 3>;
constexpr double m = 0.01, R = 0.01, g = 9.81;
const Plane<3> ground{{0, 0, 0}, {0, 0, 1}};
const Gravity weight{Vec{0, 0, -g}};

Balls ball(const Vec& r, const Vec& v) {
  Balls y{r, v};
  y.set_mass(m).set_radius(R);
  return y;
}

/// The same type of force for all scenes.
auto grains(const Hooke& law, std::vector<Wall<3>> walls, double weight_of = 0) {
  return Gravity{Vec{0, 0, -weight_of}} + Contact{law} + Walls{law, std::move(walls)};
}

struct Slid {
  double speed;
  double by_default, with_time;  // what potential_energy said at the end
  double most;                   // of weight, normal spring and a tangential spring at its limit
};
/// A block that slides on a floor with friction.
Slid slide() {
  const Hooke law{.stiffness = 1e4, .restitution = 0.5, .friction = 0.5};
  Balls y = ball({0, 0, R - m * g / law.stiffness}, {1, 0, 0});
  PhiStepper stepper{y, grains(law, {ground}, g), symplectic_euler};
  const auto report = integrate(stepper, y, {0.0, 0.1}, fixed(1e-5));
  REQUIRE(report);
  const double z = y.r(2, 0), limit = 0.5 * m * g;  // [N]
  return {y.v(0, 0), potential_energy(stepper, y), potential_energy(stepper, y, report.t),
          m * g * z + law.stiffness * std::pow(R - z, 2) / 2 + limit * limit / (2 * 2. / 7 * law.stiffness)};
}

}  // namespace

TEST_CASE("a block that slides is slowed by its friction") {
  CHECK(slide().speed == Approx(1 - 0.5 * g * 0.1).epsilon(0.01));
}
TEST_CASE("contacts hold no more energy than their springs can") {
  const Slid end = slide();
  CHECK(end.with_time <= 1.001 * end.most);
}
TEST_CASE("the energy of contacts needs no time named") {
  const Slid end = slide();
  CHECK(end.by_default == Approx(end.with_time).epsilon(1e-6));
}

namespace {

double leaves_at(int boxes) {  // an impact at 1 m/s, e = ½, where the boxes of a floor meet
  std::vector<Wall<3>> walls;
  const double half = boxes == 1 ? 1 : 0.5;
  for (const int i : {-1, 1})
    for (const int j : {-1, 1}) {
      if (boxes == 1 && i + j < 2) continue;
      if (boxes == 2 && j < 0) continue;
      walls.push_back(SolidBox<3>{.center = boxes == 1   ? Vec{0, 0, -0.05}
                                            : boxes == 2 ? Vec{0.5 * i, 0, -0.05}
                                                         : Vec{0.5 * i, 0.5 * j, -0.05},
                                  .half = {half, half, 0.05}});
    }
  Balls y = ball({0, 0, R + 1e-4}, {0, 0, -1});
  PhiStepper stepper{y, grains(Hooke{.stiffness = 1e4, .restitution = 0.5}, walls), symplectic_euler};
  REQUIRE(integrate(stepper, y, {0.0, 0.02}, fixed(1e-6)));
  return y.v(2, 0);
}

}  // namespace

TEST_CASE("a ball leaves one box with its restitution") { CHECK(leaves_at(1) == Approx(0.5).epsilon(0.01)); }
TEST_CASE("a ball leaves the seam of two boxes with its restitution") {
  CHECK(leaves_at(2) == Approx(0.5).epsilon(0.01));
}
TEST_CASE("a ball leaves the corner of four boxes with its restitution") {
  CHECK(leaves_at(4) == Approx(0.5).epsilon(0.01));
}
TEST_CASE("a ball slides over four seams without a loss") {
  std::vector<Wall<3>> walls;
  for (int i = 0; i < 5; ++i) walls.push_back(SolidBox<3>{.center = {0.1 * i, 0, -0.05}, .half = {0.05, 0.5, 0.05}});
  const double k = 1e4;
  Balls y = ball({0, 0, R - m * g / k}, {0.01, 0, 0});
  PhiStepper stepper{y, grains(Hooke{.stiffness = k, .restitution = 0.5}, walls, g), symplectic_euler};
  REQUIRE(integrate(stepper, y, {0.0, 38.0}, fixed(1e-4)));
  CHECK(y.v(0, 0) == Approx(0.01).epsilon(1e-3));
}

namespace {

/// Heights after the bounces of a ball that loses nothing, over the height that it was dropped from.
struct Bounces {
  double lowest = 1, highest = 0;
  int n = 0;
};
Bounces bounces(auto force, double dt) {
  const double h = 0.1;
  Balls y = ball({0, 0, R + h}, Vec::Zero());
  PhiStepper stepper{y, force, symplectic_euler};
  Bounces b;
  double v = 0;
  const auto look = [&](double, const Balls& now) {
    if (now.r(2, 0) <= R) return;
    if (v < 0 && now.v(2, 0) > 0) {
      const double height = (now.r(2, 0) - R + now.v(2, 0) * now.v(2, 0) / 2 / g) / h;
      ++b.n, b.lowest = std::min(b.lowest, height), b.highest = std::max(b.highest, height);
    }
    v = now.v(2, 0);
  };
  REQUIRE(integrate(stepper, y, {0.0, 60.0}, fixed(dt), look));
  return b;
}
const double impact = M_PI * std::sqrt(m / 1e4);  // of Hooke's k = 1e4
const auto elastic = grains(Hooke{.stiffness = 1e4}, {ground}, g);
bool keeps_height(const Bounces& b) { return b.n > 30 && b.lowest > 0.97 && b.highest < 1.03; }

}  // namespace

TEST_CASE("bounces keep their height, Hooke, symplectic Euler, 1/20 of an impact") {
  CHECK(keeps_height(bounces(elastic, impact / 20)));
}
TEST_CASE("bounces keep their height, Hertz, symplectic Euler, 1/20 of an impact") {
  const double modulus = 1e7, v = std::sqrt(2 * g * 0.1);
  const double deepest = std::pow(15. / 16 * m * v * v / (modulus * std::sqrt(R)), 0.4);
  const Bounces b = bounces(weight + Walls{Hertz{.modulus = modulus}, ground}, 2.94 * deepest / v / 20);
  CAPTURE(b.n, b.lowest, b.highest);
  CHECK(keeps_height(b));
}

TEST_CASE("a wall and a pair give back e, whatever the law and the speed") {
  const auto wall = [](auto law, double v) {
    Balls y = ball({0, 0, R + 1e-9}, {0, 0, -v});
    PhiStepper stepper{y, Walls{law, ground}, symplectic_euler};
    REQUIRE(integrate(stepper, y, {0.0, 0.05}, fixed(2e-6)));
    return y.v(2, 0) / v;
  };
  const auto pair = [](auto law, double v) {  // masses m and 5 m
    Balls y{Eigen::Matrix<double, 3, 2>{{0, 0}, {0, 0}, {0, 2 * R + 1e-9}},
            Eigen::Matrix<double, 3, 2>{{0, 0}, {0, 0}, {0, -v}}};
    y.set_mass(Eigen::Vector2d{m, 5 * m}).set_radius(R);
    PhiStepper stepper{y, Contact{law}, symplectic_euler};
    REQUIRE(integrate(stepper, y, {0.0, 0.05}, fixed(2e-6)));
    return (y.v(2, 1) - y.v(2, 0)) / v;
  };
  for (const double e : {0.9, 0.5, 0.1})
    for (const double v : {0.01, 1.0, 10.0}) {
      CAPTURE(e, v);
      const Hooke hooke{.stiffness = 1e5, .restitution = e};
      const Hertz hertz{.modulus = 1e8, .restitution = e};
      CHECK(wall(hooke, v) == Approx(e).margin(0.005));
      CHECK(wall(hertz, v) == Approx(e).margin(0.005));
      CHECK(pair(hooke, v) == Approx(e).margin(0.005));
      CHECK(pair(hertz, v) == Approx(e).margin(0.005));
    }
}
TEST_CASE("a ball that hits an equal one at rest stops there") {
  Balls y{Eigen::Matrix<double, 3, 2>{{0, 0}, {0.03, 0}, {0, 0}}, Eigen::Matrix<double, 3, 2>{{0, 0}, {-1, 0}, {0, 0}}};
  y.set_mass(m).set_radius(R);
  PhiStepper stepper{y, grains(Hooke{.stiffness = 1e4}, {}), symplectic_euler};
  REQUIRE(integrate(stepper, y, {0.0, 0.1}, fixed(1e-5)));
  CHECK(y.v(1, 0) == Approx(0).margin(1e-4));
  CHECK(y.v(1, 1) == Approx(-1).epsilon(1e-4));
}

TEST_CASE("the rolling spring of Hertz has the stiffness that its table says, in any unit of length") {
  // A ball is pressed to a floor and rolled by an angle. k_r = 2/7 k, with k = F_n/δ = (4/3) E* √(R δ).
  const auto torque = [](double metre) {  // over that of the table
    const double radius = 0.01 * metre, modulus = 1e8 / metre, overlap = 1e-5 * metre, dt = 1e-6, rate = 1e-3;
    Particles<double, 3, Spin> y{Vec{0, 0, radius - overlap}};
    y.set_mass(1).set_radius(radius);
    PhiStepper stepper{y, Walls{Hertz{.modulus = modulus, .rolling_friction = 1e9}, ground}, symplectic_euler};
    double found = 0;
    for (int n = 0; n < 5; ++n) {
      y.r(2, 0) = radius - overlap, y.v.setZero(), y.omega.col(0) = Vec{0, rate, 0};
      REQUIRE(stepper.step(y, n * dt, dt));
      found = y.body().inertia(0) * (y.omega(1, 0) - rate) / dt;
    }
    return found / (-2. / 7 * 4 / 3 * modulus * std::sqrt(radius * overlap) * radius * radius * 4 * dt * rate);
  };
  const double in_metres = torque(1), in_millimetres = torque(1000);
  CAPTURE(in_metres, in_millimetres);
  CHECK((in_metres == Approx(1).epsilon(1e-3) && in_millimetres == Approx(1).epsilon(1e-3)));
}

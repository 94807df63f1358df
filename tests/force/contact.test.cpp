// Contacts: what a collision, a throw, a slope and a roll must come to.
#include <Eigen/Geometry>

#include <phistep/force/contact.hpp>
#include <phistep/io/checkpoint.hpp>
#include <phistep/phistep.hpp>
#include <phistep/state/particles.hpp>

#include <array>
#include <cmath>
#include <limits>
#include <random>
#include <sstream>
#include <utility>
#include <vector>

#include "support/catch.hpp"

using namespace phistep;

namespace {

using Grains = Particles<double, 3, Spin>;
using Smooth = Particles<double, 3>;
using Matrix = Eigen::Matrix3Xd;

template <class State = Grains>
State bodies(const Matrix& r, double m = 1, double radius = 0.5) {
  State y{r};
  y.set_mass(m).set_radius(radius);
  return y;
}

struct Collision {
  double restitution, duration;
};

/// Two bodies of mass 1 and radius ½ meet head-on, `speed` fast. The contact ends inside a step: where its overlap or,
/// unless it attracts, its force reaches 0, found from the last state before by Taylor's formula.
template <class Law>
Collision collide(const Law& law, double speed, double dt) {
  Matrix r(3, 2);
  r << -0.5, 0.5, 0, 0, 0, 0;
  auto y = bodies<Smooth>(r);
  y.v << speed / 2, -speed / 2, 0, 0, 0, 0;
  y.r(0, 1) -= 1e-12;  // so that they touch at t = 0: the dashpot acts at once
  PhiStepper stepper{y, Contact{law}, velocity_verlet};
  const auto force = [&](double overlap, double parting) {
    return Law::response(law.numbers(), overlap, parting, 2.0, 4.0).normal;
  };
  double force0 = 0;
  for (int n = 0; n < 100000; ++n) {
    const double overlap0 = 1 - (y.r(0, 1) - y.r(0, 0)), v0 = y.v(0, 1) - y.v(0, 0), before = force0;
    force0 = force(overlap0, v0);
    REQUIRE(stepper.step(y, n * dt, dt));
    const double overlap1 = 1 - (y.r(0, 1) - y.r(0, 0)), v1 = y.v(0, 1) - y.v(0, 0);
    if (law.attracts && overlap1 < 0) {
      const double a = force0 * 2;
      double tau = overlap0 / v0;
      for (int i = 0; i < 5; ++i) tau = (overlap0 - a * tau * tau / 2) / v0;
      return {(v0 + a * tau) / speed, n * dt + tau};
    }
    if (!law.attracts && v1 > 0 && force(overlap1, v1) <= 0) {
      const double slope = (force0 - before) / dt, tau = -force0 / slope;
      return {(v0 + (force0 * tau + slope * tau * tau / 2) * 2) / speed, n * dt + tau};
    }
  }
  FAIL("they stick together");
  return {};
}

/// What is left of Verlet's error of order 2 after Richardson's extrapolation.
template <class Law>
Collision extrapolated(const Law& law, double speed, double dt) {
  const Collision coarse = collide(law, speed, dt), fine = collide(law, speed, dt / 2);
  return {(4 * fine.restitution - coarse.restitution) / 3, (4 * fine.duration - coarse.duration) / 3};
}

}  // namespace

TEST_CASE("a damped spring's collision lasts as long and returns as much as the formula says") {
  // m* = ½, k = 1e5, c = 20; the figures have 9 and 7 digits. At 600 and 1200 steps a contact the errors of e are 1.4e-5 and
  // 3.4e-6; extrapolated, they are of the order of their product with (ωΔt)² = 3e-5.
  SECTION("to the end of the overlap") {
    const Hooke law{.stiffness = 1e5, .restitution = 0.868804629, .attracts = true};
    CHECK(law.numbers().damping * std::sqrt(0.5 * 1e5) == Approx(20).epsilon(1e-8));
    const Collision found = extrapolated(law, 1, 7.031850e-3 / 600);
    CHECK(found.restitution == Approx(0.868804629).epsilon(1e-8));
    CHECK(found.duration == Approx(7.031850e-3).epsilon(1e-7));
    const double exact = 0.868804629, e1 = collide(law, 1, 7.031850e-3 / 300).restitution - exact,
                 e2 = collide(law, 1, 7.031850e-3 / 600).restitution - exact;
    CHECK(std::log2(e1 / e2) == Approx(2).margin(0.05));
  }
  SECTION("to the end of the repulsion") {
    const Hooke law{.stiffness = 1e5, .restitution = 0.872291467};
    CHECK(law.numbers().damping * std::sqrt(0.5 * 1e5) == Approx(20).epsilon(1e-7));
    const Collision found = extrapolated(law, 1, 7.031850e-3 / 600);
    CHECK(found.restitution == Approx(0.872291467).epsilon(1e-8));
    CHECK(found.duration == Approx(6.831583e-3).epsilon(1e-6));
  }
}

TEST_CASE("the restitution of elastic spheres does not depend on the speed of impact") {
  // The dashpot begins with δ^(1/4), that is t^(1/4), so that one step of Verlet is wrong by Δt^(5/4) v^(…): this is the
  // order, and extrapolated with it the errors of 1e-4 at 250 steps a contact become 1e-6.
  const double order = std::pow(2.0, 1.25);
  for (const double e : {0.9, 0.5})
    for (const double speed : {0.01, 10.0}) {
      const Hertz law{.modulus = 1e7, .restitution = e};
      // t = 3.2 (m*²/(R* E*² v))^(1/5)
      const double duration = 3.2 * std::pow(0.25 / (0.25 * 1e14 * speed), 0.2);
      const double e1 = collide(law, speed, duration / 250).restitution - e,
                   e2 = collide(law, speed, duration / 500).restitution - e;
      CAPTURE(e, speed);
      CHECK(std::log2(e1 / e2) == Approx(1.25).margin(0.05));
      CHECK(std::abs(order * e2 - e1) / (order - 1) < 1e-5 * e);
    }
  // Pulling at its end it is as singular there, wherever in its step: (1/500)^(5/4) = 4e-4.
  const Hertz law{.modulus = 1e7, .restitution = 0.5, .attracts = true};
  CHECK(collide(law, 1, 3.2 * std::pow(0.25 / 0.25e14, 0.2) / 500).restitution == Approx(0.5).epsilon(4e-4));
}

TEST_CASE("damping ratios invert their formulas") {
  for (const double e : {1e-3, 0.05, 0.135, std::exp(-2.0), 0.2, 0.5, 0.9, 0.999, 1.0}) {
    CAPTURE(e);
    const double pulls = damping_ratio(e, true), beta = damping_ratio(e, false);
    CHECK(std::exp(-M_PI * pulls / std::sqrt(1 - pulls * pulls)) == Approx(e).epsilon(1e-12));
    const double root = std::sqrt(std::abs(1 - beta * beta));
    // At β = 1 the formula is 0/0; 2 + O(root²) stands for it within 1e-4 of there.
    const double loss = beta < 1   ? beta * std::atan2(2 * beta * root, 2 * beta * beta - 1) / root
                        : beta > 1 ? 2 * beta * std::log(beta + root) / root
                                   : 2;
    CHECK(std::exp(-loss) == Approx(e).epsilon(1e-7));
  }
}

namespace {

Eigen::Vector3d angular_momentum(const Grains& y) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (Index i = 0; i < y.size(); ++i) {
    const Eigen::Vector3d r = y.r.col(i), v = y.v.col(i), w = y.omega.col(i);
    sum += y.mass()[i] * r.cross(v) + 0.4 * y.mass()[i] * y.radius()[i] * y.radius()[i] * w;
  }
  return sum;
}

/// Grains thrown into each other, turning, of two sizes.
Grains jumble(unsigned seed, int n, double spread) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> u(-1, 1);
  Matrix r(3, n), v(3, n), w(3, n);
  Eigen::VectorXd m(n), radius(n);
  for (int i = 0; i < n; ++i) {
    r.col(i) << spread * u(random), spread * u(random), spread * u(random);
    v.col(i) = -3 * r.col(i) + Eigen::Vector3d(u(random), u(random), u(random));
    w.col(i) << 5 * u(random), 5 * u(random), 5 * u(random);
    radius[i] = 0.4 + 0.1 * u(random);
    m[i] = 8 * radius[i] * radius[i] * radius[i];
  }
  Grains y{r};
  y.v = v, y.omega = w;
  y.set_mass(m).set_radius(radius);
  return y;
}

const Hooke rough{.stiffness = 1e3, .restitution = 0.7, .friction = 0.4};

}  // namespace

TEST_CASE("contacts keep momentum and angular momentum") {
  // Kick, then drift: the forces on a pair are opposite, and their torques make up for their moment, at the positions that
  // both see. A few roundings a step of numbers of order 100: 1e-11 over 400 steps.
  const auto check = [](auto law) {
    Grains y = jumble(3, 12, 1.2);
    const Eigen::Vector3d p0 = y.v * y.mass(), l0 = angular_momentum(y);
    PhiStepper stepper{y, Contact{law}, symplectic_euler};
    std::int64_t contacts = 0;
    for (int n = 0; n < 400; ++n) {
      REQUIRE(stepper.step(y, n * 1e-3, 1e-3));
      contacts += stepper.force().statistics().touching;
    }
    CHECK(contacts > 300);
    CHECK((y.v * y.mass() - p0).norm() < 1e-11);
    CHECK((angular_momentum(y) - l0).norm() < 1e-11);
  };
  check(rough);
  check(Hooke{.stiffness = 1e3, .restitution = 0.7, .friction = 0.4, .rolling_friction = 0.1});
  check(Hertz{.modulus = 1e4, .shear_modulus = 7e3, .restitution = 0.7, .friction = 0.4, .rolling_friction = 0.1});
}

TEST_CASE("undamped contacts that stick give back their energy") {
  // Two spheres meet off-centre; the tangential spring takes and gives back. Before and after there are no forces, and
  // symplectic Euler is leapfrog with its first velocity half a step off. What the tangential spring holds when the two
  // part is lost: 2e-6 here, whatever Δt.
  const auto change = [](double dt) {
    Matrix r(3, 2);
    r << -0.501, 0.501, 0, 0.1, 0, 0;
    auto y = bodies(r);
    y.v.row(0) << 1, -1;
    PhiStepper stepper{y, Contact{Hooke{.stiffness = 1e4, .friction = 1e9, .tangential_damping = 0}}, symplectic_euler};
    const auto kinetic = [&] { return (y.v.squaredNorm() + 0.1 * y.omega.squaredNorm()) / 2; };
    const double before = kinetic();
    for (int n = 0; n * dt < 0.05; ++n) REQUIRE(stepper.step(y, n * dt, dt));
    CHECK(stepper.force().statistics().touching == 0);
    CHECK(y.omega.norm() > 0.1);
    return std::abs(kinetic() - before) / before;
  };
  CHECK(change(1e-4) < 1e-4);
  CHECK(change(1e-5) < 5e-6);
}

TEST_CASE("energy of the springs: what the bodies lost") {
  const Hertz law{.modulus = 1e5, .shear_modulus = 8e4, .friction = 1e9, .tangential_damping = 0};
  Matrix r(3, 2);
  r << -0.5, 0.5, 0, 0, 0, 0;
  auto y = bodies(r);
  y.v.row(0) << 0.1, -0.1;
  const double dt = 4e-5;
  PhiStepper stepper{y, Contact{law}, velocity_verlet};
  const auto total = [&] {
    const auto masses = Grains::masses(y);
    return y.v.squaredNorm() / 2 + stepper.force_to_look_at().energy(0.0, Grains::view(y, masses), stepper.memory());
  };
  const double start = total();
  double least = y.v.squaredNorm();
  for (int n = 0; n < 1200; ++n) {
    REQUIRE(stepper.step(y, n * dt, dt));
    least = std::min(least, y.v.squaredNorm());
    REQUIRE(total() == Approx(start).epsilon(1e-5));  // Verlet: (ωΔt)² with ω about 300
  }
  CHECK(least < 0.5 * 0.02);
}

TEST_CASE("history survives that pairs are found anew") {
  // A skin that every step uses up, against one that never is.
  const auto run = [](double skin, std::int64_t& rebuilds) {
    Grains y = jumble(5, 12, 1.2);
    PhiStepper stepper{y, Contact{rough, skin}, symplectic_euler};
    for (int n = 0; n < 300; ++n) REQUIRE(stepper.step(y, n * 1e-3, 1e-3));
    rebuilds = stepper.force().statistics().rebuilds;
    return y;
  };
  std::int64_t many = 0, one = 0;
  const Grains a = run(1e-6, many), b = run(100, one);
  CHECK(one == 1);
  CHECK(many >= 290);
  // Each order of the bodies sums in an order of its own; the scene is chaotic, but not in 300 steps.
  CHECK((a.r - b.r).norm() < 1e-9);
  CHECK((a.omega - b.omega).norm() < 1e-8);
}

TEST_CASE("history survives that other bodies are taken away, or come") {
  // Two bodies pressed together slide; one that is far away goes, and another comes.
  const auto run = [](bool others) {
    Matrix r(3, 2);
    r << 0, 0.99, 0, 0.1, 0, 0;
    auto y = bodies(r);
    if (others) {
      Matrix far(3, 1);
      far << 9, 9, 9;
      Grains front = bodies(far);
      front.add(y);
      y = front;
    }
    const Index first = others ? 1 : 0;
    y.v(1, first) = 0.1;
    PhiStepper stepper{y, Contact{rough}, symplectic_euler};
    const auto steps = [&](int from, int to) {
      for (int n = from; n < to; ++n) REQUIRE(stepper.step(y, n * 1e-3, 1e-3));
    };
    steps(0, 8);
    if (others) y.erase(0);
    steps(8, 14);
    if (others) {
      Matrix far(3, 1);
      far << -9, 9, 9;
      y.add(bodies(far));
    }
    steps(14, 20);
    return std::pair{Matrix(y.r.leftCols(2)), Matrix(y.omega.leftCols(2))};
  };
  const auto a = run(false), b = run(true);
  CHECK(a.second.norm() > 1e-3);
  CHECK((a.first == b.first && a.second == b.second));
}

TEST_CASE("a checkpoint holds the history") {
  Grains y = jumble(7, 12, 1.1);
  const auto make = [](Grains& of) { return PhiStepper{of, Contact{rough, 0.02}, symplectic_euler}; };
  auto stepper = make(y);
  for (int n = 0; n < 60; ++n) REQUIRE(stepper.step(y, n * 1e-3, 1e-3));
  std::stringstream file;
  save_checkpoint(file, y, stepper);
  for (int n = 60; n < 150; ++n) REQUIRE(stepper.step(y, n * 1e-3, 1e-3));

  Grains z = jumble(7, 12, 1.1);
  auto again = make(z);
  load_checkpoint(file, z, again);
  for (int n = 60; n < 150; ++n) REQUIRE(again.step(z, n * 1e-3, 1e-3));
  CHECK((y.r == z.r && y.v == z.v && y.omega == z.omega));
}

TEST_CASE("steps that fail or are taken back leave no trace") {
  const auto run = [](auto scheme, bool disturbed) {
    Grains y = jumble(9, 6, 0.8);
    bool fails = false;
    const auto trouble = [&fails](const Matrix& r, const Matrix&, double) -> Matrix {
      return Matrix::Constant(3, r.cols(), fails ? std::nan("") : 0.0);
    };
    PhiStepper stepper{y, Contact{rough, 0.02} + term(trouble), scheme};
    for (int n = 0; n < 40; ++n) {
      if (disturbed) {
        fails = true;
        REQUIRE_FALSE(stepper.step(y, n * 1e-3, 1e-3));
        fails = false;
        const auto kept = y;
        const auto checkpoint = stepper.checkpoint();
        REQUIRE(stepper.step(y, n * 1e-3, 3e-3));
        y = kept;
        stepper.restore(checkpoint);
      }
      REQUIRE(stepper.step(y, n * 1e-3, 1e-3));
    }
    return y;
  };
  const Grains a = run(symplectic_euler, false), b = run(symplectic_euler, true);
  CHECK((a.r == b.r && a.v == b.v && a.omega == b.omega));
}

TEST_CASE("one pass over the contacts a step where the scheme has one evaluation") {
  Grains y = jumble(9, 6, 0.8);
  PhiStepper stepper{y, Contact{rough}, symplectic_euler};
  for (int n = 0; n < 10; ++n) REQUIRE(stepper.step(y, n * 1e-3, 1e-3));
  CHECK(stepper.force().statistics().evaluations == 10);
}

TEST_CASE("contacts are counted exactly") {
  // A cubic lattice of n³ balls, each touching its neighbours along the axes; the next ones are beyond the skin.
  const int n = 5;
  Matrix r(3, n * n * n);
  for (int i = 0; i < n * n * n; ++i) r.col(i) << i % n, i / n % n, i / n / n;
  auto y = bodies(Matrix(0.99 * r));
  PhiStepper stepper{y, Contact{rough, 0.1}, symplectic_euler};
  REQUIRE(stepper.step(y, 0, 1e-6));
  CHECK(stepper.force().statistics().pairs == 3 * n * n * (n - 1));
  CHECK(stepper.force().statistics().touching == 3 * n * n * (n - 1));
  // Periodic, every ball has six; of two that are held still no pair is made.
  y.set_box(Box<double, 3>::periodic(Eigen::Vector3d::Zero(), Eigen::Vector3d::Constant(0.99 * n)));
  REQUIRE(stepper.step(y, 1e-6, 1e-6));
  CHECK(stepper.force().statistics().touching == 3 * n * n * n);
  std::vector<std::uint8_t> still(static_cast<std::size_t>(n * n * n), 0);
  for (int i = 0; i < n * n; ++i) still[static_cast<std::size_t>(i)] = 1;  // a layer: 2n² pairs in it
  y.set_still(still);
  REQUIRE(stepper.step(y, 2e-6, 1e-6));
  CHECK(stepper.force().statistics().touching == 3 * n * n * n - 2 * n * n);
}

TEST_CASE("in the plane bodies do what they do in space") {
  Grains y = jumble(11, 10, 1.2);
  y.r.row(2).setZero(), y.v.row(2).setZero(), y.omega.topRows(2).setZero();
  Particles<double, 2, Spin> z{y.r.topRows(2)};
  z.v = y.v.topRows(2), z.omega = y.omega.row(2);
  z.set_mass(y.mass()).set_radius(y.radius());
  PhiStepper space{y, Contact{rough}, symplectic_euler};
  PhiStepper plane{z, Contact{rough}, symplectic_euler};
  for (int n = 0; n < 200; ++n) {
    REQUIRE(space.step(y, n * 1e-3, 1e-3));
    REQUIRE(plane.step(z, n * 1e-3, 1e-3));
  }
  CHECK((y.r.topRows(2) == z.r && y.v.topRows(2) == z.v && y.omega.row(2) == z.omega));
}

TEST_CASE("units change no bit") {
  // Length by 4, mass by 2, time by 8.
  const auto run = [](double length, double mass, double time) {
    Grains y = jumble(13, 10, 1.2);
    const double stiffness = mass / (time * time);
    y.r *= length, y.v *= length / time, y.omega /= time;
    y.set_mass((mass * y.mass()).eval()).set_radius((length * y.radius()).eval());
    Hooke law{.stiffness = 1e3 * stiffness, .restitution = 0.7, .friction = 0.4, .rolling_friction = 0.1};
    PhiStepper stepper{y, Contact{law}, symplectic_euler};
    for (int n = 0; n < 100; ++n) REQUIRE(stepper.step(y, n * 1e-3 * time, 1e-3 * time));
    y.r /= length, y.v *= time / length, y.omega *= time;
    return y;
  };
  const Grains a = run(1, 1, 1), b = run(4, 2, 8);
  CHECK((a.r == b.r && a.v == b.v && a.omega == b.omega));
}

TEST_CASE("bodies of float") {
  Grains y = jumble(15, 10, 1.2);
  Particles<float, 3, Spin> z{y.r.cast<float>()};
  z.v = y.v.cast<float>(), z.omega = y.omega.cast<float>();
  z.set_mass(y.mass().cast<float>().eval()).set_radius(y.radius().cast<float>().eval());
  PhiStepper a{y, Contact{rough}, symplectic_euler};
  PhiStepper b{z, Contact<Hooke, float>{rough}, symplectic_euler};
  for (int n = 0; n < 60; ++n) {
    REQUIRE(a.step(y, n * 1e-3, 1e-3));
    REQUIRE(b.step(z, static_cast<float>(n) * 1e-3f, 1e-3f));
  }
  CHECK((y.r - z.r.cast<double>()).norm() < 1e-4);
}

TEST_CASE("every pair of types has its law") {
  // Two soft ones, and a soft with a hard one, pushed together alike.
  const auto push = [](int a, int b) {
    Matrix r(3, 2);
    r << 0, 0.99, 0, 0, 0, 0;
    auto y = bodies(r);
    y.set_type(Eigen::Vector2i(a, b));
    Materials<Hooke> materials{2, Hooke{.stiffness = 100}};
    materials.set(0, 1, Hooke{.stiffness = 1000});
    PhiStepper stepper{y, Contact{materials}, symplectic_euler};
    REQUIRE(stepper.step(y, 0, 1));
    return y.v(0, 1);
  };
  CHECK(push(0, 0) == Approx(1));
  CHECK(push(1, 0) == Approx(10));
  CHECK(push(0, 1) == Approx(10));
  CHECK(push(1, 1) == Approx(1));
}

TEST_CASE("what can't work is said, with the body's number") {
  Matrix r(3, 3);
  r << 0, 2, 4, 0, 0, 0, 0, 0, 0;
  const auto step = [](auto& y, const auto& contact) {
    PhiStepper stepper{y, contact, symplectic_euler};
    return stepper.step(y, 0, 1e-3);
  };
  Particles<double, 3> bare{r};
  CHECK_THROWS_WITH(step(bare, Contact{rough}), contains("radii"));
  for (const double bad : {0.0, -1.0, std::nan(""), HUGE_VAL}) {
    CHECK_THROWS_WITH(bare.set_radius(Eigen::Vector3d(1, bad, 1)), contains("particle 1"));
    CHECK_THROWS_WITH(bare.set_mass(Eigen::Vector3d(1, 1, bad)), contains("particle 2"));
    CHECK_THROWS_WITH(Contact{Hooke{.stiffness = bad}}, contains("stiffness"));
    CHECK_THROWS_WITH(Contact{Hertz{.modulus = bad}}, contains("modulus"));
  }
  for (const double bad : {0.0, -0.1, 1.0001, std::nan("")})
    CHECK_THROWS_WITH(Contact(Hooke{.stiffness = 1, .restitution = bad}), contains("restitution"));
  CHECK_THROWS_WITH(Contact(Hooke{.stiffness = 1, .friction = -1}), contains("friction"));
  CHECK_THROWS_WITH(Contact(rough, -1), contains("skin"));
  auto typed = bodies(r);
  typed.set_type(Eigen::Vector3i(0, 1, 2));
  CHECK_THROWS_WITH(step(typed, Contact{Materials<Hooke>{2, rough}}), contains("particle 2"));
  auto lost = bodies(r);
  lost.r(1, 2) = std::nan("");
  const StepReport report = step(lost, Contact{rough});
  CHECK_FALSE(report);
  Grains none{Matrix(3, 0)};
  none.set_radius(1.0);
  CHECK_NOTHROW(step(none, Contact{rough}));
  Matrix same = Matrix::Zero(3, 2);
  auto one_place = bodies(same);
  CHECK(step(one_place, Contact{rough}));
  CHECK(one_place.v.norm() == 0);
}

TEST_CASE("tangents of resting bodies equal differences") {
  // Without slip and speed nothing is left out. The tangential spring is one in v here: what it adds in a step's time is
  // k_t τ v.
  Matrix r(3, 3);
  r << 0, 0.98, 0.5, 0, 0.1, 0.9, 0, 0.05, 0.1;
  auto y = bodies<Smooth>(r);
  const auto check = [&](auto law) {
    const Contact contact{law, 0.3};
    const auto masses = Smooth::masses(y);
    const double tau = 1e-3;
    auto memory = typename decltype(contact)::Memory{};
    contact.begin(0.0, tau, Smooth::view(y, masses), memory);
    const auto force = [&](const Smooth& at) {
      auto psi = make_rate<Smooth>(at);
      contact.add(tau, Smooth::view(at, masses), memory, psi);
      return Eigen::VectorXd(psi.force.reshaped());
    };
    struct Dense {
      Eigen::MatrixXd K = Eigen::MatrixXd::Zero(9, 9), C = K;
      void position(Index i, Index j, double x) { K(i, j) += x; }
      void velocity(Index i, Index j, double x) { C(i, j) += x; }
    } sink;
    contact.add_jacobian(tau, Smooth::view(y, masses), memory, sink);
    const double h = 1e-6;
    for (Index j = 0; j < 9; ++j) {
      Smooth a = y, b = y;
      a.r.data()[j] -= h, b.r.data()[j] += h;
      const Eigen::VectorXd k = (force(b) - force(a)) / (2 * h);
      CHECK((k - sink.K.col(j)).norm() < 1e-4 * sink.K.norm());
      a = y, b = y;
      a.v.data()[j] -= h, b.v.data()[j] += h;
      const Eigen::VectorXd c = (force(b) - force(a)) / (2 * h);
      CHECK((c - sink.C.col(j)).norm() < 1e-4 * sink.C.norm());
    }
    CHECK(sink.K.norm() > 100);
    CHECK(sink.C.norm() > 1);
  };
  check(Hooke{.stiffness = 1e3, .restitution = 0.7, .friction = 10});
  check(Hertz{.modulus = 1e4, .shear_modulus = 7e3, .restitution = 0.7, .friction = 10});
}

TEST_CASE("a pile settles by implicit steps of many times an impact") {
  // Backward Euler at φ = 1 on a column of three bodies that weigh on each other and on one that is held.
  Matrix r(3, 4);
  r << 0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 2, 3;
  auto y = bodies<Smooth>(r);
  y.set_still({1, 0, 0, 0});
  const double g = 10, k = 1e4;
  PhiStepper stepper{y, Gravity{Eigen::Vector3d(0, 0, -g)} + Contact{Hooke{.stiffness = k, .restitution = 0.5}},
                     backward_euler};
  const double dt = 0.1;  // of 0.022 that an impact lasts
  for (int n = 0; n < 60; ++n) REQUIRE(stepper.step(y, n * dt, dt));
  // Each spring carries what is above it.
  for (int i = 1; i < 4; ++i) CHECK(1 - (y.r(2, i) - y.r(2, i - 1)) == Approx((4 - i) * g / k).epsilon(1e-9));
  CHECK(y.v.norm() < 1e-9);
}

TEST_CASE("the shortest impact is known to preflight") {
  Matrix r(3, 2);
  r << 0, 2, 0, 0, 0, 0;
  auto y = bodies<Smooth>(r);
  y.v.row(0) << 0.5, -0.5;
  const auto masses = Smooth::masses(y);
  const auto time = [&](const auto& contact) { return contact.contact_time(Smooth::view(y, masses)); };
  CHECK(time(Contact{Hooke{.stiffness = 1e5}}) == Approx(M_PI * std::sqrt(0.5 / 1e5)));
  // 2.943 δ/v: 2.87 (m*²/(R* E*² v))^(1/5) [K. L. Johnson, Contact Mechanics, (11.24)], printed to three digits
  CHECK(time(Contact{Hertz{.modulus = 1e7}}) == Approx(2.87 * std::pow(0.25 / (0.25 * 1e14), 0.2)).epsilon(2e-3));
}

// Steps against their formulas, and undone: every scheme. The quick half: stepper.test.cpp.
#include <phistep/phistep.hpp>

#include <cmath>
#include <vector>

#include "contract/states.hpp"
#include "contract/stepper_battery.hpp"
#include "contract/stepper_cases.hpp"
#include "support/catch.hpp"

using namespace phistep;
using namespace states;

TEST_CASE("dt < 0 undoes a step with the adjoint scheme") {
  // endpoint φ(h), then endpoint 1−φ(−h)
  SecondOrder<Dynamic> c;
  const Eigen::VectorXd before = numbers(c.state);
  PhiStepper forth{c.state, damped_pull, phi(0.3)};
  PhiStepper back{c.state, damped_pull, phi(0.7)};
  REQUIRE(forth.step(c.state, 0, 0.1));
  CHECK(distance(numbers(c.state), before) > 0.01);
  REQUIRE(back.step(c.state, 0.1, -0.1));
  CHECK(distance(numbers(c.state), before) <= 1e-14);

  PhiStepper verlet{c.state, dynamic_pull, velocity_verlet};
  REQUIRE(verlet.step(c.state, 0, 0.1));
  REQUIRE(verlet.step(c.state, 0.1, -0.1));
  CHECK(distance(numbers(c.state), before) <= 1e-14);
}

TEST_CASE("named schemes are their formulas") {
  // m v' = −k r, one step from (r, v), φ by φ, against the source's two lines solved by hand.
  const double k = 3, m = 2, h = 0.3, r = 0.7, v = -0.4, w = k / m;
  const auto one_step = [&](auto scheme) {
    using V = Eigen::Matrix<double, 1, 1>;
    Motion<V> y{V(r), V(v)};
    PhiStepper stepper{y, [k](const V& x) -> V { return -k * x; }, scheme, mass(m)};
    return stepper.step(y, 0, h) ? Eigen::Vector2d(y.r[0], y.v[0]) : Eigen::Vector2d(NAN, NAN);
  };
  const auto formula = [&](double pf, double pd) {
    // v⁺ = v − h w (pf r⁺ + (1−pf) r),  r⁺ = r + h (pd v⁺ + (1−pd) v)
    const double v1 = (v - h * w * (r + pf * h * (1 - pd) * v)) / (1 + h * h * w * pf * pd);
    return Eigen::Vector2d(r + h * (pd * v1 + (1 - pd) * v), v1);
  };
  const auto compare = [](const Eigen::Vector2d& stepped, const Eigen::Vector2d& expected) {
    CHECK((stepped - expected).norm() <= 1e-15);
  };
  const auto check = [&](auto scheme, const Eigen::Vector2d& expected) { compare(one_step(scheme), expected); };
  check(forward_euler, formula(0, 0));
  check(trapezoidal, formula(0.5, 0.5));
  check(backward_euler, formula(1, 1));
  check(midpoint, formula(0.5, 0.5));
  check(symplectic_euler, formula(0, 1));
  check(symplectic_euler_adjoint, formula(1, 0));
  check(phi(0.7), formula(0.7, 0.7));
  check(phi(0.2, 0.9), formula(0.2, 0.9));
  check(phi_stage(0.3), formula(0.3, 0.3));
  // (I − aA)(r⁺, v⁺) = b with A(r, v) = (v, −w r)
  const auto resolved = [&](double a, const Eigen::Vector2d& b) {
    const double v1 = (b[1] - a * w * b[0]) / (1 + a * a * w);
    return Eigen::Vector2d(b[0] + a * v1, v1);
  };
  const auto advanced = [&](double a, const Eigen::Vector2d& y) {
    return Eigen::Vector2d(y[0] + a * y[1], y[1] - a * w * y[0]);
  };
  const Eigen::Vector2d y{r, v};
  const double g = 2 - std::sqrt(2.0);
  const Eigen::Vector2d Y = resolved(g / 2 * h, advanced(g / 2 * h, y));
  check(tr_bdf2, resolved((1 - g) / (2 - g) * h, Y / (g * (2 - g)) - y * (1 - g) * (1 - g) / (g * (2 - g))));
  check(rannacher, resolved(h / 2, resolved(h / 2, y)));
  check(rannacher(0), resolved(h / 2, advanced(h / 2, y)));
  const double half = v - h / 2 * w * r, r1 = r + h * half;
  check(velocity_verlet, Eigen::Vector2d(r1, half - h / 2 * w * r1));
}

TEST_CASE("forces are asked at the times of the formulas") {
  std::vector<double> times;
  const shared_force::OfMotionAndTime<Dynamic> force = [&times](const Dynamic& r, const Dynamic& v,
                                                                double t) -> Dynamic {
    if (times.empty() || times.back() != t) times.push_back(t);
    return -r - v;
  };
  const auto asked = [&](auto scheme) {
    SecondOrder<Dynamic> c;
    PhiStepper stepper{c.state, force, scheme};
    times.clear();
    return stepper.step(c.state, 1.0, 0.5) ? times : std::vector<double>{};
  };
  using Times = std::vector<double>;
  CHECK(asked(forward_euler) == Times{1.0});
  CHECK(asked(symplectic_euler) == Times{1.0});
  CHECK(asked(symplectic_euler_adjoint) == Times{1.5});
  CHECK(asked(trapezoidal) == Times{1.0, 1.5});
  CHECK(asked(backward_euler) == Times{1.5});
  CHECK(asked(midpoint) == Times{1.25});
  CHECK(asked(phi_stage(0.7)) == Times{1.0 + 0.7 * 0.5});
  CHECK(asked(velocity_verlet) == Times{1.0, 1.5});
  CHECK(asked(tr_bdf2) == Times{1.0, 1.0 + (2 - std::sqrt(2.0)) * 0.5, 1.5});
  CHECK(asked(rannacher) == Times{1.25, 1.5});
  CHECK(asked(rannacher(0)) == Times{1.0, 1.5});
}

// The forms of a force with velocity or time, with and without Jacobian. In short: force.test.cpp.
#include <phistep/autodiff.hpp>

#include <cmath>
#include <functional>
#include <memory>
#include <stdexcept>

#include "contract/force_cases.hpp"
#include "contract/states.hpp"
#include "support/catch.hpp"

using namespace phistep;
using namespace force_cases;

TEST_CASE("f(r, v): returning, accumulating, with Jacobian, as a sum, by automatic differentiation") {
  const Steps expected = steps(damped);
  check_same(steps(Adding{}), expected);
  const Steps analytic = steps(WithJacobian{});
  check_same(analytic, expected);
  check_same(steps(term(pull) + LinearDrag{c}), expected);
  const Steps dual = steps(autodiff([](const auto& r, const auto& v) {
    std::remove_cvref_t<decltype(r)> f = r;
    for (Eigen::Index i = 0; i < r.size(); ++i) f[i] = -k * r[i] - c * v[i];
    return f;
  }));
  check_same(dual, expected);
  // Differences call the force; a Jacobian of its own, or by AD, saves those calls.
  CHECK(analytic.newton_counts.force_calls < expected.newton_counts.force_calls);
  CHECK(dual.newton_counts == analytic.newton_counts);
}

TEST_CASE("f(r, v, t): time arrives") {
  check_same(steps(driven), steps(AddingTimed{}));
  CHECK(distance(steps(driven).explicit_, steps(damped).explicit_) > 0.1);
}

TEST_CASE("first order: f(y) and f(y, t), with and without Jacobian") {
  const auto run = [](auto force) {
    Vec y = Eigen::Vector3d(1, 2, 3);
    PhiStepper stepper{y, force, trapezoidal};
    for (int n = 0; n < 10; ++n) REQUIRE(stepper.step(y, 0.1 * n, 0.1));
    return y;
  };
  struct Analytic {
    Vec operator()(const Vec& y, double t) const { return (-y.array().cube() + std::cos(t)).matrix(); }
    Eigen::MatrixXd jacobian(const Vec& y, double) const { return (-3 * y.array().square()).matrix().asDiagonal(); }
  };
  const Vec expected = run([](const Vec& y, double t) -> Vec { return -y.array().cube() + std::cos(t); });
  CHECK(distance(run(Analytic{}), expected) <= 1e-13);
  CHECK(distance(run(autodiff([](const auto& y, double t) {
                   std::remove_cvref_t<decltype(y)> f = y;
                   for (Eigen::Index i = 0; i < y.size(); ++i) f[i] = -y[i] * y[i] * y[i] + std::cos(t);
                   return f;
                 })),
                 expected) <= 1e-13);
}

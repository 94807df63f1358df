// Rosenbrock schemes: orders, stability and dense output of each, in every scalar; the quick half is rosenbrock.test.cpp.
#include <cmath>

#include "problems/hires.hpp"
#include "schemes/rosenbrock_cases.hpp"

using namespace rosenbrock_cases;

namespace {

void for_each_scheme(auto&& f) { f(rodas4), f(rodas5p); }

}  // namespace

// Jacobians by differences leave 1e-8 of h² in each step: below 1e-11 that is what is seen.
TEST_CASE("order 4 and 5: a flow and a damped motion, nonlinear, non-autonomous, with a mass") {
  for_each_scheme([](auto scheme) {
    const int p = scheme.order(), coarsest = p == 4 ? 20 : 30;
    CAPTURE(p);
    check_order(errors(coarsest, [&](int n) { return flow_error(scheme, n); }), p, 0.2);
    check_order(errors(coarsest, [&](int n) { return motion_error(scheme, n); }), p, 0.2);
  });
}

namespace {
struct SpringsAndCooling : ForceTerm {
  static void add(double, const auto& y, auto& out) {
    out.force -= 4 * y.r;
    out.heat -= 2 * y.temperature;
  }
};
}  // namespace

TEST_CASE("particles that heat up: more unknowns than positions") {
  Particles<double, 3, Temperature> y{Eigen::Matrix3Xd::Constant(3, 4, 1.0)};
  y.temperature.setConstant(1);
  PhiStepper stepper{y, SpringsAndCooling{}, rodas4};
  for (int n = 0; n < 100; ++n) problems::step(stepper, y, 0.01 * n, 0.01);
  CHECK((y.r.array() - std::cos(2.0)).abs().maxCoeff() < 1e-7);
  CHECK((y.temperature.array() - std::exp(-2.0)).abs().maxCoeff() < 1e-7);
}

TEST_CASE("particles held still: their force says nothing of the Jacobian") {
  Particles<double, 3> chain{Eigen::Matrix3Xd{{0, 1.2, 2.1}, {0, 0, 0}, {0, 0, 0}}};
  chain.set_still({1, 0, 0});
  const auto force = [](const Eigen::Matrix3Xd& r) -> Eigen::Matrix3Xd {  // springs of length 1, nonlinear
    Eigen::Matrix3Xd f = Eigen::Matrix3Xd::Zero(3, 3);
    for (int i = 0; i < 2; ++i) {
      const Eigen::Vector3d d = r.col(i + 1) - r.col(i), pull = 10 * (d.norm() - 1) * d.normalized();
      f.col(i) += pull, f.col(i + 1) -= pull;
    }
    return f;
  };
  PhiStepper pulled{chain, banded(force, 8, 8), rodas4};
  auto bound = chain;
  REQUIRE(integrate(pulled, bound, {0.0, 1.0}, tolerance{.rtol = 1e-8}));
  CHECK(pulled.statistics().checks > 0);
  PhiStepper reference{chain, force, tsit5};
  auto other = chain;
  REQUIRE(integrate(reference, other, {0.0, 1.0}, tolerance{.rtol = 1e-10}));
  CHECK((bound.r - other.r).norm() <= 1e-6);
  CHECK(bound.r.col(0).norm() <= 1e-30);
}

TEST_CASE("what a step costs, and what a rejected one leaves for the next try") {
  check_cost(problems::Hires::start(), problems::Hires{}, rodas5p, 8);
}

TEST_CASE("L-stable: nothing is left of what is infinitely stiff, and nothing grows on the left half-plane") {
  for_each_scheme([](auto scheme) {
    check_l_stable([&](double z) {
      const problems::Dahlquist problem{z};
      problems::Dahlquist::State y{1};
      PhiStepper stepper{y, problem, scheme};
      problems::step(stepper, y, 0.0, 1.0);
      return y[0];
    });
  });
  // Oscillators: A-stable along the imaginary axis. K is a difference, good to √u.
  using One = Eigen::Matrix<double, 1, 1>;
  for (double omega = 1e-2; omega < 1e6; omega *= 3) {
    Motion<One> y{One{1.0}, One{0.0}};
    PhiStepper stepper{y, [omega](const One& r) -> One { return -omega * omega * r; }, rodas5p};
    problems::step(stepper, y, 0.0, 1.0);
    CHECK(std::hypot(y.r[0], y.v[0] / omega) <= 1 + 1e-7);
  }
}

TEST_CASE("dense output: order 3 and 4 inside the step, and its ends") {
  // A continuous extension of order q leaves h^{q+1} inside of one step.
  for_each_scheme(
      [](auto scheme) { check_order(errors(20, [&](int n) { return dense_error(scheme, n); }), scheme.order(), 0.2); });
}

TEMPLATE_TEST_CASE("every scalar: order 4 above the floor of its rounding", "", float, long double) {
  using T = TestType;
  using Flow = problems::ForcedFlow<T>;
  const auto e = errors(2, [](int n) {
    const auto y = Flow::exact(0);
    PhiStepper stepper{y, Flow{}, rodas4, capacity(T(Flow::capacity))};
    return distance(march(stepper, y, T(0), T(2), n), Flow::exact(2));
  });
  CHECK(e[0] / e[2] > std::exp2(2 * 3.2));
  CHECK(e[0] / e[2] < std::exp2(2 * 5.0));
}

TEST_CASE("where double precision ends, it says so") {
  auto y = problems::Hires::start();
  PhiStepper stepper{y, problems::Hires{}, rodas5p};
  CHECK(integrate(stepper, y, {0.0, 1e-3}, tolerance{.rtol = 1e-14, .atol = 1e-18}).outcome ==
        Outcome::invalid_tolerance);
  CHECK(y == problems::Hires::start());
  CHECK(integrate(stepper, y, {0.0, 1e-3}, tolerance{.rtol = 1e-13, .atol = 1e-17}));
}

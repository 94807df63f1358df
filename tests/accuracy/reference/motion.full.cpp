// In short: accuracy/reference/stiff.test.cpp.
// Motions against CVODE at fixed steps: the order at which they approach its solution, and how near they come. Where
// the solution is known to 17 digits, CVODE is checked first. The bounds are the errors found, rounded up: a truncation
// error depends on neither compiler nor machine.

#include <phistep/sparse.hpp>

#include <cmath>

#include "accuracy/observed_order.hpp"
#include "accuracy/reference/cvode.hpp"
#include "problems/damped_pendulum.hpp"
#include "problems/kepler.hpp"
#include "problems/march.hpp"
#include "problems/show_digits.hpp"
#include "problems/spring_net.hpp"
#include "problems/van_der_pol.hpp"
#include "support/catch.hpp"

using problems::DampedPendulum;
using problems::Kepler;
using problems::SpringNet;
using problems::VanDerPol;

namespace {

const reference::Vector unit = reference::Vector::Ones(1);

/// Order and error of runs of n, 2n, 4n and 8n steps to t = end.
template <class State>
void check(const State& start, auto force, auto scheme, double end, const State& by_cvode, double order, int n,
           double bound, auto... mass) {
  const auto errors = convergence::errors(n, [&](int steps) {
    phistep::PhiStepper stepper{start, force, scheme, mass...};
    return problems::distance(problems::march(stepper, start, 0.0, end, steps), by_cvode);
  });
  convergence::check_order(errors, order);
  CAPTURE(errors[3]);
  CHECK(errors[3] <= bound);
}

}  // namespace

TEST_CASE("Van der Pol, mu = 5, over one jump: the schemes converge to CVODE") {
  const auto start = VanDerPol::start();
  const auto by_cvode = reference::cvode(
      start, [](const auto& y) { return VanDerPol{}(y.r, y.v); }, unit, VanDerPol::end, 1e-13);
  REQUIRE(problems::distance(by_cvode, VanDerPol::exact()) <= 1e-9);
  const auto test = [&](auto scheme, double order, int n, double bound) {
    check(start, VanDerPol{}, scheme, VanDerPol::end, by_cvode, order, n, bound);
  };
  test(phistep::forward_euler, 1, 4000, 1.35e-3);
  test(phistep::backward_euler, 1, 4000, 1.35e-3);
  test(phistep::trapezoidal, 2, 1000, 2.9e-6);
  test(phistep::midpoint, 2, 1000, 2.9e-6);
  test(phistep::velocity_verlet, 2, 1000, 7e-6);
}

TEST_CASE("damped pendulum: the schemes converge to CVODE") {
  const auto start = DampedPendulum::start();
  const auto by_cvode = reference::cvode(
      start, [](const auto& y) { return DampedPendulum{}(y.r, y.v); }, unit, DampedPendulum::end, 1e-13);
  REQUIRE(problems::distance(by_cvode, DampedPendulum::exact()) <= 1e-9);
  const auto test = [&](auto scheme, double order, int n, double bound) {
    check(start, DampedPendulum{}, scheme, DampedPendulum::end, by_cvode, order, n, bound);
  };
  test(phistep::forward_euler, 1, 2000, 1.3e-3);
  test(phistep::backward_euler, 1, 2000, 1.3e-3);
  test(phistep::phi(0.75), 1, 2000, 6.5e-4);
  test(phistep::trapezoidal, 2, 200, 1.45e-5);
  test(phistep::midpoint, 2, 200, 1.25e-5);
  test(phistep::velocity_verlet, 2, 200, 8.3e-6);
}

TEST_CASE("Kepler, e = 0.6, half a period and a bit: the schemes converge to CVODE") {
  const Kepler kepler;
  constexpr double end = 4;
  const auto start = kepler.start();
  const auto by_cvode = reference::cvode(
      start, [&](const auto& y) { return kepler(y.r); }, reference::Vector::Ones(2), end, 1e-13);
  REQUIRE(problems::distance(by_cvode, kepler.exact(end)) <= 1e-9);
  const auto test = [&](auto scheme, double order, int n, double bound) {
    check(start, kepler, scheme, end, by_cvode, order, n, bound);
  };
  test(phistep::symplectic_euler, 1, 4000, 7.8e-4);
  test(phistep::backward_euler, 1, 16000, 3.4e-3);
  test(phistep::trapezoidal, 2, 400, 1.35e-4);
  test(phistep::midpoint, 2, 400, 9e-5);
  test(phistep::velocity_verlet, 2, 400, 7.2e-5);
}

TEMPLATE_TEST_CASE_SIG("spring net, elastic and damped: the schemes converge to CVODE", "", ((bool damped), damped),
                       false, true) {
  const auto springs = [] {
    if constexpr (damped) return SpringNet::damped();
    else return SpringNet::elastic();
  }();
  constexpr double end = 2;
  const auto start = SpringNet::start();
  const auto force = [&springs](const SpringNet::State& y) {
    SpringNet::State::Rate out{Eigen::VectorXd::Zero(y.r.size())};
    springs.add(0.0, y, out);
    return out.force;
  };
  const auto by_cvode = reference::cvode(start, force, SpringNet::masses(), end, 1e-13);
  const auto test = [&](auto scheme, double order, int n, double bound) {
    check(start, springs, scheme, end, by_cvode, order, n, bound, phistep::mass(SpringNet::masses()));
  };
  test(phistep::forward_euler, 1, 4000, 1.9e-3);
  test(phistep::backward_euler, 1, 1000, 7.5e-3);
  test(phistep::trapezoidal, 2, 100, 1.5e-4);
  test(phistep::midpoint, 2, 100, 1.5e-4);
  test(phistep::velocity_verlet, 2, 100, 8.8e-5);
}

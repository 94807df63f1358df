// Stiff reactions against CVODE, with fixed sequences of steps: what is asserted is the order at which the scheme
// approaches CVODE's solution, and how near it comes. The bounds are the errors found, rounded up: a truncation error
// depends on neither compiler nor machine.

#include <phistep/phistep.hpp>

#include <cmath>
#include <stdexcept>
#include <vector>

#include "accuracy/observed_order.hpp"
#include "accuracy/reference/cvode.hpp"
#include "problems/hires.hpp"
#include "problems/march.hpp"
#include "problems/robertson.hpp"
#include "problems/show_digits.hpp"
#include "support/catch.hpp"

using problems::Hires;
using problems::Robertson;

namespace {

/// t_k = τ [(1 + T/τ)^(k/n) − 1]: short steps at first, then steps in proportion to t. Being a smooth map of equal
/// steps it keeps the error's expansion in 1/n, and it resolves a transient of length τ that equal steps would miss.
std::vector<double> graded(double end, double tau, int n) {
  std::vector<double> t(static_cast<std::size_t>(n) + 1);
  for (int k = 0; k <= n; ++k) t[static_cast<std::size_t>(k)] = tau * std::expm1(std::log1p(end / tau) * k / n);
  t.back() = end;
  return t;
}

/// A reaction scheme, CVODE's solution of it, and what its components are measured by.
template <class Problem>
struct Reference {
  using State = typename Problem::State;
  State by_cvode, scale;
  double tau;

  Reference(const State& measure, double transient, double atol) : scale{measure}, tau{transient} {
    const auto f = [](double, const reference::Vector& y) -> reference::Vector { return Problem{}(State(y)); };
    by_cvode = reference::cvode(f, Problem::start(), Problem::end, atol * measure);
  }
  [[nodiscard]] double distance(const State& a, const State& b) const { return (a - b).cwiseQuotient(scale).norm(); }
  [[nodiscard]] double error(auto scheme, int n) const {
    const State y = Problem::start();
    phistep::PhiStepper stepper{y, Problem{}, scheme};
    return distance(problems::march(stepper, y, graded(Problem::end, tau, n)), by_cvode);
  }
  /// Order and error of runs of n, 2n, 4n and 8n steps.
  void check(auto scheme, double order, int n, double bound) const {
    const auto errors = convergence::errors(n, [&](int steps) { return error(scheme, steps); });
    convergence::check_order(errors, order);
    CHECK(errors[3] <= bound);
  }
};

}  // namespace

TEST_CASE("Robertson to t = 40: CVODE agrees with the quadruple-precision digits") {
  const Reference<Robertson> reference{Robertson::scale(), 1e-3, 1e-14};
  // CVODE's global error is a modest multiple of its rtol = 1e-12.
  CHECK(reference.distance(reference.by_cvode, Robertson::exact()) <= 1e-10);
}

TEST_CASE("Robertson to t = 40: fixed sequences of steps converge to CVODE") {
  const Reference<Robertson> reference{Robertson::scale(), 1e-3, 1e-14};
  reference.check(phistep::backward_euler, 1, 100, 2.2e-3);
  reference.check(phistep::phi(0.75), 1, 200, 5.5e-4);
  reference.check(phistep::trapezoidal, 2, 100, 8.1e-6);
  reference.check(phistep::midpoint, 2, 100, 6.3e-6);
}

TEST_CASE("Robertson: a backward Euler step over the transient finds the positive of its two roots") {
  // The step's equation is quadratic in y₂. From y₂ = 0, where Ψ is flat in y₂, the negative root is one careless
  // iteration away: one more with the first matrix overshoots by 3e7 y₂².
  for (const double h : {1e-4, 5e-4, 1.8e-3, 1e-2, 0.1}) {
    Robertson::State y = Robertson::start();
    phistep::PhiStepper stepper{y, Robertson{}, phistep::backward_euler};
    problems::step(stepper, y, 0.0, h);
    CAPTURE(h, y[1]);
    CHECK(y[1] > 0);
    CHECK(std::abs(y.sum() - 1) <= 1e-15);
  }
}

TEST_CASE("HIRES to t = 321.8122: CVODE agrees with the published digits") {
  const Reference<Hires> reference{Hires::exact(), 10, 1e-13};
  CHECK(reference.distance(reference.by_cvode, Hires::exact()) <= 1e-9);
}

TEST_CASE("HIRES to t = 321.8122: fixed sequences of steps converge to CVODE") {
  const Reference<Hires> reference{Hires::exact(), 10, 1e-13};
  reference.check(phistep::backward_euler, 1, 800, 1.5e-2);
  reference.check(phistep::phi(0.75), 1, 1600, 4e-3);
  reference.check(phistep::trapezoidal, 2, 400, 1.2e-4);
  reference.check(phistep::midpoint, 2, 800, 6e-5);
}

TEST_CASE("CVODE's failures are not swallowed") {
  const auto broken = [](double, const reference::Vector&) -> reference::Vector { throw std::logic_error("no"); };
  const reference::Vector one = reference::Vector::Ones(1);
  CHECK_THROWS_AS(reference::cvode(broken, one, 1.0, one), std::logic_error);
  const auto decay = [](double, const reference::Vector& y) -> reference::Vector { return -y; };
  CHECK_THROWS_AS(reference::cvode(decay, one, 1.0, -one), std::runtime_error);  // a negative tolerance
}

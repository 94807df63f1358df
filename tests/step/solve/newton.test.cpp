#include <phistep/step/solve/newton.hpp>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

#include "support/catch.hpp"

using namespace phistep;

namespace {

/// F(x) = 0 in one unknown, with Newton's matrix at will.
struct Scalar {
  std::function<double(double)> F, dF;
  double x = 1;
  bool factors = false;
  double slope = 0, value = 0, move = 0, start = 0;
  int jacobians = 0, solves = 0, retreats = 0;
  double scale = 1;   // what rounding may have touched
  double weight = 0;  // > 0: sizes are relative to this instead of to x
  double rate = 0;    // of the solve before

  Outcome residual() {
    value = F(x);
    return std::isfinite(value) ? Outcome::success : Outcome::non_finite_force;
  }
  [[nodiscard]] bool has_jacobian() const { return factors; }
  [[nodiscard]] bool has_factors() const { return factors; }
  Outcome refresh() {
    slope = dF(x), factors = true, ++jacobians;
    return slope != 0 ? Outcome::success : Outcome::singular_matrix;
  }
  Outcome correct() {
    ++solves;
    x += move = -value / slope;
    return Outcome::success;
  }
  [[nodiscard]] bool residual_is_rounding() const { return value == 0; }
  [[nodiscard]] bool residual_is_noise() const {
    return std::abs(value) <=
           8 * std::numeric_limits<double>::epsilon() * std::abs(slope) * std::max(scale, std::abs(x));
  }
  [[nodiscard]] double residual_size() const { return std::abs(value); }
  void retreat() { ++retreats, x -= move /= 2; }
  void undo() { x -= move; }
  void restart() { x = start; }
  [[nodiscard]] Correction size() const {
    const double size = std::abs(move);
    if (weight > 0) return {size / weight, size / weight, size};
    return {size / std::abs(x), size / std::max(scale, std::abs(x)), size};
  }
  void drop_jacobian() { factors = false; }

  Outcome solve(NewtonOptions options = {}) {
    SolveRecord history;
    start = x;
    return solve_newton(*this, options, std::numeric_limits<double>::epsilon(), history, rate);
  }
};

}  // namespace

TEST_CASE("finds a root to rounding") {
  Scalar eq{[](double x) { return x * x - 2; }, [](double x) { return 2 * x; }};
  CHECK(eq.solve() == Outcome::success);
  CHECK(std::abs(eq.x - std::sqrt(2.0)) <= 4e-16);
}

TEST_CASE("a linear equation takes one Jacobian and keeps it") {
  Scalar eq{[](double x) { return 3 * x - 7; }, [](double) { return 3.0; }};
  CHECK(eq.solve() == Outcome::success);
  CHECK(eq.jacobians == 1);
  CHECK(eq.solves <= 2);
  CHECK(eq.factors);
  eq.x = 5;
  CHECK(eq.solve() == Outcome::success);
  CHECK(eq.jacobians == 1);
}

TEST_CASE("a slow Jacobian is renewed, and not kept") {
  Scalar eq{[](double x) { return std::exp(x) - 1; }, [](double x) { return std::exp(x); }, 2};
  CHECK(eq.solve() == Outcome::success);
  CHECK(std::abs(eq.x) <= 1e-15);
  CHECK(eq.jacobians > 1);
  CHECK_FALSE(eq.factors);
}

TEST_CASE("where the root is zero, corrections that fall as fast as the iterate still fall") {
  // A velocity that comes to rest. With 6 % of the slope missing, ‖δ‖/|x| is 17 each time: no plateau of rounding.
  Scalar eq{[](double x) { return (1 + x) - 1; }, [](double) { return 0.94; }, 3e-9};
  CHECK(eq.solve() == Outcome::success);
  CHECK(std::abs(eq.x) <= 2e-16);
}

TEST_CASE("a first correction that was right by luck doesn't end a solve") {
  // 1e-3, then 1e-10, which promises 1e-17: but what if the matrix is good for 1e-3 a time and no more?
  using enum Judgement;
  constexpr double round_off = std::numeric_limits<double>::epsilon();
  const auto judged = [&](double last_rate, double second) {
    ConvergenceTest test({}, round_off, last_rate);
    CHECK(test.judge(1, {1e-3, 1e-3, 1e-3}, true, true) == go_on);
    return test.judge(2, {second, second, second}, true, true);
  };
  CHECK(judged(0, 1e-10) == go_on);  // nothing is known of the matrix
  CHECK(judged(1e-3, 1e-10) == go_on);
  CHECK(judged(1e-7, 1e-10) == converged);
  CHECK(judged(1e-3, 1e-13) == converged);
  CHECK(judged(0, 1e-15) == converged);

  // A slope wrong by 1e-3 and a curvature that hides it from the first correction, but for 1e-8 of that.
  Scalar eq{[](double x) { return (x - 1) * (1 - 1e-3 * (1 - (x - 1) / 0.0316)); }, [](double) { return 1.0; },
            1.0316 + 0.0316e-5};
  CHECK(eq.solve() == Outcome::success);
  CHECK(std::abs(eq.x - 1) <= 4e-16);
}

TEST_CASE("an old, far too stiff matrix does not pass for convergence") {
  // Contact that opened, or an edit between two steps: the kept slope is 1e13 times the true one.
  for (const double ratio : {1e6, 1e10, 1e13, 1e17, 1e30}) {
    Scalar eq{[](double x) { return x - 3; }, [](double) { return 1.0; }};
    eq.factors = true, eq.slope = ratio;
    CAPTURE(ratio);
    CHECK(eq.solve() == Outcome::success);
    CHECK(eq.x == Approx(3).epsilon(1e-14));
  }
}

TEST_CASE("no solve fails for what an earlier one has left") {
  // With as few corrections as a new one needs: those on the old matrix don't count.
  const auto F = [](double x) { return std::exp(x) - 2; };
  const auto dF = [](double x) { return std::exp(x); };
  int compared = 0;
  for (const double rtol : {0.0, 1e-6})
    for (const bool line_search : {false, true})
      for (int most = 2; most <= 12; ++most)
        for (const double slope : {1e-3, 0.3, -1.0, 40.0, 1e6}) {
          const NewtonOptions options{.rtol = rtol, .atol = rtol, .max_iterations = most, .line_search = line_search};
          Scalar fresh{F, dF, 3.0}, old{F, dF, 3.0};
          if (fresh.solve(options) != Outcome::success) continue;
          ++compared;
          old.factors = true, old.slope = slope;
          CAPTURE(rtol, line_search, most, slope);
          CHECK(old.solve(options) == Outcome::success);
          if (rtol == 0) CHECK(old.x == Approx(fresh.x).epsilon(1e-14));
        }
  CHECK(compared >= 50);
}

TEST_CASE("a cycle ends as stalled, not in a hang or in success") {
  Scalar eq{[](double x) { return x > 0 ? 1.0 : -1.0; }, [](double) { return 1.0; }, 0.5};
  CHECK(eq.solve() == Outcome::newton_stalled);
  CHECK(eq.solves == 2 * 25);  // once as it is, once damped
  eq.x = 0.5, eq.solves = 0;
  CHECK(eq.solve({.max_iterations = 7}) == Outcome::newton_stalled);
  CHECK(eq.solves == 2 * 7);
}

TEST_CASE("where plain Newton diverges or cycles, damped corrections find the root") {
  // x/√(1+x²) sends x to −x³: away from ±1 it diverges, at 1 it cycles.
  const auto F = [](double x) { return x / std::sqrt(1 + x * x); };
  const auto dF = [](double x) { return std::pow(1 + x * x, -1.5); };
  for (const double start : {1.0, 1.2, -3.0}) {
    Scalar plain{F, dF, start};
    plain.weight = 1;
    CAPTURE(start);
    CHECK(plain.solve() == Outcome::success);
    CHECK(std::abs(plain.x) <= 1e-15);
    if (start == 1.0) CHECK(plain.retreats > 0);
    Scalar damped{F, dF, start};
    damped.weight = 1;
    CHECK(damped.solve({.line_search = true}) == Outcome::success);
    CHECK(std::abs(damped.x) <= 1e-15);
    CHECK(damped.retreats > 0);
    CHECK(damped.solves <= 12);
  }
}

TEST_CASE("damping is not tried where the plain iteration converges") {
  Scalar eq{[](double x) { return x * x - 2; }, [](double x) { return 2 * x; }};
  CHECK(eq.solve() == Outcome::success);
  CHECK(eq.retreats == 0);
}

TEST_CASE("a slope of the wrong sign ends as diverged") {
  Scalar eq{[](double x) { return x - 3; }, [](double) { return -0.5; }};
  eq.weight = 1;
  CHECK(eq.solve() == Outcome::newton_diverged);
  eq.x = 1;
  CHECK(eq.solve({.rtol = 1e-6, .atol = 1e-6}) == Outcome::newton_diverged);
}

TEST_CASE("a zero slope is reported as it came") {
  Scalar eq{[](double) { return 1.0; }, [](double) { return 0.0; }};
  CHECK(eq.solve() == Outcome::singular_matrix);
}

TEST_CASE("an iterate outside the domain is taken back, the start is not") {
  Scalar eq{[](double x) { return std::log(x); }, [](double x) { return 1 / x; }, 20};  // first move lands at −40
  CHECK(eq.solve() == Outcome::success);
  CHECK(eq.x == Approx(1).epsilon(1e-14));
  CHECK(eq.retreats > 0);
  eq.x = -1, eq.retreats = 0;
  CHECK(eq.solve() == Outcome::non_finite_force);
  CHECK(eq.retreats == 0);
}

TEST_CASE("a force that is finite nowhere ends after a bounded number of retreats") {
  int calls = 0;
  Scalar eq{[&calls](double) { return ++calls == 1 ? 1.0 : std::nan(""); }, [](double) { return 1.0; }};
  CHECK(eq.solve() == Outcome::non_finite_force);
  CHECK(eq.retreats == 10);
}

TEST_CASE("with a tolerance it stops earlier") {
  const auto F = [](double x) { return std::exp(x) - 2; };
  const auto dF = [](double x) { return std::exp(x); };
  Scalar exact{F, dF, 1.5}, loose{F, dF, 1.5};
  CHECK(exact.solve() == Outcome::success);
  CHECK(loose.solve({.rtol = 1e-3, .atol = 1e-3}) == Outcome::success);
  CHECK(loose.solves < exact.solves);
}

TEST_CASE("RADAU5's tolerance for the stage equations") {
  CHECK(solve_rtol(1e-6) == Approx(1e-5));
  CHECK((ConvergenceTest({}, 1e-16).allows(25) && !ConvergenceTest({}, 1e-16).allows(26)));
  CHECK((ConvergenceTest({.rtol = 1e-6}, 1e-16).allows(7) && !ConvergenceTest({.rtol = 1e-6}, 1e-16).allows(8)));
  CHECK((ConvergenceTest({.max_iterations = 3}, 1e-16).allows(3) &&
         !ConvergenceTest({.max_iterations = 3}, 1e-16).allows(4)));
}

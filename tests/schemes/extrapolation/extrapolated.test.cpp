// Extrapolated steps: the order of every column, what a step costs, what a failed one leaves.
#include "schemes/extrapolation/extrapolated_cases.hpp"

#include <string>

#include "problems/e5.hpp"

using namespace extrapolated_cases;

namespace {

struct OnE5 {
  std::string trouble;
  double error;  ///< at t = 1e5, max |y_i − exact_i| / (|exact_i| + 1e-22)
};
/// E5 to t = 1e5 at rtol = 1e-10.
OnE5 on_e5(auto scheme) {
  Eigen::Vector4d y = problems::E5::start();
  PhiStepper stepper{y, problems::E5{}, scheme};
  const auto report = integrate(stepper, y, {0, 1e5}, tolerance{.rtol = 1e-10, .atol = 1e-32});
  const Eigen::Array4d exact = problems::E5::at_1e5();
  return {report ? "" : report.message(), ((y.array() - exact) / (exact.abs() + 1e-22)).abs().maxCoeff()};
}

}  // namespace

// The measure itself: found 0.05 rtol.
TEST_CASE("E5 to t = 1e5: a success of Rodas5P is one") {
  const auto [trouble, error] = on_e5(rodas5p);
  CHECK(trouble.empty());
  CHECK(error <= 10 * 1e-10);
}

// Found 430 rtol; at t = 1e11, where y₂ = y₃ + y₄ must hold as it does in each step's linear equations, off by more than y₂.
// The roundings of the columns are magnified, and two columns of one table share them: no estimate sees it. Fails until
// extrapolation leaves or sees its rounding.
TEST_CASE("E5 to t = 1e5: a success of extrapolated backward Euler is one", "[!shouldfail]") {
  const auto [trouble, error] = on_e5(extrapolated(backward_euler));
  CHECK(trouble.empty());
  CHECK(error <= 10 * 1e-10);
}
TEST_CASE("E5 to t = 1e11: extrapolated backward Euler keeps y2 = y3 + y4, or says that it doesn't", "[!shouldfail]") {
  Eigen::Vector4d y = problems::E5::start();
  PhiStepper stepper{y, problems::E5{}, extrapolated(backward_euler)};
  const auto report = integrate(stepper, y, {0, 1e11}, tolerance{.rtol = 1e-6, .atol = 1e-28});
  CHECK((!report || std::abs(y[1] - y[2] - y[3]) <= 1e-2 * std::abs(y[1])));  // Radau: 4e-4
}

TEST_CASE("column k has order k, linearly implicit: a flow and a damped motion, in long double") {
  for (int k = 1; k <= 6; ++k) {
    CAPTURE(k);
    const auto exact = linear_flow(10, 200);
    check_order([&](int steps) { return distance(linear_flow(k, steps), exact); }, steps_for(k), k);
  }
}

TEST_CASE("column k has order 2k, explicit: Gragg's rule for a flow, Verlet's for a motion, in long double") {
  using T = long double;
  for (int k = 1; k <= 4; ++k) {
    CAPTURE(k);
    const typename PendulumFlow<T>::Two y{T(1), T(0.5)};
    const auto flow = [&](int columns, int steps) {
      PhiStepper stepper{y, PendulumFlow<T>{}, extrapolated(forward_euler, columns)};
      return march(stepper, y, T(0), T(2), steps);
    };
    const auto exact = flow(8, 60);
    check_order([&](int steps) { return distance(flow(k, steps), exact); }, k < 3 ? 80 : 20, 2 * k);
    using One = typename Swing<T>::One;
    const Motion<One> z{One{T(1)}, One{T(0.5)}};
    const auto motion = [&](int columns, int steps) {
      PhiStepper stepper{z, Swing<T>{}, extrapolated(velocity_verlet, columns)};
      return march(stepper, z, T(0), T(2), steps);
    };
    const auto moved = motion(8, 60);
    check_order([&](int steps) { return distance(motion(k, steps), moved); }, k < 3 ? 40 : 10, 2 * k);
  }
}

TEST_CASE("what a step of k columns costs, exactly") {
  std::int64_t never = 0;
  check_costs(problems::Robertson::start(), Failing{&never});
  using T = long double;
  using One = Swing<T>::One;
  Motion<One> r{One{T(1)}, One{T(0.5)}};
  PhiStepper verlet{r, Swing<T>{}, extrapolated(velocity_verlet, 3)};
  REQUIRE(verlet.step(r, T(0), T(1e-3)));
  CHECK(verlet.statistics().force_calls == 1 + 2 + 4 + 6);
  CHECK(verlet.statistics().factorizations == 0);
}

TEST_CASE("a force that fails in any call of a step leaves every bit, and says so") {
  const Eigen::Vector3d start = problems::Robertson::start();
  for (std::int64_t call = 1; call <= 12; ++call) {
    for (const bool watched : {false, true}) {
      Eigen::Vector3d y = start;
      std::int64_t left = call;
      PhiStepper stepper{y, Failing{&left}, extrapolated(backward_euler, 4)};
      Trace<Eigen::Vector3d> trace;
      trace.resize(y);
      trace.weight.setOnes();
      trace.rtol = 1e-6;
      const StepReport report =
          watched ? stepper.attempt(y, 0.0, 1e-3, Origin::unknown, trace, [](auto&...) { return true; })
                  : stepper.step(y, 0.0, 1e-3);
      CAPTURE(call, watched, report.message());
      // In rows 1 and 2 of a watched step, a NaN shows as a correction that doesn't shrink.
      if (!watched) CHECK(report.outcome() == Outcome::non_finite_force);
      CHECK_FALSE(report);
      CHECK(y == start);
      left = 0;
      REQUIRE(stepper.step(y, 0.0, 1e-3));  // and the next try is a new one
    }
  }
  // In a run, a shorter step gets around a single one.
  Eigen::Vector3d y = start;
  std::int64_t left = 40;
  PhiStepper stepper{y, Failing{&left}, extrapolated(backward_euler)};
  const auto report = integrate(stepper, y, {0, 40}, tolerance{.rtol = 1e-6, .atol = 1e-12});
  REQUIRE(report);
  CHECK((y - problems::Robertson::exact()).cwiseQuotient(problems::Robertson::scale()).lpNorm<Eigen::Infinity>() <=
        1e-5);
}

TEST_CASE("no columns, too many columns") {
  CHECK_THROWS_AS(extrapolated(backward_euler, -1), std::invalid_argument);
  CHECK_THROWS_AS(extrapolated(backward_euler, most_columns + 1), std::invalid_argument);
}

// All ten problems are in extrapolated_row.full.cpp and extrapolated_row_motions.stress.cpp.
TEST_CASE("the error is proportional to the tolerance, from 1e-2 to where double ends") {
  std::int64_t never = 0;
  double first = 0, last = 0;
  for (int digits = 2; digits <= 12; ++digits) {
    const double rtol = std::pow(10.0, -digits);
    Eigen::Vector3d y = problems::Robertson::start();
    PhiStepper stepper{y, Failing{&never}, extrapolated(backward_euler)};
    const auto report = integrate(stepper, y, {0, 40}, tolerance{.rtol = rtol, .atol = rtol * 1e-6});
    CAPTURE(rtol, report.message());
    REQUIRE(report);
    const Eigen::Array3d exact = problems::Robertson::exact().array();
    last = ((y.array() - exact).abs() / (exact.abs() + 1e-6)).maxCoeff();
    if (digits == 2) first = last;
    CHECK(last <= 10 * 1.4 * rtol);  // κ = 1.4
  }
  CHECK(std::log10(first / last) / 10 >= 0.8);
  CHECK(std::log10(first / last) / 10 <= 1.15);
}

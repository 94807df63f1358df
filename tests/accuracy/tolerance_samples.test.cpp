// A state inside of a step is as accurate as those at its ends, and to look at it changes nothing. Here one scheme of each
// kind: Hermite's interpolant, a continuous extension, the pairs', step doubling. All of them: tolerance_samples*.full.cpp.
//
// Found before states inside were checked, in units of rtol, where the ends were right to 4: 2e3 (TR-BDF2, stiff), 1e5
// (Rodas4, stiff), 4e6 (Radau, stiff), 400 (rkn1210), 90 (rkn86), 8e5 (srkn11b), 1e6 (composed).
#include "accuracy/tolerance_samples_cases.hpp"

using namespace samples;

#if PHISTEP_FULL
// A state inside of a step is as accurate as those at its ends: first-order schemes of order 1 and 2.

TEST_CASE("samples are as accurate as steps") {
  check_flow("forward Euler", forward_euler, smooth, 3, 5);
  check_flow("phi = 0.7", phi(0.7), smooth, 3, 5);
  check_flow("phi = 0.7", phi(0.7), stiff, 3, 4);
  check_flow("backward Euler", backward_euler, smooth, 3, 5);
  check_flow("backward Euler", backward_euler, stiff, 3, 4);
  check_flow("trapezoidal", trapezoidal, smooth, 3, 8);
  check_flow("trapezoidal", trapezoidal, stiff, 3, 7);
  check_flow("midpoint", midpoint, smooth, 3, 8);
  check_flow("midpoint", midpoint, stiff, 3, 6);
  check_flow("TR-BDF2", tr_bdf2, smooth, 3, 8);
  check_flow("TR-BDF2", tr_bdf2, stiff, 3, 7);
  check_flow("Rannacher", rannacher, smooth, 3, 8);
  check_flow("Rannacher", rannacher, stiff, 3, 7);
}

TEST_CASE("samples in a step that an event has cut are the cut step's") {
  using One = Eigen::Matrix<double, 1, 1>;
  for (const auto& [fast, rtol] : {std::pair{1e4, 3.313e-11}, std::pair{1e2, 1e-7}, std::pair{1e2, 1.3e-7}}) {
    const double rate = fast;
    One y{0.0};
    PhiStepper stepper{y, [rate](const One& x, double t) { return One{-rate * (x[0] - std::sin(t)) + std::cos(t)}; },
                       radau};
    double off = 0, ends = 0;
    auto look = sampled(0.0417, [&](double t, const One& x) { off = std::max(off, std::abs(x[0] - std::sin(t))); });
    const auto end = [&](double t, const One& x) { ends = std::max(ends, std::abs(x[0] - std::sin(t))); };
    auto cut = event([](const One& x) { return x[0] - 0.3; });
    REQUIRE(integrate(stepper, y, {0.0, 12.0}, tolerance{.rtol = rtol}, look, end, cut));
    CAPTURE(fast, rtol, ends / rtol);
    CHECK(off <= 4 * std::max(ends, 30 * rtol));
  }
}

TEST_CASE("samples on a way into a narrow pass are as right as those before") {
  using Two = Eigen::Vector2d;
  const auto at = [](double t) {
    double E = t;
    for (int i = 0; i < 60; ++i) E -= (E - 0.6 * std::sin(E) - t) / (1 - 0.6 * std::cos(E));
    const double d = 1 - 0.6 * std::cos(E);
    return Motion<Two>{Two{std::cos(E) - 0.6, 0.8 * std::sin(E)}, Two{-std::sin(E) / d, 0.8 * std::cos(E) / d}};
  };
  int over = 0;
  for (double rtol = 1e-6; rtol > 1e-10; rtol /= 1.25) {
    Motion<Two> y = at(0.1);
    PhiStepper stepper{y, [](const Two& r) -> Two { return -r / std::pow(r.norm(), 3); }, rkn1210};
    double off = 0, ends = 0;
    const auto error = [&](double t, const Motion<Two>& x) { return (x.v - at(t).v).norm(); };
    auto look = sampled(0.0417, [&](double t, const Motion<Two>& x) { off = std::max(off, error(t, x)); });
    const auto end = [&](double t, const Motion<Two>& x) { ends = std::max(ends, error(t, x)); };
    REQUIRE(integrate(stepper, y, {0.1, 7.0}, tolerance{.rtol = rtol}, look, end));
    CAPTURE(rtol, off / rtol, ends / rtol);
    CHECK(off <= 20 * std::max(ends, 2 * rtol));
    over += off > 4 * std::max(ends, 2 * rtol);
  }
  CHECK(over <= 3);
}

#endif

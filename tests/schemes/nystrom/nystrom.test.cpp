// Runge-Kutta-Nyström pairs: conditions, orders, counts, masses, interpolation, tolerances, failures.
#include "schemes/nystrom/nystrom_cases.hpp"

using namespace nystrom_cases;

TEST_CASE("the published coefficients meet their conditions") {
  check_conditions<Rkn86>(6, 2);
  check_conditions<Rkn1210>(10, 4);
}

TEST_CASE("orders 8 and 12 in long double, 7 and 11 of the estimate") {
  // The next term moves the observed order by O(h): 0.05 at most for the one; four steps of the other are long ones.
  check_order(errors(8, [](int n) { return error_at_end<long double>(rkn86, n); }), 8, 0.1);
  const double e4 = error_at_end<long double>(rkn1210, 4), e8 = error_at_end<long double>(rkn1210, 8);
  CAPTURE(e4, e8);  // 2e-13 and 4e-17; the next halving would end in rounding
  CHECK(std::abs(std::log2(e4 / e8) - 12) <= 0.4);
  const auto estimate = [](auto scheme, long double h) {
    using Problem = problems::DrivenMotion<long double>;
    auto y = Problem::exact(0.4L);
    PhiStepper stepper{y, Problem{}, scheme, mass(static_cast<long double>(Problem::mass))};
    Trace<Problem::State> trace;
    trace.resize(y);
    double size = 0;
    const auto look = [&](const auto&, const auto&, const auto& told) {
      size = distance(told.error.r, Eigen::Matrix<long double, 2, 1>::Zero()) +
             distance(told.error.v, Eigen::Matrix<long double, 2, 1>::Zero());
      return true;
    };
    REQUIRE(stepper.attempt(y, 0.4L, h, Origin::unknown, trace, look));
    return size;
  };
  CHECK(std::log2(estimate(rkn86, 0.05L) / estimate(rkn86, 0.025L)) == Approx(7).margin(0.2));
  CHECK(std::log2(estimate(rkn1210, 0.3L) / estimate(rkn1210, 0.15L)) == Approx(11).margin(0.4));
}

TEST_CASE("force calls: eight a step, the last of them for the next one; seventeen") {
  const auto calls = [](auto scheme, int steps) {
    auto y = six();
    PhiStepper stepper{y, Hardening{}, scheme};
    for (int n = 0; n < steps; ++n) problems::step(stepper, y, 0.1 * n, 0.1);
    return stepper.statistics().force_calls;
  };
  CHECK(calls(rkn86, 10) == 8 * 10 + 1);
  CHECK(calls(rkn1210, 10) == 17 * 10);
}

TEST_CASE("inside a step: of orders 7 and 6, 9 and more, in r and v") {
  using L = long double;
  using Problem = problems::DrivenMotion<L>;
  const auto inside = [](auto scheme, L h) {  // the largest errors of r and v
    auto y = Problem::exact(0.3L), out = y;
    const auto start = y;
    PhiStepper stepper{y, Problem{}, scheme, mass(static_cast<L>(Problem::mass))};
    Trace<Problem::State> trace;
    trace.resize(y);
    trace.wants_dense = true;
    REQUIRE(stepper.attempt(y, 0.3L, h, Origin::unknown, trace, [](auto&&...) { return true; }));
    double r = 0, v = 0;
    for (int k = 1; k < 20; ++k) {
      const L x = static_cast<L>(k) / 20;
      stepper.interpolate(x, h, start, y, out);
      r = std::max(r, distance(out.r, Problem::exact(0.3L + x * h).r));
      v = std::max(v, distance(out.v, Problem::exact(0.3L + x * h).v));
    }
    stepper.interpolate(1 - 1e-15L, h, start, y, out);
    CHECK(distance(out, y) <= 1e-14);  // as far as v goes in that time
    return Eigen::Array2d{r, v};
  };
  const Eigen::Array2d eight = (inside(rkn86, 0.2L) / inside(rkn86, 0.1L)).log() / std::log(2.0);
  CHECK(eight[0] == Approx(7).margin(0.1));
  CHECK(eight[1] == Approx(6).margin(0.1));
  const Eigen::Array2d twelve = (inside(rkn1210, 0.8L) / inside(rkn1210, 0.4L)).log() / std::log(2.0);
  CAPTURE(twelve[0], twelve[1]);
  CHECK(std::abs(twelve[0] - 10) <= 0.5);
  CHECK(std::abs(twelve[1] - 9) <= 0.5);
}

TEST_CASE("backward again: the start, to the error of the steps") {
  auto y = six();
  PhiStepper stepper{y, Hardening{}, rkn1210};
  for (int n = 0; n < 50; ++n) problems::step(stepper, y, 0.1 * n, 0.1);
  for (int n = 50; n > 0; --n) problems::step(stepper, y, 0.1 * n, -0.1);
  CHECK(distance(y, six()) <= 1e-12);
}

TEST_CASE("a force that fails in the middle of a step leaves the state as it was") {
  const auto check = [](auto scheme, const Wall& wall, auto... m) {
    auto y = six();
    const auto before = states::numbers(y);
    PhiStepper stepper{y, wall, scheme, m...};
    const StepReport report = stepper.step(y, 0.0, 0.2);
    CHECK(report.outcome() == Outcome::non_finite_force);
    CHECK(report.failure().index == 3);
    CHECK(states::same_bits(states::numbers(y), before));
  };
  for (const double value : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()})
    for (const double from : {-1.0, 0.001, 0.05, 0.15, 0.1999}) {
      CAPTURE(value, from);
      const Wall wall{{}, from, value};
      check(rkn86, wall);
    }
}

TEST_CASE("units that are powers of two change no bit") {
  const auto go = [](double length, double time) {
    auto y = six();
    y.r *= length;
    y.v *= length / time;
    const double k = 1 / (time * time);
    PhiStepper stepper{y, Hardening{{}, 2 * k, k / (length * length)}, rkn1210};
    for (int n = 0; n < 8; ++n) problems::step(stepper, y, n * time, time);
    y.r /= length;
    y.v *= time / length;
    return states::numbers(y);
  };
  CHECK(states::same_bits(go(1, 1), go(0x1p-40, 0x1p20)));
}

// Runge-Kutta-Nyström pairs: conditions, orders, counts, masses, interpolation, tolerances, failures.
#include <phistep/phistep.hpp>

#include <cmath>
#include <limits>

#include "accuracy/observed_order.hpp"
#include "contract/states.hpp"
#include "problems/driven_motion.hpp"
#include "problems/kepler.hpp"
#include "problems/march.hpp"
#include "support/catch.hpp"
#if PHISTEP_FULL
#include "contract/restart.hpp"
#include "problems/ten.hpp"
#endif

using namespace phistep;
using convergence::check_order;
using convergence::errors;
using problems::distance;
using problems::error_at_end;
using problems::march;
using Vec = Eigen::VectorXd;

namespace nystrom_cases {

/// Σ w_j c_j^q − x, over the largest |w_j|
template <class Tableau>
long double defect(const long double* w, int count, int q, long double x) {
  long double sum = -x, largest = 0;
  for (int j = 0; j < count; ++j) {
    sum += w[j] * (q == 0 ? 1 : std::pow(Tableau::c[j], static_cast<long double>(q)));
    largest = std::max(largest, std::abs(w[j]));
  }
  return std::abs(sum) / std::max(largest, 1.0L);
}
/// Quadrature up to the orders, b_j = b'_j (1 − c_j), and what the stages integrate exactly: `stage_order` from stage 5 on.
template <class Tableau>
void check_conditions(int low, int stage_order) {
  constexpr long double u = 17 * std::numeric_limits<long double>::epsilon();  // a rounding for each term
  for (int q = 0; q <= Tableau::order; ++q) {
    CAPTURE(q);
    const long double once = 1.0L / (q + 1), twice = 1.0L / ((q + 1) * (q + 2));
    const auto v = defect<Tableau>(Tableau::b[1], Tableau::stages, q, once);
    const auto r = defect<Tableau>(Tableau::b[0], Tableau::stages, q, twice);
    if (q < Tableau::order) CHECK(v <= u);
    else CHECK(v > 1e-10L);
    if (q < Tableau::order - 1) CHECK(r <= u);
    if (q < low) CHECK(defect<Tableau>(Tableau::b_hat[1], Tableau::stages, q, once) <= u);
    if (q < low - 1) CHECK(defect<Tableau>(Tableau::b_hat[0], Tableau::stages, q, twice) <= u);
    if (q <= stage_order)
      for (int i = 5; i < Tableau::stages; ++i)
        CHECK(defect<Tableau>(Tableau::a[i], i, q, std::pow(Tableau::c[i], static_cast<long double>(q + 2)) * twice) <=
              u);
  }
  for (int j = 0; j < Tableau::stages; ++j)
    CHECK(std::abs(Tableau::b[0][j] - Tableau::b[1][j] * (1 - Tableau::c[j])) <= u);
}

struct Wall : ForceTerm {
  static constexpr bool uses_velocity = false, uses_time = true;
  double from = 0.15, value = std::numeric_limits<double>::quiet_NaN();
  void add(double t, const auto& y, auto& out) const {
    out.force -= y.r;
    if (t > from) out.force[3] = value;
  }
};
struct Hardening : ForceTerm {
  static constexpr bool uses_velocity = false, uses_time = false;
  double k = 2, cubic = 1;
  void add(auto, const auto& at, auto& out) const {
    out.force -= k * at.r + cubic * at.r.cwiseProduct(at.r).cwiseProduct(at.r);
  }
};
inline Motion<Vec> six() {
  return {Eigen::Map<const Vec>(states::positions.data(), 6), Eigen::Map<const Vec>(states::velocities.data(), 6)};
}

}  // namespace nystrom_cases

using namespace nystrom_cases;

#if PHISTEP_QUICK

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

#elif PHISTEP_FULL
// Runge-Kutta-Nystrom pairs: every mass, shape and scalar, tolerances.

TEST_CASE("float reaches its rounding") {
  // 20 steps, each with a handful of roundings of numbers near 1, on a problem that magnifies them by less than 10.
  CHECK(error_at_end<float>(rkn86, 20) <= 20 * 10 * 1.2e-7);
  CHECK(error_at_end<float>(rkn1210, 10) <= 20 * 10 * 1.2e-7);
}

TEST_CASE("backward again: the start, to the error of the steps") {
  auto y = six();
  PhiStepper stepper{y, Hardening{}, rkn1210};
  REQUIRE(integrate(stepper, y, {0, 5}, fixed(0.1)));
  REQUIRE(integrate(stepper, y, {5, 0}, fixed(-0.1)));
  CHECK(distance(y, six()) <= 1e-12);
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
  CHECK(calls(compensated(rkn1210), 10) == 17 * 10);
  auto y = six();
  PhiStepper stepper{y, Hardening{}, rkn1210};
  const RunReport run = integrate(stepper, y, {0, 20}, tolerance{.rtol = 1e-10, .atol = 1e-10});
  REQUIRE(run);
  // Each try sixteen, each step one more at its end; one at the start, and two for the first length.
  CHECK(run.statistics.force_calls == 16 * (run.statistics.steps + run.statistics.rejections) +
                                          (run.statistics.steps + run.statistics.rejections) + 3);
  CHECK(run.statistics.rejections <= run.statistics.steps / 4);
}

TEST_CASE("masses: none, one, one a component, a matrix") {
  const auto go = [](auto... m) { return march(PhiStepper{six(), Hardening{}, rkn86, m...}, six(), 0.0, 2.0, 20); };
  const auto one = go(), two = go(mass(2.0));
  // The same numbers by other roundings.
  CHECK(distance(two, go(mass(Vec(Vec::Constant(6, 2.0))))) <= 1e-13);
  CHECK(distance(two, go(mass(Eigen::MatrixXd(2 * Eigen::MatrixXd::Identity(6, 6))))) <= 1e-13);
  CHECK(distance(one, two) > 0.1);
}

TEST_CASE("every shape of a state gives the same") {
  const auto go = []<class V>(std::type_identity<V>) {
    states::SecondOrder<V> scene;
    PhiStepper stepper{scene.state, states::Pull{}, rkn86};
    for (int n = 0; n < 10; ++n) problems::step(stepper, scene.state, 0.0, 0.2);
    return states::numbers(scene.state);
  };
  const Vec fixed = go(std::type_identity<states::Fixed>{});
  CHECK((go(std::type_identity<states::RowMajor>{}) - fixed).norm() <= 1e-13);
  CHECK((go(std::type_identity<states::Strided>{}) - fixed).norm() <= 1e-13);
}

TEST_CASE("the error at the end follows the tolerance, on two orbits of a comet") {
  const problems::Kepler kepler;
  const problems::Case problem{
      "Kepler", kepler, kepler.start(), kepler.exact(2 * problems::Kepler::period), 2 * problems::Kepler::period,
      1.0,      false};
  const double kappa = problems::conditioning(problem);
  const auto check = [&](auto scheme) {
    double first = 0, last = 0;
    for (int digits = 3; digits <= 11; ++digits) {
      const double rtol = std::pow(10.0, -digits);
      auto y = problem.start;
      PhiStepper stepper{y, kepler, scheme};
      const RunReport run = integrate(stepper, y, {0, problem.end}, tolerance{.rtol = rtol, .atol = rtol});
      CAPTURE(digits, run.message());
      REQUIRE(run);
      last = problems::relative_error(y, problem);
      if (digits == 3) first = last;
      CHECK(last <= 10 * kappa * rtol);
    }
    const double slope = std::log10(first / last) / 8;
    CAPTURE(first, last, slope);
    CHECK(slope >= 0.8);
    CHECK(slope <= 1.1);
  };
  check(rkn86);
  check(rkn1210);
}

TEST_CASE("looked at inside of steps, a run is as good as at their ends") {
  const problems::Kepler kepler{0.3};
  auto y = kepler.start();
  PhiStepper stepper{y, kepler, rkn1210};
  double worst = 0;
  int looks = 0;
  const RunReport run =
      integrate(stepper, y, {0, 6}, tolerance{.rtol = 1e-9, .atol = 1e-9}, sampled(0.1, [&](double t, const auto& at) {
                  worst = std::max(worst, distance(at, kepler.exact(t)));
                  ++looks;
                }));
  REQUIRE(run);
  CHECK(looks >= 60);
  CHECK(run.statistics.steps <= 30);
  CHECK(worst <= 100 * 1e-9);  // κ of most of an orbit is below 100
}

TEST_CASE("a force that fails in the middle of a step leaves the state as it was") {
  const auto check = [](auto scheme, const Wall& wall, auto... m) {
    auto y = six();
    const auto before = restart::bytes(y);
    PhiStepper stepper{y, wall, scheme, m...};
    const StepReport report = stepper.step(y, 0.0, 0.2);
    CHECK(report.outcome() == Outcome::non_finite_force);
    CHECK(report.failure().index == 3);
    CHECK(restart::bytes(y) == before);
  };
  for (const double value : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()})
    for (const double from : {-1.0, 0.001, 0.05, 0.15, 0.1999}) {
      CAPTURE(value, from);
      const Wall wall{{}, from, value};
      check(rkn86, wall);
      check(rkn1210, wall);
      check(rkn1210, wall, mass(Eigen::MatrixXd(Eigen::MatrixXd::Identity(6, 6))));  // M⁻¹ would spread it
    }
}

TEST_CASE("units that are powers of two change no bit") {
  const auto go = [](double length, double time) {
    auto y = six();
    y.r *= length;
    y.v *= length / time;
    const double k = 1 / (time * time);
    PhiStepper stepper{y, Hardening{{}, 2 * k, k / (length * length)}, rkn1210};
    REQUIRE(
        integrate(stepper, y, {0, 8 * time}, tolerance{.rtol = 1e-9, .atol = {1e-9 * length, 1e-9 * length / time}}));
    y.r /= length;
    y.v *= time / length;
    return restart::bytes(y);
  };
  CHECK(go(1, 1) == go(0x1p-40, 0x1p20));
}

#endif

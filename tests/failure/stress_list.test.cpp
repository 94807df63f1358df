// Of the stress list what is quick: ratios of masses, matrices without an inverse, the floor of precision, denormal
// numbers. Implicit springs, products with the matrix, tangents that are indefinite: the stress tier. All of it, at full
// length: extremes.stress.cpp and solvers.stress.cpp.
#include <phistep/phistep.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <utility>
#include <vector>

#include "support/catch.hpp"
#include "support/shared_force.hpp"
#if PHISTEP_STRESS
#include <phistep/krylov.hpp>
#endif

using namespace phistep;
using Vec = Eigen::VectorXd;
using Net = Motion<Eigen::Matrix3Xd>;

namespace stress_list_cases {

inline Vec alternating(double light, double heavy, Eigen::Index n) {
  Vec m(n);
  for (Eigen::Index i = 0; i < n; ++i) m[i] = i % 2 == 0 ? light : heavy;
  return m;
}

/// A dumbbell of 1 and 1e12 that turns and rings: momentum, implicit and explicit.
void check_dumbbell(auto scheme) {
  const Vec masses = alternating(1, 1e12, 2);
  Net y{Eigen::Matrix3Xd::Zero(3, 2), Eigen::Matrix3Xd::Zero(3, 2)};
  y.r(0, 0) = 1.1, y.v(1, 0) = 0.5, y.v(1, 1) = 1e-6;
  const Eigen::Vector3d before = y.v * masses;
  PhiStepper stepper{y, spring_network<3>({{0, 1, 100.0, 1.0}}), scheme, mass(masses)};
  int done = 0;
  for (int n = 0; n < 1000; ++n) done += stepper.step(y, 0.02 * n, 0.02) ? 1 : 0;
  CHECK(done == 1000);
  CHECK((y.v * masses - before).norm() <= 1e-13 * before.norm());
  CHECK(y.r.col(0).norm() == Approx(1.05).epsilon(0.1));
}

/// With states V of two numbers.
template <class V>
void check_without_inverse() {
  // 1 = φz, z > 0: to the last bit, and beside it.
  for (const double h : {1.0, std::nextafter(1.0, 0.0), std::nextafter(1.0, 2.0), 1 + 1e-12}) {
    CAPTURE(h);
    const auto check = [h](auto stepper) {
      V y = V::Ones(2);
      const StepReport report = stepper.step(y, 0, h);
      if (h == 1) CHECK(report.outcome() == Outcome::singular_matrix);
      if (!report) CHECK(y == V::Ones(2));
      else CHECK(std::abs(y[0] * (1 - h) - 1) <= 1e-3);  // 1 − z is known to its last bit here
    };
    const V y = V::Ones(2);
    const auto grows = Eigen::Matrix<double, V::RowsAtCompileTime, V::RowsAtCompileTime>::Identity(2, 2).eval();
    check(PhiStepper{y, linear(grows), backward_euler});
    V z = y;
    Halving halving{PhiStepper{z, linear(grows), backward_euler}, 4};
    CHECK(halving.step(z, 0, 1));
    CHECK(z[0] == 4);  // (1 − ½)⁻²
  }
}

/// y' = 1 from y = 0.
template <class V>
auto run_clock(const V& zero, double t0, double t1, const auto& control, auto&... events) {
  V y = zero;
  PhiStepper stepper{
      y, shared_force::OfStateAndTime<V>{[n = zero.size()](const V&, double) -> V { return V::Ones(n); }}, trapezoidal};
  const RunReport report = integrate(stepper, y, {t0, t1}, control, events...);
  return std::pair{report, y[0]};
}
template <class V>
void check_floor_of_time(const V& zero) {
  // At 1e16 the clock ticks in twos.
  const auto [stuck, none] = run_clock(zero, 1e16, 1e16 + 200, fixed(0.5));
  CHECK(stuck.outcome == Outcome::step_too_small);
  CHECK(none == 0);
  const auto [through, sum] = run_clock(zero, 1e16, 1e16 + 200, fixed(2));
  CHECK((through && through.t == 1e16 + 200 && through.statistics.steps == 100 && sum == 200));
  const auto [chosen, length] = run_clock(zero, 1e16, 1e16 + 200, tolerance{});
  CHECK((chosen && chosen.t == 1e16 + 200 && std::abs(length - 200) <= 2));  // its own steps are no whole ticks
  // A span of one rounding is one step, whoever chooses its length.
  const double next = std::nextafter(1.0, 2.0);
  for (const double t1 : {next, 1.0}) {
    const auto [grid, by_grid] = run_clock(zero, 1, t1, fixed(0.1));
    const auto [own, by_error] = run_clock(zero, 1, t1, tolerance{});
    CHECK((grid && own && grid.t == t1 && own.t == t1 && by_grid == t1 - 1 && by_error == t1 - 1));
  }
}

// Beside an atol, a component that is denormal is nothing; by rtol alone it is followed or the run says that it can't.
template <class V>
void check_denormal_parts(const auto& decay) {
  for (const double size : {1e-300, 1e-308, 1e-310, 1e-320, 0.0}) {
    CAPTURE(size);
    V mixed = Eigen::Vector2d(1, size), alone = V::Constant(2, size);
    PhiStepper one{mixed, decay, trapezoidal}, other{alone, decay, trapezoidal};
    REQUIRE(integrate(one, mixed, {0, 1}, tolerance{.rtol = 1e-5, .atol = 1e-8}));
    CHECK(mixed[0] == Approx(std::exp(-1.0)).epsilon(1e-4));
    CHECK(std::abs(mixed[1]) <= 1.01 * size);
    const RunReport report = integrate(other, alone, {0, 1}, tolerance{.rtol = 1e-5, .atol = 0});
    if (report) CHECK(std::abs(alone[0] - size * std::exp(-1.0)) <= 1e-4 * size + 1e-322);
    else CHECK(size < 1e-300);
    CHECK(alone.allFinite());
  }
}

}  // namespace stress_list_cases

using namespace stress_list_cases;

#if PHISTEP_FULL

using Two = Eigen::Vector2d;

TEST_CASE("stress list: mass ratio 1e12") { check_dumbbell(velocity_verlet); }

TEST_CASE("stress list: matrices without an inverse") {
  check_without_inverse<Two>();
  // Neither has M, be it of its numbers or for a reciprocal that is no number (tests/step/mass/mass.test.cpp: matrices).
  for (const double bad : {0.0, -1.0, 1e-320, std::nan(""), HUGE_VAL}) {
    CHECK_THROWS_AS(mass(bad), std::invalid_argument);
    const auto stepper = [bad] {
      PhiStepper{Vec::Ones(2).eval(), linear(Eigen::MatrixXd::Identity(2, 2).eval()), trapezoidal,
                 mass(Vec(bad * Vec::Ones(2)))};
    };
    CHECK_THROWS_AS(stepper(), std::invalid_argument);
  }
}

TEST_CASE("stress list: time at the floor of its precision") { check_floor_of_time(Two::Zero().eval()); }

TEST_CASE("stress list: denormal numbers") {
  constexpr double tiny = 1e-310;
  // A drift at a denormal speed, and a fall from rest by a denormal force: right, or flushed to zero by the machine.
  Motion<Vec> y{Vec::Ones(3), Vec::Constant(3, tiny)};
  PhiStepper stepper{y, [](const Vec& r) -> Vec { return Vec::Zero(r.size()); }, velocity_verlet};
  for (int n = 0; n < 100; ++n) REQUIRE(stepper.step(y, n, 1));
  CHECK((y.r == Vec::Ones(3) && y.v == Vec::Constant(3, tiny)));
  check_denormal_parts<Two>(shared_force::OfStateAndTime<Two>{[](const Two& x, double) -> Two { return -x; }});
}

#elif PHISTEP_STRESS
// Of the stress list: ratios of masses, tangents that are indefinite, matrices without an inverse, the floor of
// precision, denormal numbers, of vectors of any size.

using Mat = Eigen::MatrixXd;

namespace {

constexpr double u = std::numeric_limits<double>::epsilon();

/// A chain of masses: springs k_i to the one before, the first to a wall.
Mat chain(const Vec& k) {
  Mat K = Mat::Zero(k.size(), k.size());
  for (Eigen::Index i = 0; i < k.size(); ++i) {
    K(i, i) -= k[i];
    if (i > 0) K(i - 1, i - 1) -= k[i], K(i, i - 1) = K(i - 1, i) = k[i];
  }
  return K;
}
/// One step of backward Euler for m v' = K r, in long double.
Vec velocity_after(const Mat& K, const Vec& m, const Vec& r, const Vec& v, double h) {
  using Wide = Eigen::Matrix<long double, Eigen::Dynamic, Eigen::Dynamic>;
  const Wide A = K.cast<long double>(), M = m.cast<long double>().asDiagonal();
  const long double H = h;
  const Wide x = r.cast<long double>(), w = v.cast<long double>();
  return Wide((M - H * H * A).fullPivLu().solve(M * w + H * (A * x))).cast<double>();
}
double worst(const Vec& a, const Vec& b) { return (a - b).cwiseAbs().maxCoeff(); }

/// m (v⁺ − v) − h Ψ(r⁺), r⁺ − r − h v⁺: what backward Euler makes zero, relative to its terms.
double residual(const std::vector<Spring>& springs, const Vec& m, const Net& y, const Net& next, double h) {
  Eigen::Matrix3Xd f = Eigen::Matrix3Xd::Zero(3, y.r.cols()), sizes = f;
  for (const Spring& s : springs) {
    const Eigen::Vector3d d = next.r.col(s.j) - next.r.col(s.i);
    const Eigen::Vector3d pull = s.stiffness * (d.norm() - s.length) * d / d.norm();
    f.col(s.i) += pull, f.col(s.j) -= pull;
    // The rounding of r reaches the force through the stiffness.
    const double size = s.stiffness * (next.r.col(s.i).norm() + next.r.col(s.j).norm() + s.length);
    sizes.col(s.i).array() += size, sizes.col(s.j).array() += size;
  }
  double most = 0;
  for (Eigen::Index i = 0; i < y.r.cols(); ++i) {
    const Eigen::Vector3d left = m[i] * (next.v.col(i) - y.v.col(i)) - h * f.col(i);
    most = std::max(most, left.cwiseAbs().maxCoeff() / (m[i] * y.v.col(i).norm() + h * sizes.col(i).maxCoeff()));
    most = std::max(most, (next.r.col(i) - y.r.col(i) - h * next.v.col(i)).cwiseAbs().maxCoeff() / next.r.norm());
  }
  return most;
}

}  // namespace

TEST_CASE("stress list: mass ratio 1e12") {
  // Matrix-free: the residual of the heavy must not hide what is left to do on the light.
  const Vec k = Vec::Ones(10), m = alternating(1, 1e12, 10), r0 = Vec::LinSpaced(10, 0.01, 0.1);
  const Mat K = chain(k);
  for (const double h : {1e-3, 1.0, 1e3}) {
    CAPTURE(h);
    Motion<Vec> y{r0, 0.1 * Vec::Unit(10, 0)};
    const Vec exact = velocity_after(K, m, y.r, y.v, h);
    PhiStepper stepper{y, [&K](const Vec& r) -> Vec { return K * r; }, backward_euler, mass(m), newton<MatrixFree<>>()};
    REQUIRE(stepper.step(y, 0, h));
    CHECK(worst(y.v, exact) <= 100 * u * (0.1 + r0.maxCoeff() / h));  // the rounding of r, in units of v
  }
  check_dumbbell(backward_euler);
  check_dumbbell(velocity_verlet);
}

TEST_CASE("stress list: indefinite tangents are never silent") {
  // A column of two compressed springs between heavy ends, about to buckle: solved, or an outcome.
  const std::vector<Spring> springs{{0, 1, 1e6, 1.0}, {1, 2, 1e6, 1.0}};
  const Vec m = alternating(1e12, 1, 3);
  int solved = 0;
  for (const double h : {1e-5, 1e-4, 7e-4, 1e-3, 1e-2, 0.1, 1.0}) {
    Net y{Eigen::Matrix3Xd::Zero(3, 3), Eigen::Matrix3Xd::Zero(3, 3)};
    y.r(0, 1) = 0.6, y.r(0, 2) = 1.2, y.r(1, 1) = 1e-6, y.v(2, 1) = 1e-3;
    const Net before = y;
    PhiStepper stepper{y, spring_network<3>(springs), backward_euler, mass(m)};
    const StepReport report = stepper.step(y, 0, h);
    CAPTURE(h, report.message());
    if (report) CHECK(residual(springs, m, before, y, h) <= 1e-12);
    else CHECK((y.r == before.r && y.v == before.v));
    solved += report ? 1 : 0;
  }
  CHECK(solved >= 4);
}

TEST_CASE("stress list: matrices without an inverse") { check_without_inverse<Vec>(); }

TEST_CASE("stress list: time at the floor of its precision") {
  const Vec zero = Vec::Zero(1);
  check_floor_of_time(zero);
  auto seen = event([](double t, const Vec&) { return t - (1e16 + 101); });
  const auto [met, at_end] = run_clock(zero, 1e16, 1e16 + 1280, fixed(128), seen);  // 64 ulp
  CHECK((met && at_end == 1280));
  REQUIRE(seen.times().size() == 1);
  CHECK(std::abs(seen.times()[0] - (1e16 + 101)) <= 32);  // 16 roundings
}

TEST_CASE("stress list: denormal numbers") {
  check_denormal_parts<Vec>([](const Vec& x) -> Vec { return -x; });
}

#endif

// Of the stress list: ratios of masses, tangents that are indefinite, matrices without an inverse, the floor of
// precision, denormal numbers, of vectors of any size. The quick half: stress_list.test.cpp.
#include <phistep/krylov.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "extremes/stress_list_cases.hpp"

using namespace stress_list_cases;
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
    PhiStepper stepper{y, [&K](const Vec& r) -> Vec { return K * r; }, backward_euler, mass(m),
                       newton<MatrixFree<Eigen::BiCGSTAB>>()};
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
  const auto [met, at_end] = run_clock(zero, 1e16, 1e16 + 200, fixed(40), seen);
  CHECK((met && at_end == 200));
  REQUIRE(seen.times().size() == 1);
  CHECK(std::abs(seen.times()[0] - (1e16 + 101)) <= 32);  // 16 roundings
}

TEST_CASE("stress list: denormal numbers") {
  check_denormal_parts<Vec>([](const Vec& x) -> Vec { return -x; });
}

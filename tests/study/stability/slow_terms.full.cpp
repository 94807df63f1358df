// How long an outer step with slow terms may be: the formula against the step's own matrix, and preflight against runs.
#include <phistep/phistep.hpp>
#include <phistep/preflight.hpp>
#include <phistep/study/stability/stable_step.hpp>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <sstream>
#include <vector>

#include "instances/preflight.hpp"
#include "problems/march.hpp"
#include "support/catch.hpp"

using namespace phistep;
using Vec = Eigen::VectorXd;
using Mat = Eigen::MatrixXd;
using std::numbers::pi;

namespace {

/// Of (r, v): r'' = −A r, the B part called once in k inner steps of Verlet.
Mat outer(const Mat& A, const Mat& B, double dt, int k) {
  const Eigen::Index n = A.rows();
  const auto kick = [n](const Mat& K, double gamma) {
    Mat G = Mat::Identity(2 * n, 2 * n);
    G.bottomLeftCorner(n, n) = -gamma * K;
    return G;
  };
  return outer_step_matrix<Mat>(
      dt, {k}, 0.5,
      [&](double h) -> Mat {
        Mat drift = Mat::Identity(2 * n, 2 * n);
        drift.topRightCorner(n, n).diagonal().setConstant(h);
        return kick(A, h / 2) * drift * kick(A, h / 2);
      },
      [&](std::size_t, double gamma) { return kick(B, gamma); });
}
double radius(const Mat& G) { return G.eigenvalues().cwiseAbs().maxCoeff(); }
double radius(double a, double b, double dt, int k) {
  return radius(outer(Mat::Constant(1, 1, a), Mat::Constant(1, 1, b), dt, k));
}
Mat random_symmetric(std::mt19937& random, Eigen::Index n, double lowest, double highest) {
  std::normal_distribution<double> normal;
  const Mat X = Mat::NullaryExpr(n, n, [&] { return normal(random); });
  const Mat Q = X.householderQr().householderQ();
  std::uniform_real_distribution<double> uniform(lowest, highest);
  Vec values = Vec::NullaryExpr(n, [&] { return uniform(random); });
  values[0] = highest;
  return Q * values.asDiagonal() * Q.transpose();
}

}  // namespace

TEST_CASE("limits that are known: Verlet's, half a period, the slow force alone") {
  CHECK(outer_step_limit(3, 1, 1) == Approx(2 / std::sqrt(4.0)).epsilon(1e-12));
  CHECK(outer_step_limit(4, 1e-12, 1000) == Approx(pi / 2).epsilon(1e-6));
  CHECK(outer_step_limit(1e-12, 4, 8) == Approx(1).epsilon(1e-6));
  CHECK(outer_step_limit(0, 4, 8) == 1);
  CHECK(outer_step_limit(4, 0, 1) == Approx(1));
  CHECK(std::isinf(outer_step_limit(0, 0, 4)));
}

TEST_CASE("for one oscillator the limit is the very place where it begins to grow") {
  for (const int k : {1, 2, 3, 8, 20})
    for (const double b : {1e-3, 0.05, 0.5, 2.0}) {
      const double limit = outer_step_limit(1, b, k);
      CAPTURE(k, b, limit);
      CHECK(radius(1, b, 0.9999 * limit, k) <= 1 + 1e-7);
      CHECK(radius(1, b, 1.0005 * limit, k) > 1 + 1e-5 * b);
      for (double x = 0.02; x < 1; x += 0.013) CHECK(radius(1, b, x * limit, k) <= 1 + 1e-7);
    }
}

TEST_CASE("for many that share no mode it is a guarantee, with slow forces that push, too") {
  std::mt19937 random(5);
  for (int n = 0; n < 60; ++n) {
    const bool pushes = n % 2 == 1;
    const int k = 1 + n % 9;
    const Mat A = random_symmetric(random, 4, 0.3, 4), B = random_symmetric(random, 4, pushes ? -0.25 : 0.0, 0.6);
    const double limit = outer_step_limit(4, 0.6, k);
    CAPTURE(n, k, limit);
    for (const double x : {0.1, 0.3, 0.5, 0.7, 0.8, 0.9, 0.95, 0.999})
      CHECK(radius(outer(A, B, x * limit, k)) <= 1 + 1e-7);
  }
}

TEST_CASE("the most inner steps of a length are those whose outer step is stable") {
  for (const double h : {0.01, 0.1, 0.3}) {
    const int k = most_inner_steps(4, 0.3, h);
    CAPTURE(h, k);
    CHECK(k * h <= outer_step_limit(4, 0.3, k));
    CHECK((k + 1) * h > outer_step_limit(4, 0.3, k + 1));
  }
  CHECK(most_inner_steps(4, 0.3, 0.99) == 0);  // Verlet's limit is 0.965
  CHECK(most_inner_steps(4, 0.3, 0.95) == 1);
}

namespace {

/// A chain: fast springs between neighbours, slow ones to their places.
struct Chain : ForceTerm {
  double k;
  static constexpr bool uses_velocity = false, uses_time = false, is_symmetric = true;
  explicit Chain(double stiffness) : k{stiffness} {}
  void add(auto, const auto& y, auto& out) const {
    for (Eigen::Index i = 0; i + 1 < y.r.size(); ++i) {
      out.force[i] += k * (y.r[i + 1] - y.r[i]);
      out.force[i + 1] -= k * (y.r[i + 1] - y.r[i]);
    }
  }
};
struct Places : ForceTerm {
  Vec k;
  static constexpr bool uses_velocity = false, uses_time = false, is_symmetric = true;
  explicit Places(Vec stiffness) : k{std::move(stiffness)} {}
  void add(auto, const auto& y, auto& out) const { out.force -= k.cwiseProduct(y.r); }
};
const Motion<Vec> line{Vec::Zero(12), Vec::Zero(12)};

double growth(auto stepper, double dt, int steps) {
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  Motion<Vec> y = line;
  y.r = Vec::NullaryExpr(12, [&] { return normal(random); });
  double most = 0;
  const double before = y.r.norm();
  for (int n = 0; n < steps && most < 1e9; ++n) {
    problems::step(stepper, y, n * dt, dt);
    most = std::max(most, y.r.norm() / before);
  }
  return most;
}

}  // namespace

TEST_CASE("preflight knows how long an outer step may be, one level and two") {
  // Places that all are alike share the chain's modes: the limit is one, and not only a bound. The window of growth is
  // ω_s²Δt/ω of π wide: 0.8 %.
  const Places even{Vec::Constant(12, 3)}, uneven{Vec::LinSpaced(12, 1, 3)};
  const auto check = [](const auto& force, auto scheme, double resonance) {
    PhiStepper stepper{line, force, scheme};
    const PreflightReport report = preflight(stepper, line, 0.05);
    CAPTURE(report.text());
    CHECK(report.verdict == Verdict::fine);
    CHECK(growth(stepper, report.stable_dt, 20000) < 60);
    if (resonance > 0) CHECK(growth(stepper, resonance * report.stable_dt, 20000) > 1e6);
    return report;
  };
  const PreflightReport one = check(Chain{100} + seldom(8, even), velocity_verlet, 1.004);
  CHECK(one.inner_steps == 8);
  CHECK(one.terms[0].k == 1);
  CHECK(one.terms[1].k == 8);
  CHECK_FALSE(one.terms[1].is_kick);
  CHECK(one.stable_dt < pi / std::sqrt(400.0));
  CHECK(one.stable_dt > 0.9 * pi / std::sqrt(400.0));
  CHECK_THAT(one.text(), contains("once in 8 inner steps") && contains("8 of 0.00625"));
  check(Chain{100} + seldom(8, even), symplectic_euler, 1.004);
  check(Chain{100} + seldom(8, even), symplectic_euler_adjoint, 1.004);
  check(Chain{100} + seldom(8, uneven), velocity_verlet, 0);
  const PreflightReport two = check(Chain{100} + seldom(2, uneven) + seldom(8, even), velocity_verlet, 0);
  CHECK(two.most_k == 0);
  CHECK(two.stable_dt > 0.8 * one.stable_dt);
  // The inner step of the report bears most_k and no more.
  for (const int extra : {0, 1}) {
    PhiStepper stepper{line, Chain{100} + seldom(one.most_k + extra, even), velocity_verlet};
    const double h = 0.05 / 8, dt = (one.most_k + extra) * h;
    CAPTURE(one.most_k, extra);
    CHECK((preflight(stepper, line, dt).verdict == Verdict::unstable) == (extra == 1));
  }
}

TEST_CASE("friction among the fast terms: by the step's matrix") {
  PhiStepper stepper{line, Chain{100} + LinearDrag{0.5} + seldom(4, Places{Vec::LinSpaced(12, 1, 3)}), velocity_verlet};
  const PreflightReport report = preflight(stepper, line, 0.05);
  CHECK(report.verdict == Verdict::fine);
  CHECK(report.stable_dt > 0.13);
  CHECK(growth(stepper, report.stable_dt, 5000) < 60);
}

TEST_CASE("preflight's matrix of an outer step is the stepper's step") {
  const Places even{Vec::Constant(12, 3)}, uneven{Vec::LinSpaced(12, 1, 3)};
  const double dt = 0.21;
  const auto check = [&](auto scheme, double begin) {
    Mat K = Mat::Zero(12, 12);
    for (Eigen::Index i = 0; i < 12; ++i) {
      Motion<Vec> y{Vec::Unit(12, i), Vec::Zero(12)};
      struct {
        Vec force = Vec::Zero(12);
      } out;
      Chain{100}.add(0, y, out);
      K.col(i) = out.force;
    }
    const auto kick = [](const Mat& k, double gamma) {
      Mat G = Mat::Identity(24, 24);
      G.bottomLeftCorner(12, 12) = gamma * k;
      return G;
    };
    const Mat G = outer_step_matrix<Mat>(
        dt, {6, 2}, begin,
        [&](double h) -> Mat {
          Mat drift = Mat::Identity(24, 24);
          drift.topRightCorner(12, 12).diagonal().setConstant(h);
          return kick(K, (1 - begin) * h) * drift * kick(K, begin * h);
        },
        [&](std::size_t j, double gamma) { return kick(Mat(Vec(-(j == 0 ? even.k : uneven.k)).asDiagonal()), gamma); });
    std::mt19937 random(3);
    std::normal_distribution<double> normal;
    const Vec start = Vec::NullaryExpr(24, [&] { return normal(random); });
    Motion<Vec> y{start.head(12), start.tail(12)};
    PhiStepper stepper{y, Chain{100} + seldom(6, even) + seldom(2, uneven), scheme};
    problems::step(stepper, y, 0.0, dt);
    Vec end(24);
    end << y.r, y.v;
    CHECK((G * start - end).norm() < 1e-12 * end.norm());
  };
  check(velocity_verlet, 0.5);
  check(symplectic_euler, 1);
  check(symplectic_euler_adjoint, 0);
}

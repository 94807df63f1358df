// stable_step, all of it; in short: tests/study/preflight.test.cpp, which compiles the same headers.
// What is guaranteed from bounds, against the spectral radius of the step's own matrix: random problems whose stiffness and
// damping don't commute. And that it is guaranteed where it can be.
#include <phistep/phistep.hpp>
#include <phistep/study/stability/stable_step.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "instances/preflight.hpp"
#include "support/catch.hpp"

using namespace phistep;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using Kind = Method::Kind;

namespace {

struct Random {
  std::mt19937 engine;
  double operator()() { return std::normal_distribution<double>{}(engine); }
  MatrixXd matrix(Eigen::Index n) {
    return MatrixXd::NullaryExpr(n, n, [this] { return (*this)() * std::exp((*this)()); });
  }
  MatrixXd definite(Eigen::Index n) {
    const MatrixXd B = matrix(n);
    return B * B.transpose();
  }
  /// Dashpots between all pairs: semidefinite, as its discs tell.
  MatrixXd network(Eigen::Index n) {
    MatrixXd A = matrix(n).cwiseAbs();
    A = (-(A + A.transpose())).eval();
    A.diagonal().setZero();
    const VectorXd sums = A.rowwise().sum();
    A.diagonal() = -sums;
    return A;
  }
};

double spectral_radius(const LinearizedProblem& problem, const Method& method, double h) {
  DenseSystemMatrices rest = divided(problem.rest, problem.masses), kicks = rest;
  MatrixXd G = step_matrix(method, rest, h);
  if (problem.has_kicks) {
    const MatrixXd kick = kick_matrix(divided(problem.kicks, problem.masses), h / 2);
    G = kick * G * kick;
  }
  double top = 0;
  for (const auto lambda : eigenvalues_of(G)) top = std::max(top, std::abs(lambda));
  return top;
}

LinearizedProblem motion(const MatrixXd& K, const MatrixXd& C, const VectorXd& m) {
  LinearizedProblem problem;
  problem.whole = problem.rest = {SparseRows(K.sparseView()), SparseRows(C.sparseView())};
  problem.masses.lumped = m;
  problem.tolerance = 1e-9;
  return problem;
}
LinearizedProblem first_order(const MatrixXd& J, const VectorXd& m) { return motion(MatrixXd(J.rows(), 0), J, m); }

/// Δt from bounds; nothing may grow there. How much longer the true limit is; NaN where nothing was guaranteed.
double check(const LinearizedProblem& problem, const Method& method) {
  const Spectrum bounds = bound_spectrum(problem.whole, problem.masses, problem.block, problem.tolerance);
  const double h = stable_step(method, problem, bounds);
  INFO("scheme " << static_cast<int>(method.kind) << " (" << method.force << ", " << method.drift << "), positions "
                 << problem.whole.K.cols() << ", kicks " << problem.has_kicks << ", has C " << bounds.has_C
                 << ", symmetric C " << is_symmetric(problem.whole.C, 1e-9) << ", dt " << h);
  if (!std::isfinite(h) || h == 0) return std::numeric_limits<double>::quiet_NaN();
  for (const double share : {0.999, 0.7, 0.3, 0.05}) CHECK(spectral_radius(problem, method, share * h) <= 1 + 1e-7);
  double longer = 1;
  while (longer < 100 && spectral_radius(problem, method, longer * h) <= 1 + 1e-7) longer *= 1.05;
  return longer;
}

const Method verlet{Kind::verlet, 0.5, 0.5}, kick_drift{Kind::pair, 0, 1}, drift_kick{Kind::pair, 1, 0},
    euler{Kind::single, 0, 0}, quarter{Kind::single, 0.25, 0.25}, half{Kind::single, 0.5, 0.5},
    pair{Kind::pair, 0.2, 0.9};

}  // namespace

TEST_CASE("bounds guarantee what the step's matrix confirms") {
  int guaranteed = 0;
  for (unsigned seed = 0; seed < 200; ++seed) {
    INFO("seed " << seed);
    Random random{std::mt19937(seed)};
    const Eigen::Index n = 2 + static_cast<Eigen::Index>(seed % 6);
    const VectorXd m = VectorXd::NullaryExpr(n, [&] { return std::exp(random()); });
    const MatrixXd K = -random.definite(n), C = -random.network(n), gyroscopic = random.matrix(n),
                   none = MatrixXd::Zero(n, n), drag = -MatrixXd(m.asDiagonal()) * 0.3;
    for (const Method& method : {verlet, kick_drift, drift_kick, pair})
      guaranteed += check(motion(K, none, m), method) >= 1;
    for (const Method& method : {verlet, kick_drift, drift_kick}) {
      guaranteed += check(motion(K, C, m), method) >= 1;
      check(motion(K, C + drag, m), method);
      check(motion(K, gyroscopic - gyroscopic.transpose(), m), method);
      check(motion(K, MatrixXd(C + gyroscopic - gyroscopic.transpose()), m), method);
    }
    for (const Method& method : {euler, quarter}) {
      guaranteed += check(motion(K, drag, m), method) >= 1;
      check(motion(K, MatrixXd(drag + C), m), method);
      guaranteed += check(first_order(K, m), method) >= 1;
      check(first_order(MatrixXd(K - 3 * MatrixXd(m.asDiagonal()) + 0.3 * (gyroscopic - gyroscopic.transpose())), m),
            method);
      // Rows that sum to less than zero: discs left of 0.
      MatrixXd flow = gyroscopic.cwiseAbs();
      flow.diagonal().setZero();
      flow.diagonal() = -flow.rowwise().sum() * 1.1;
      guaranteed += check(first_order(flow, m), method) >= 1;
      guaranteed += check(first_order(flow.transpose(), VectorXd::Ones(n)), method) >= 1;
    }
    // Half kicks around φ = ½.
    for (const MatrixXd& damping : {none, MatrixXd(C + drag)}) {
      LinearizedProblem split = motion(MatrixXd(10 * K), damping, m);
      const MatrixXd soft = -random.definite(n);
      split.has_kicks = true;
      split.kicks = motion(soft, none, m).whole;
      split.whole = motion(MatrixXd(10 * K + soft), damping, m).whole;
      guaranteed += check(split, half) >= 1;
    }
  }
  // Whatever is symmetric has a guarantee.
  CHECK(guaranteed == 200 * (4 + 3 + 2 * 4 + 2));
}

TEST_CASE("where there is none, none is claimed") {
  Random random{std::mt19937(5)};
  const VectorXd m = VectorXd::Ones(4);
  const MatrixXd K = -random.definite(4), any = random.matrix(4), none = MatrixXd::Zero(4, 4);
  const auto ask = [&](const LinearizedProblem& problem, const Method& method) {
    return stable_step(method, problem, bound_spectrum(problem.whole, problem.masses, 0, 1e-9));
  };
  CHECK(std::isnan(ask(motion(any, none, m), verlet)));                     // not a potential's
  CHECK(std::isnan(ask(motion(K, MatrixXd::Identity(4, 4), m), verlet)));   // damping that drives
  CHECK(std::isnan(ask(motion(K, any - any.transpose(), m), kick_drift)));  // gyroscopic
  CHECK(std::isnan(ask(motion(K, any - any.transpose(), m), drift_kick)));
  CHECK(std::isnan(ask(motion(K, -MatrixXd::Identity(4, 4), m), pair)));
  CHECK(std::isnan(ask(first_order(any - any.transpose(), m), euler)));  // never stable, but not known to be
  CHECK(ask(motion(K, none, m), euler) == 0);
  CHECK(std::isinf(ask(motion(any, any, m), half)));  // A-stable
}

TEST_CASE("the scan finds closed forms") {
  for (unsigned seed = 0; seed < 20; ++seed) {
    Random random{std::mt19937(seed)};
    const VectorXd m = VectorXd::Ones(5);
    const LinearizedProblem problem = motion(-random.definite(5), MatrixXd::Zero(5, 5), m);
    const Spectrum s = exact_spectrum(problem.whole, problem.masses, 1e-9);
    for (const Method& method : {verlet, kick_drift, pair})
      CHECK(scan_for_stable_step(method, problem, s) == Approx(stable_step_of(method, problem, s)).epsilon(1e-3));
  }
}

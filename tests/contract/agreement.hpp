#pragma once

// Different ways to one answer: all solvers of implicit equations, and runs that choose their steps.

#include <phistep/krylov.hpp>
#include <phistep/phistep.hpp>
#include <phistep/sparse.hpp>

#include <Eigen/IterativeLinearSolvers>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "contract/property.hpp"
#include "problems/linear_extrapolation.hpp"

namespace agreement {

using namespace phistep;
using property::Source;
using Vec = Eigen::VectorXd;
using Mat = Eigen::MatrixXd;

constexpr double u = std::numeric_limits<double>::epsilon() / 2;

/// y_i' = l_i y_{i−1} − d_i y_i + u_i y_{i+1} − c_i y_i³, with d_i ≥ |l_i| + |u_i|.
struct Chain {
  Vec lower, diagonal, upper, cubic;
  Vec operator()(const Vec& y) const {
    const Eigen::Index n = y.size();
    Vec rate = -diagonal.cwiseProduct(y) - cubic.cwiseProduct(y.cwiseProduct(y.cwiseProduct(y)));
    for (Eigen::Index i = 0; i < n; ++i) {
      if (i > 0) rate[i] += lower[i] * y[i - 1];
      if (i + 1 < n) rate[i] += upper[i] * y[i + 1];
    }
    return rate;
  }
  [[nodiscard]] Eigen::SparseMatrix<double> pattern() const {
    const Eigen::Index n = diagonal.size();
    Mat ones = Mat::Identity(n, n);
    for (Eigen::Index i = 0; i + 1 < n; ++i) ones(i, i + 1) = ones(i + 1, i) = 1;
    return ones.sparseView();
  }
};

/// 11. Dense, banded and sparse LU, LDLᵀ, Krylov and fixed-point iteration end at one solution.
///
/// W is diagonally dominant by rows, ‖W⁻¹‖ ≤ 1: rounding in the residual, n u of Δt·Σ|Ψ| ≤ u·(1 + Δt·stiffness)·|y| a
/// component, is all that is left of Newton's iteration, whatever the matrix was solved by.
inline void solvers(Source& source) {
  const int n = 2 * source.integer("half of n", 1, 6);
  const double stiffness = source.decades("stiffness", -2, 5);
  const bool symmetric_one = source.flag("symmetric");
  Chain f;
  f.lower = stiffness * source.numbers("lower", n, 1);
  f.upper = stiffness * source.numbers("upper", n, 1);
  if (symmetric_one)
    for (Eigen::Index i = 1; i < n; ++i) f.lower[i] = f.upper[i - 1];
  f.diagonal = f.lower.cwiseAbs() + f.upper.cwiseAbs() + source.numbers("more", n, stiffness).cwiseAbs();
  f.cubic = source.numbers("cubic", n, stiffness).cwiseAbs();
  const Vec start = source.numbers("y", n, 1);
  const double dt = source.decades("dt", -3, 0);
  const auto by = [&](const char* name, auto force, auto... solver) {
    Vec y = start;
    PhiStepper stepper{y, force, backward_euler, solver...};
    for (int k = 0; k < 2; ++k)
      if (const StepReport report = stepper.step(y, k * dt, dt); !report)
        throw property::Broken(std::string(name) + ": " + report.message());
    return y;
  };
  const Vec dense = by("dense", f);
  const double size = std::max(1e-300, start.cwiseAbs().maxCoeff()), allowed = 64 * u * (1 + dt * stiffness) * size;
  const auto agree = [&](const char* name, const Vec& y, double times = 1) {
    source.bound((y - dense).cwiseAbs().maxCoeff(), times * allowed, std::string(name) + " differs from dense LU");
  };
  agree("banded LU", by("banded", banded(f, 1, 1)));
  agree("sparse LU", by("sparse", sparsity(f, f.pattern())));
  if (symmetric_one) agree("sparse LDLT", by("symmetric", symmetric(sparsity(f, f.pattern()))));
  agree("Krylov", by("Krylov", f, newton<MatrixFree<>>()));
  if (dt * stiffness < 0.1)
    agree("fixed point", by("fixed point", f, fixed_point()),
          std::pow(2 * u, 2.0 / 3) / (64 * u));  // where it may stop
}

/// 11. Springs: conjugate gradients on the network, and dense LU of the same force as a function.
inline void networks(Source& source) {
  const int n = source.integer("particles", 2, 6);
  std::vector<Spring> springs;
  // A chain, so that all hang together, and more.
  for (std::ptrdiff_t i = 1; i < n; ++i) springs.push_back({i - 1, i, source.decades("stiffness", 0, 3), 1});
  while (source.more(4)) {
    const auto i = static_cast<std::ptrdiff_t>(source.below(static_cast<std::uint64_t>(n)));
    const auto j = static_cast<std::ptrdiff_t>(source.below(static_cast<std::uint64_t>(n)));
    if (i != j) springs.push_back({i, j, source.decades("stiffness", 0, 3), 0.5});
  }
  Motion<Vec> start{source.numbers("jitter", 3 * n, 0.1), source.numbers("v", 3 * n, 0.1)};
  for (Eigen::Index i = 0; i < n; ++i)
    start.r.segment<3>(3 * i) += Eigen::Vector3d(1.1 * static_cast<double>(i), 0.3 * static_cast<double>(i % 2), 0);
  const double dt = source.decades("dt", -3, -2);  // Δt²k ≤ 0.1: one solution
  const auto by_hand = [&springs](const Vec& r) -> Vec {
    Vec f = Vec::Zero(r.size());
    for (const Spring& s : springs) {
      const Eigen::Vector3d d = r.segment<3>(3 * s.j) - r.segment<3>(3 * s.i);
      const Eigen::Vector3d pull = s.stiffness * (d.norm() - s.length) / d.norm() * d;
      f.segment<3>(3 * s.i) += pull;
      f.segment<3>(3 * s.j) -= pull;
    }
    return f;
  };
  Motion<Vec> one = start, other = start;
  PhiStepper edges{one, spring_network<3>(springs), backward_euler};
  PhiStepper dense{other, by_hand, backward_euler};
  const bool ok = static_cast<bool>(dense.step(other, 0, dt));
  source.assume(ok);
  const StepReport report = edges.step(one, 0, dt);
  source.require(static_cast<bool>(report), report.message());
  // Both end at rounding in Δt Ψ, of springs up to 2e4 · 4 long ones a particle; W ≥ M but where springs are compressed.
  double stiffest = 0;
  for (const Spring& s : springs) stiffest += s.stiffness;
  const double size = one.r.cwiseAbs().maxCoeff() + dt * one.v.cwiseAbs().maxCoeff();
  source.bound((one.r - other.r).cwiseAbs().maxCoeff() + dt * (one.v - other.v).cwiseAbs().maxCoeff(),
               64 * u * (1 + dt * dt * stiffest) * size, "edges differ from dense LU");
}

/// y' = −A(y − g(t)) + c tanh(By) + g', smooth; g(t) = sin(ωt + p).
struct Smooth {
  Mat A, B;
  Vec phases;
  double rate, bend;
  Vec operator()(const Vec& y, double t) const {
    const Vec g = (rate * t + phases.array()).sin(), slope = rate * (rate * t + phases.array()).cos();
    return -A * (y - g) + slope + bend * (B * y).array().tanh().matrix();
  }
};

/// 12. Any smooth problem, any scheme, any rtol: the run ends at t1 exactly, its error is within 10 κ rtol, time grows, steps
/// obey their bounds.
///
/// κ: the largest growth of a relative error (of |y| + 1) made at one of four times, by two runs to 1e-11.
inline void runs(Source& source) {
  const int n = source.integer("n", 1, 3);
  Smooth f;
  const Mat half = source.matrix("half of A", n, n, 1);
  f.A = source.decades("stiffness", -1, 2) * half * half.transpose() + Mat::Identity(n, n) * source.real("decay", 0, 1);
  f.B = source.matrix("B", n, n, 1);
  f.phases = source.numbers("phases", n, 3);
  f.rate = source.real("omega", 0, 4);
  f.bend = source.real("bend", 0, 1);
  const Vec start = source.numbers("y", n, 1);
  const double t0 = source.number("t0", 2), t1 = t0 + source.real("span", 0.25, 4),
               rtol = source.decades("rtol", -7, -2);
  tolerance control{.rtol = rtol, .atol = rtol};
  const bool bounded = source.flag("bounded");
  if (bounded) control.max_step = source.real("max_step", 0.02, 0.5);
  const auto g = [&f](double t, const Vec& y) { return f(y, t); };
  const auto exact = [&](const Vec& y, double from) { return problems::extrapolate(g, y, from, t1, 1, 1e-11); };
  const Vec answer = exact(start, t0);
  double kappa = 1;
  constexpr int times = 4;
  Vec y = start;
  for (int k = 0; k < times; ++k) {
    const double t = t0 + (t1 - t0) * k / times;
    if (k > 0) y = problems::extrapolate(g, y, t0 + (t1 - t0) * (k - 1) / times, t, 1, 1e-11);
    double sum = 0;  // errors of all components at once, at their worst signs
    for (Eigen::Index i = 0; i < n; ++i) {
      Vec moved = y;
      const double by = 1e-4 * (std::abs(y[i]) + 1);
      moved[i] += by;
      sum += ((exact(moved, t) - answer).array() / (answer.array().abs() + 1)).abs().maxCoeff() / 1e-4;
    }
    kappa = std::max(kappa, sum);
  }
  double last = t0, shortest = HUGE_VAL, longest = 0;
  bool grows = true;
  const auto watch = [&](double t, const Vec&) {
    if (t == t0) return;
    grows = grows && t > last;
    shortest = std::min(shortest, t - last), longest = std::max(longest, t - last);
    last = t;
  };
  Vec end = start;
  const auto by = [&](auto scheme) {
    PhiStepper stepper{end, f, scheme};
    return integrate(stepper, end, {t0, t1}, control, watch);
  };
  RunReport report;
  switch (source.one_of("scheme", {"TR-BDF2", "Rodas5P", "trapezoidal", "Radau"})) {
    case 0:
      report = by(tr_bdf2);
      break;
    case 1:
      report = by(rodas5p);
      break;
    case 2:
      report = by(trapezoidal);
      break;
    default:
      report = by(radau);
  }
  if (!report) throw property::Broken("a run fails: " + report.message());
  source.require(report.t == t1 && last == t1, "a run ends elsewhere");
  source.require(grows, "time doesn't grow");
  // The last step before a stop is stretched by up to a hundredth rather than followed by a tiny one.
  if (bounded)
    source.require(longest <= control.max_step + 40 * u * (std::abs(t1) + 1), "a step is longer than max_step");
  source.require(report.largest_dt >= report.smallest_dt && report.smallest_dt > 0, "steps have no length");
  const double error = ((end - answer).array() / (answer.array().abs() + 1)).abs().maxCoeff();
  source.bound(error, 10 * kappa * rtol, "the error is beyond 10 kappa rtol");
}

}  // namespace agreement

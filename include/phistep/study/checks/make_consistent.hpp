/// @file
/// Consistent initial values for M y' = Ψ(t, y) with a singular M. With P Ψ for what is no M y' (of a diagonal M the rows
/// without mass), y is consistent where P Ψ(t, y) = 0. Newton's method finds the y nearest to the one given with
///
///     P Ψ(t, y) = 0,   M y as it was,     by   (M + P J) δ = −P Ψ                                               (1)
///     P Ψ(t, y) = 0,   y_i as it was for the components i that the user fixes                                   (2)
///
/// damped by the natural monotonicity test (P. Deuflhard, Newton Methods for Nonlinear Problems, Springer 2004, sect. 3.3).
/// J comes from differences, matrices are dense: each iteration calls the force once for each component that may change.
#pragma once

#include <Eigen/Core>
#include <Eigen/QR>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>
#include <vector>

#include "phistep/base/facts/scheme_facts.hpp"
#include "phistep/base/outcome/outcome.hpp"
#include "phistep/base/outcome/step_report.hpp"
#include "phistep/base/state/blocks.hpp"
#include "phistep/base/state/unknowns.hpp"
#include "phistep/step/mass/bound_masses.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// What make_consistent may change.
struct ConsistentOptions {
  std::vector<Eigen::Index> fixed{};  ///< components that stay, as many as M has rank; none named: M y stays
};

/// How it went. Contextually true on success.
struct ConsistentReport {
  Outcome outcome = Outcome::success;  ///< success, or why the state is unchanged
  int iterations = 0;                  ///< of Newton's method

  [[nodiscard]] explicit operator bool() const { return outcome == Outcome::success; }
  [[nodiscard, gnu::cold]] std::string message() const {
    if (outcome == Outcome::singular_matrix)
      return "phistep: the algebraic equations do not determine the components that may change: fix others, or the "
             "index is higher than one.";
    return explain(outcome, ", after " + std::to_string(iterations) + " iterations of make_consistent");
  }
};

/// Newton's method for (1) or (2), n unknowns in one vector.
template <class Scalar>
class ConsistentSolve {
 public:
  using Vector = Eigen::Matrix<Scalar, Eigen::Dynamic, 1>;
  using Matrix = Eigen::Matrix<Scalar, Eigen::Dynamic, Eigen::Dynamic>;

  /// @param residual  residual(x, out): out = P Ψ at x; false: it isn't finite
  /// @param M         n×n
  /// @param project   project(δ) leaves of a correction the part with M δ = 0
  /// @param free      the components that may change; if all may, M x stays
  [[nodiscard]] ConsistentReport operator()(Vector& x, auto&& residual, const Matrix& M, auto&& project,
                                            const std::vector<Eigen::Index>& free) {
    ConsistentReport report;
    Vector r(x.size()), next, tried, delta, after;
    if (!residual(x, r)) return {Outcome::non_finite_force};
    double last = std::numeric_limits<double>::infinity();
    while (r.cwiseAbs().maxCoeff() > 0) {
      if (report.iterations == 100) return report.outcome = Outcome::newton_stalled, report;
      ++report.iterations;
      scale_ = x.cwiseAbs().cwiseMax(Scalar(1e-3) * x.cwiseAbs().maxCoeff());
      for (Scalar& each : scale_)
        if (each == 0) each = 1;
      if (const Outcome bad = linearize(x, r, residual, M, free); failed(bad)) return report.outcome = bad, report;
      delta = solve(r, free);
      project(delta);
      const double size = size_of(delta);
      if (!std::isfinite(size)) return report.outcome = Outcome::singular_matrix, report;
      // Where corrections no longer fall, what is left is rounding.
      if (size <= 4 * round_off || (size <= 1e-9 && size > last / 4)) return report;
      last = size;
      for (Scalar length{1};; length /= 2) {
        if (length < Scalar(1e-4)) return report.outcome = Outcome::newton_diverged, report;
        next = x + length * delta;
        if (!residual(next, tried)) continue;
        after = solve(tried, free);
        if (size_of(after) <= (1 - static_cast<double>(length) / 4) * size) break;
        if (size <= 1e-9) return report;
      }
      x.swap(next);
      r.swap(tried);
    }
    return report;
  }

 private:
  static constexpr double round_off = static_cast<double>(std::numeric_limits<Scalar>::epsilon());

  [[nodiscard]] Outcome linearize(Vector& x, const Vector& r, auto& residual, const Matrix& M,
                                  const std::vector<Eigen::Index>& free) {
    if (free.empty()) return Outcome::singular_matrix;
    Matrix A(x.size(), std::ssize(free));
    Vector there(x.size());
    for (Eigen::Index k = 0; const Eigen::Index j : free) {
      const Scalar was = x[j];
      x[j] += std::sqrt(std::numeric_limits<Scalar>::epsilon()) * scale_[j];
      const Scalar by = x[j] - was;
      const bool finite = residual(x, there);
      x[j] = was;
      if (!finite) return Outcome::non_finite_jacobian;
      A.col(k++) = (there - r) / by;
    }
    if (A.cols() == x.size())
      if (const Scalar size = M.cwiseAbs().maxCoeff(); size > 0)
        A += std::max(A.cwiseAbs().maxCoeff() / size, std::numeric_limits<Scalar>::min()) * M;
    // Scaled: columns by the size of x, rows by their largest entry.
    A = (A * scale_(free).asDiagonal()).eval();
    rows_ = A.cwiseAbs().rowwise().maxCoeff();
    for (Scalar& each : rows_) each = each > 0 ? 1 / each : 1;
    qr_.setThreshold(std::sqrt(std::numeric_limits<Scalar>::epsilon()) / 8);  // differences are good to √u
    qr_.compute(rows_.asDiagonal() * A);
    return qr_.rank() == A.cols() ? Outcome::success : Outcome::singular_matrix;
  }
  /// δ of the last linearization
  [[nodiscard]] Vector solve(const Vector& r, const std::vector<Eigen::Index>& free) const {
    const Vector scaled = -rows_.cwiseProduct(r);
    Vector delta = Vector::Zero(r.size());
    delta(free) = scale_(free).cwiseProduct(qr_.solve(scaled));
    return delta;
  }
  [[nodiscard]] double size_of(const Vector& delta) const {
    return static_cast<double>(delta.cwiseQuotient(scale_).cwiseAbs().maxCoeff());
  }

  Vector scale_, rows_;
  Eigen::ColPivHouseholderQR<Matrix> qr_;
};

/// Makes a state consistent with the algebraic equations of a stepper's M y' = Ψ(t, y), M singular: by default M y stays as it
/// is (of a diagonal M the components with mass), else the components named.
///
///     make_consistent(stepper, y, 0.0);                         // components without mass follow from the others
///     make_consistent(stepper, y, 0.0, {.fixed = {0, 3}});      // components 0 and 3 are given, all others follow
///
/// @param state  n unknowns; where it fails, the state keeps every bit
/// @param t      [time] of the state
/// @return success, or newton_diverged, newton_stalled, non_finite_force, non_finite_jacobian; singular_matrix where the
///         equations don't determine what may change
/// @throws std::invalid_argument for more than 1000 unknowns, a component fixed that there isn't, or an M that is regular
template <class Stepper, State S>
[[nodiscard]] ConsistentReport make_consistent(Stepper& stepper, S& state, ScalarOf<S> t,
                                               const ConsistentOptions& options = {}) {
  if constexpr (requires { stepper.stepper(); }) {
    return make_consistent(stepper.stepper(), state, t, options);
  } else {
    using Scalar = ScalarOf<S>;
    const Index n = unknowns<S>(state);
    if (!algebraic_component(stepper.masses()))
      throw std::invalid_argument(
          "phistep: make_consistent needs a singular M: here all components have an equation y'");
    if (n > 1000) throw std::invalid_argument("phistep: make_consistent takes dense matrices of at most 1000 unknowns");
    for (const Index i : options.fixed)
      if (i < 0 || i >= n)
        throw std::invalid_argument("phistep: there is no component " + std::to_string(i) + " to be fixed");
    using Solve = ConsistentSolve<Scalar>;
    typename Solve::Matrix M = Solve::Matrix::Zero(n, n);
    PlainState<S> y;
    copy_blocks<S>(y, state);
    for_each_part(
        [&M](Index at, const auto& block, const auto& mass) {
          mass.for_each_entry(block.size(),
                              [&](Index i, Index j, auto m) { M(at + i, at + j) += static_cast<Scalar>(m); });
        },
        Blocks<S>::solved(y), stepper.masses());
    typename Solve::Vector x(n);
    take_unknowns<S>(x, y);
    RateOf<S> rate = make_rate<S>(y);
    const auto residual = [&](const auto& at, auto& out) {
      put_unknowns<S>(at, y);
      auto& rhs = StepperInternals::kernel(stepper).rhs();
      rhs.begin(t, Scalar{0}, y);
      rhs.evaluate_into(t, y, rate);
      if (first_non_finite(RateOf<S>::blocks(rate))) return false;
      keep_unexplained(RateOf<S>::blocks(rate), stepper.masses());
      out.resize(n);
      for_each_part([&out](Index from, const auto& block) { part(out, from, block) = flat(block); },
                    RateOf<S>::blocks(rate));
      return true;
    };
    const bool by_mass = options.fixed.empty() && M.isDiagonal(Scalar{0});
    std::vector<Index> free;
    for (Index i = 0; i < n; ++i)
      if (by_mass ? M(i, i) == 0 : std::count(options.fixed.begin(), options.fixed.end(), i) == 0) free.push_back(i);
    // What M sees of a correction is rounding.
    const auto project = [&](auto& correction) {
      if (std::ssize(free) < n) return;
      put_unknowns<S>(correction, y);
      keep_unseen(Blocks<S>::solved(y), stepper.masses());
      take_unknowns<S>(correction, y);
    };
    const ConsistentReport report = Solve{}(x, residual, M, project, free);
    if (report) {
      put_unknowns<S>(x, y);
      copy_blocks<S>(state, y);
    }
    return report;
  }
}

}}  // namespace phistep::PHISTEP_ABI

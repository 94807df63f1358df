/// @file
/// What a linearized problem M u' = K r + C u, r' = u (motion) or M y' = C y (first order) is like: exact eigenvalues where
/// it is small, guaranteed bounds where it isn't.
#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <Eigen/Eigenvalues>
#include <Eigen/SparseCore>

#include <algorithm>
#include <cmath>
#include <complex>
#include <vector>

#include "phistep/study/stability/method.hpp"
#include "phistep/study/stability/spectral_bound.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// Up to this size all eigenvalues are computed.
inline constexpr Eigen::Index exact_spectrum_limit = 200;

/// ∂Ψ/∂r (n × p) and ∂Ψ/∂u (n × n) of a force or one term; p = 0 for a first-order state.
struct Tangent {
  SparseRows K, C;
  bool known = true;   ///< false: nothing could be differentiated
  bool finite = true;  ///< false: an entry, or Ψ itself, isn't

  [[nodiscard]] bool is_zero() const { return known && finite && largest(K) == 0 && largest(C) == 0; }
  [[nodiscard]] static double largest(const SparseRows& A) {
    return A.nonZeros() > 0 ? A.coeffs().abs().maxCoeff() : 0;
  }
};

/// The masses: lumped, or a matrix; both divided by the largest one (as the tangents are), so that no unit matters.
struct PreflightMasses {
  Eigen::VectorXd lumped;  ///< the diagonal
  Eigen::MatrixXd matrix;  ///< all of it, where it is a small matrix
  bool is_matrix = false;
  /// With D the diagonal of a symmetric M, M ≥ q D; q ≤ 0: no such bound.
  double lower = 1;
  double largest = 1;  ///< what they were divided by [mass]
};

/// Rates of a linearized term or sum. [1/time], but for `stiffness` [1/time²]
struct Spectrum {
  bool bounded = true;       ///< false: nothing is guaranteed
  bool exact = false;        ///< eigenvalues, not bounds
  bool oscillates = false;   ///< symmetric K: modes of it alone have ω² ≤ stiffness
  bool dissipative = true;   ///< C + Cᵀ ≤ 0
  bool has_C = false;        ///< u matters to its own rate
  double stiffness = 0;      ///< ω²_max of K
  double damping = 0;        ///< c_max of C
  double least_damping = 0;  ///< c_min
  double radius = 0;         ///< of all eigenvalues
  double growth = 0;         ///< largest Re λ, 0 where none grows (exact only)
  double real_decay = -1;    ///< first order: all eigenvalues lie in discs left of 0 that end here; −1: unknown
  double left = 0, right = 0, up = 0;             ///< first order: Re λ in [−left, −right], |Im λ| ≤ up
  std::vector<std::complex<double>> eigenvalues;  ///< all of them, if exact
  Eigen::Index component = -1;                    ///< where the stiffest mode is largest
};

template <class = void>
[[nodiscard]] bool is_symmetric(const SparseRows& A, double tolerance) {
  if (A.rows() != A.cols()) return false;
  return Tangent::largest(SparseRows(A - SparseRows(A.transpose()))) <= tolerance * Tangent::largest(A);
}

/// Small and dense, divided by the masses.
template <class = void>
[[nodiscard]] DenseSystemMatrices divided(const Tangent& tangent, const PreflightMasses& masses) {
  const Eigen::MatrixXd K = tangent.K, C = tangent.C;
  if (masses.is_matrix) {
    const auto lu = masses.matrix.partialPivLu();
    return {lu.solve(K), lu.solve(C)};
  }
  const Eigen::VectorXd inverse = masses.lumped.cwiseInverse();
  return {inverse.asDiagonal() * K, inverse.asDiagonal() * C};
}

/// λ of A u = λ M u for the symmetric part of A and M > 0, ascending; `component`: where the mode of the largest |λ| is largest.
template <class = void>
[[nodiscard]] Eigen::VectorXd symmetric_eigenvalues(const SparseRows& A, const PreflightMasses& masses,
                                                    Eigen::Index& component) {
  Eigen::MatrixXd S = A;
  S = ((S + S.transpose()) / 2).eval();
  const Eigen::VectorXd root = masses.lumped.cwiseSqrt();
  if (masses.is_matrix) {
    const Eigen::LLT<Eigen::MatrixXd> cholesky(masses.matrix);
    const Eigen::MatrixXd half = cholesky.matrixL().solve(S);
    S = cholesky.matrixL().solve(half.transpose()).transpose();
  } else {
    S = (root.cwiseInverse().asDiagonal() * S * root.cwiseInverse().asDiagonal()).eval();
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(S);
  const Eigen::VectorXd& values = solver.eigenvalues();
  if (values.size() > 0) {
    const Eigen::Index stiffest = -values[0] >= values[values.size() - 1] ? 0 : values.size() - 1;
    solver.eigenvectors().col(stiffest).cwiseQuotient(root).cwiseAbs().maxCoeff(&component);
  }
  return values;
}
template <class = void>
[[nodiscard]] bool is_positive_definite(const Eigen::MatrixXd& M, double tolerance) {
  return (M - M.transpose()).cwiseAbs().maxCoeff() <= tolerance * M.cwiseAbs().maxCoeff() &&
         M.llt().info() == Eigen::Success;
}

template <class = void>
[[nodiscard]] std::vector<std::complex<double>> eigenvalues_of(const Eigen::MatrixXd& A) {
  if (A.size() == 0) return {};
  const Eigen::EigenSolver<Eigen::MatrixXd> solver(A, false);
  const auto& values = solver.eigenvalues();
  return {values.data(), values.data() + values.size()};
}

/// All eigenvalues of a small problem.
template <class = void>
[[nodiscard]] Spectrum exact_spectrum(const Tangent& tangent, const PreflightMasses& masses, double tolerance) {
  const Eigen::Index p = tangent.K.cols(), n = tangent.C.rows();
  Spectrum s;
  s.exact = true;
  s.has_C = Tangent::largest(tangent.C) > 0;
  const bool symmetric_mass = !masses.is_matrix || is_positive_definite(masses.matrix, tolerance);
  const bool symmetric_K = p == n && symmetric_mass && is_symmetric(tangent.K, tolerance);
  const bool symmetric_C = symmetric_mass && is_symmetric(tangent.C, tolerance);
  const DenseSystemMatrices system = divided(tangent, masses);
  Eigen::Index component = -1;
  s.oscillates = symmetric_K;
  Eigen::VectorXd squares;
  if (p > 0 && symmetric_K) {
    squares = -symmetric_eigenvalues(tangent.K, masses, component);
    s.stiffness = std::max(0.0, squares.maxCoeff());
  } else if (p > 0) {
    for (const auto lambda : eigenvalues_of(system.K.topRows(p))) s.stiffness = std::max(s.stiffness, std::abs(lambda));
  }
  if (s.has_C) {
    Eigen::Index where = -1;
    const Eigen::VectorXd values =
        symmetric_mass ? symmetric_eigenvalues(tangent.C, masses, where) : Eigen::VectorXd::Ones(n);
    if (symmetric_C) {
      s.damping = std::max(0.0, -values.minCoeff());
      s.least_damping = std::max(0.0, -values.maxCoeff());
      s.dissipative = values.maxCoeff() <= tolerance * values.cwiseAbs().maxCoeff();
      if (p == 0) s.eigenvalues.assign(values.begin(), values.end());
    } else {
      const Eigen::MatrixXd sum = system.C + system.C.transpose();
      const auto lambdas = eigenvalues_of(system.C);
      for (const auto lambda : lambdas) s.damping = std::max(s.damping, std::abs(lambda));
      s.dissipative = values.maxCoeff() <= tolerance * sum.cwiseAbs().maxCoeff();
      if (p == 0) s.eigenvalues = lambdas;
      system.C.cwiseAbs().rowwise().sum().maxCoeff(&where);
    }
    if (s.damping * s.damping > s.stiffness) component = where;
  } else if (p == 0) {
    s.eigenvalues.assign(static_cast<std::size_t>(n), 0.0);
  }
  if (p > 0 && !s.has_C && symmetric_K) {
    for (const double square : squares) {
      const std::complex<double> root = std::sqrt(std::complex<double>(-square, 0));
      s.eigenvalues.push_back(root);
      s.eigenvalues.push_back(-root);
    }
  } else if (p > 0) {
    DenseSystemMatrices balanced = system;
    balanced.balance();
    s.eigenvalues = eigenvalues_of(balanced.whole());
  }
  for (const auto lambda : s.eigenvalues) s.radius = std::max(s.radius, std::abs(lambda));
  // A double zero (free motion) or an undamped pair comes out of rounding with a little growth.
  const double noise = (p > 0 ? 1e-6 : 1e-10) * s.radius;
  for (const auto lambda : s.eigenvalues)
    if (lambda.real() > noise) s.growth = std::max(s.growth, lambda.real());
  if (component < 0 && n > 0)
    (system.K.cwiseAbs().rowwise().sum() + system.C.cwiseAbs().rowwise().sum()).maxCoeff(&component);
  s.component = component;
  return s;
}

template <class = void>
[[nodiscard]] SparseRows divided_by_rows(const SparseRows& A, const Eigen::VectorXd& m) {
  return SparseRows(m.cwiseInverse().asDiagonal() * A);
}

/// Bounds for a problem of any size.
template <class = void>
[[nodiscard]] Spectrum bound_spectrum(const Tangent& tangent, const PreflightMasses& masses, int block,
                                      double tolerance) {
  const Eigen::Index p = tangent.K.cols(), n = tangent.C.rows();
  Spectrum s;
  s.has_C = Tangent::largest(tangent.C) > 0;
  if (n == 0) return s;
  const bool symmetric_K = p == n && is_symmetric(tangent.K, tolerance),
             symmetric_C = is_symmetric(tangent.C, tolerance);
  // M ≥ q D: lumped masses no larger than M bound the symmetric tangents' eigenvalues.
  if (masses.is_matrix && (masses.lower <= 0 || !symmetric_C || (p > 0 && !symmetric_K))) {
    s.bounded = false;
    return s;
  }
  const Eigen::VectorXd m = masses.lower * masses.lumped;
  s.oscillates = symmetric_K;
  if (p > 0 && symmetric_K) {
    const EigenvalueBound bound = largest_eigenvalue_bound(-tangent.K, m, block);
    s.stiffness = std::max(0.0, bound.value);
    s.component = bound.row;
  } else if (p == n) {
    const EigenvalueBound bound = spectral_radius_bound(divided_by_rows(tangent.K, m));
    s.stiffness = bound.value;
    s.component = bound.row;
  } else if (p > 0) {
    s.bounded = false;  // other unknowns beside r and v
    return s;
  }
  if (s.has_C) {
    const SparseRows transposed = tangent.C.transpose();
    const SparseRows even = (tangent.C + transposed) / 2, odd = (tangent.C - transposed) / 2;
    const EigenvalueBound decay = largest_eigenvalue_bound(-even, m, block);
    const double rise = largest_eigenvalue_bound(even, m, block).value;
    s.left = std::max(0.0, decay.value);
    s.right = std::max(0.0, -rise);
    s.up = symmetric_C ? 0 : spectral_radius_bound(divided_by_rows(odd, m)).value;
    s.damping = s.left + s.up;
    s.least_damping = masses.is_matrix ? 0 : s.right;
    s.dissipative = rise <= 1e-9 * s.left;
    if (s.damping * s.damping > s.stiffness || p == 0) s.component = decay.row;
    if (p == 0 && symmetric_C) s.real_decay = std::max(s.left, rise);
    if (p == 0 && !symmetric_C) {
      // Discs that lie left of 0, by rows or by columns.
      for (const SparseRows& A :
           {divided_by_rows(tangent.C, m), SparseRows(divided_by_rows(tangent.C, m).transpose())}) {
        double reach = 0;
        bool left = true;
        for (Eigen::Index i = 0; i < n; ++i) {
          double own = 0, others = 0;
          for (SparseRows::InnerIterator entry(A, i); entry; ++entry)
            (entry.col() == i ? own : others) += entry.col() == i ? entry.value() : std::abs(entry.value());
          left = left && own + others <= 1e-12 * std::abs(own);
          reach = std::max(reach, others - own);
        }
        if (left && (s.real_decay < 0 || reach < s.real_decay)) s.real_decay = reach;
      }
    }
  }
  // Motion: |λ|² ≤ c|λ| + ω².
  if (p > 0) s.radius = s.damping / 2 + std::sqrt(s.damping * s.damping / 4 + s.stiffness);
  else if (symmetric_C) s.radius = s.real_decay;
  else if (s.has_C) s.radius = spectral_radius_bound(divided_by_rows(tangent.C, m)).value;
  return s;
}

template <class = void>
[[nodiscard]] Spectrum spectrum_of(const Tangent& tangent, const PreflightMasses& masses, int block, double tolerance) {
  Spectrum none;
  none.bounded = false;
  if (!tangent.known || !tangent.finite) return none;
  if (tangent.C.rows() == 0) return {};
  if (tangent.K.cols() + tangent.C.rows() <= exact_spectrum_limit) return exact_spectrum(tangent, masses, tolerance);
  return bound_spectrum(tangent, masses, block, tolerance);
}

}}  // namespace phistep::PHISTEP_ABI

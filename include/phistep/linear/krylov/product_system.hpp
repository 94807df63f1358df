/// @file
/// W δ = F by an iterative solver that knows W = M − γ_f C − γ_f γ_d K by its products alone.
///
/// Newton needs no exact δ far from the solution: the relative tolerance of each linear solve is Eisenstat and Walker's
/// second choice, η_k = 0.9 (‖F_k‖/‖F_{k−1}‖)², with η_0 = 0.1 (SIAM J. Sci. Comput. 17 (1996) 16, eq. 2.6), so that few
/// iterations are spent early and Newton still ends quadratically. That is for solves to rounding. To a tolerance one or two
/// corrections are all there are, and η is 1/20 throughout: a first correction to 1/10 only raised the rate that Newton
/// measures (47 iterations in place of 36), and a second one to 0.9/100 was ten times closer than anybody needed.
#pragma once

#include <Eigen/Core>
#include <Eigen/IterativeLinearSolvers>
#include <Eigen/SparseCore>

#include <algorithm>
#include <cmath>
#include <limits>
#include <type_traits>

#include "phistep/base/facts/implicit_solver.hpp"
#include "phistep/base/numbers/arithmetic.hpp"
#include "phistep/base/numbers/finite_witness.hpp"
#include "phistep/base/outcome/outcome.hpp"
#include "phistep/base/outcome/statistics.hpp"
#include "phistep/base/version.hpp"
#include "phistep/linear/sparse/own_solver.hpp"
#include "phistep/step/matrix/choice.hpp"
#include "phistep/step/matrix/dense_system.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// W as Eigen's iterative solvers and their preconditioners see it: rows(), cols(), a product, and what is known beside.
template <class Number>
class ProductOperator : public Eigen::EigenBase<ProductOperator<Number>> {
 public:
  using Scalar = Number;
  using RealScalar = Number;
  using StorageIndex = int;
  using Vector = Eigen::Matrix<Number, Eigen::Dynamic, 1>;
  enum { ColsAtCompileTime = Eigen::Dynamic, MaxColsAtCompileTime = Eigen::Dynamic, IsRowMajor = false };

  ProductOperator(Vector& x, Vector& product, void* source, void (*apply)(void*, const Vector&, Vector&))
      : x_{&x}, product_{&product}, source_{source}, apply_{apply} {}

  [[nodiscard]] Eigen::Index rows() const { return x_->size(); }
  [[nodiscard]] Eigen::Index cols() const { return x_->size(); }
  template <class Rhs>
  [[nodiscard]] auto operator*(const Eigen::MatrixBase<Rhs>& x) const {
    return Eigen::Product<ProductOperator, Rhs, Eigen::AliasFreeProduct>(*this, x.derived());
  }
  /// W x, valid until the next product.
  [[nodiscard]] const Vector& product(const auto& x) const {
    *x_ = x;
    apply_(source_, *x_, *product_);
    return *product_;
  }
  Number gamma_force{}, gamma_drift{};  ///< γ_f and γ_d of W [time]
  const Vector* diagonal = nullptr;     ///< of W, null where the force doesn't know it

 private:
  Vector *x_, *product_;
  void* source_;
  void (*apply_)(void*, const Vector&, Vector&);
};

/// Preconditions by W's diagonal where the force knows it, by nothing elsewhere. One's own preconditioner is a default-
/// constructible class with the same members; `compute` sees a ProductOperator at every Newton iteration, with γ_f and γ_d, and may keep what
/// it has made for earlier ones.
template <class Scalar>
class DiagonalOfW {
 public:
  DiagonalOfW() = default;
  template <class Operator>
  explicit DiagonalOfW(const Operator& W) {
    compute(W);
  }
  DiagonalOfW& analyzePattern(const auto&) { return *this; }
  DiagonalOfW& factorize(const auto& W) { return compute(W); }
  DiagonalOfW& compute(const auto& W) {
    inverse_.resize(0);
    if (W.diagonal != nullptr)
      inverse_ = W.diagonal->unaryExpr([](Scalar w) { return w != Scalar{0} ? Scalar{1} / w : Scalar{1}; });
    return *this;
  }
  [[nodiscard]] Eigen::Matrix<Scalar, Eigen::Dynamic, 1> solve(const auto& b) const {
    if (inverse_.size() == 0) return b;
    return inverse_.cwiseProduct(b);
  }
  [[nodiscard]] static Eigen::ComputationInfo info() { return Eigen::Success; }

 private:
  Eigen::Matrix<Scalar, Eigen::Dynamic, 1> inverse_;
};

/// Eigen's conjugate gradients with two parameters, as BiCGSTAB and GMRES have: for symmetric positive definite W.
template <class Matrix, class Preconditioner>
using ConjugateGradient = Eigen::ConjugateGradient<Matrix, Eigen::Lower | Eigen::Upper, Preconditioner>;

/// Newton with products in place of a matrix, e.g. `newton<MatrixFree<Eigen::BiCGSTAB>>()`, with
/// `phistep::ConjugateGradient`, or `Eigen::GMRES` from <unsupported/Eigen/IterativeSolvers>.
/// @tparam Solver          an iterative solver with Eigen's interface
/// @tparam Preconditioner  of one's own; see DiagonalOfW
template <template <class, class> class Solver, class Preconditioner = void>
struct MatrixFree {};
template <template <class, class> class Solver, class Preconditioner>
inline constexpr bool is_matrix_free<MatrixFree<Solver, Preconditioner>> = true;

template <class Scalar, template <class, class> class Solver, class Preconditioner>
class KrylovSystem {
 public:
  using Operator = ProductOperator<Scalar>;
  using Vector = typename Operator::Vector;

  void resize(Eigen::Index n) {
    x_.setZero(n);
    product_.setZero(n);
    residual_.setZero(n);
    solution_.setZero(n);
    begin();
  }
  /// A new Newton iteration.
  void begin() { last_norm_ = 0; }
  static void clear() {}
  [[nodiscard]] static bool is_finite() { return true; }
  [[nodiscard]] static double drift_share() { return 1; }  // unknown: as if springs were stiff

  /// W of this Newton iterate, good for one solve.
  /// @param source     what multiplies: apply(x, out) sets out = W x
  /// @param precision  relative error of its products
  template <class Source>
  void bind(Source& source, const Vector* diagonal, double precision) {
    source_ = &source;
    apply_ = [](void* at, const Vector& x, Vector& out) { static_cast<Source*>(at)->apply(x, out); };
    diagonal_ = diagonal;
    precision_ = precision;
  }
  [[nodiscard]] Outcome factorize(const auto& masses, Scalar gamma_force, Scalar gamma_drift,
                                  Statistics& /*statistics*/) {
    lightest_ = std::numeric_limits<double>::infinity();
    masses([this](Eigen::Index i, Eigen::Index j, auto m) {
      if (i == j) lightest_ = std::min(lightest_, std::abs(static_cast<double>(m)));
    });
    gamma_force_ = gamma_force;
    gamma_drift_ = gamma_drift;
    return Outcome::success;
  }

  /// @param rtol  relative residual at which to stop, 0: by Eisenstat and Walker
  [[nodiscard]] Outcome solve(auto& x, double rtol, Statistics& statistics) {
    const Scalar by = to_unit_size(max_abs(x));  // the solver squares it
    residual_ = by * x;
    const double norm = static_cast<double>(residual_.norm()) / static_cast<double>(by);
    if (norm == 0) return Outcome::success;
    Operator W{x_, product_, source_, apply_};
    W.gamma_force = gamma_force_;
    W.gamma_drift = gamma_drift_;
    W.diagonal = diagonal_;
    if (!solver_) solver_.make();
    auto& solver = *solver_;
    solver.setTolerance(static_cast<Scalar>(rtol > 0 ? std::max(rtol, precision_) : forcing(norm)));
    solver.setMaxIterations(std::min<Eigen::Index>(2 * residual_.size(), iteration_limit));
    solver.compute(W);
    if (solver.info() != Eigen::Success) return Outcome::linear_solver_failed;
    solution_ = solver.solve(residual_);  // not x: Eigen takes no operator's product with vectors of few rows
    x = solution_ / by;
    statistics.linear_iterations += static_cast<std::int64_t>(solver.iterations());
    if (!all_finite(product_.data(), product_.size())) return Outcome::non_finite_jacobian;
    return solver.info() == Eigen::Success ? Outcome::success : Outcome::linear_solver_failed;
  }

  /// … to an error of about `absolute` in the weighted norm, ‖x‖² = 1/n Σ (w_i x_i)². What is known of W⁻¹ is that it isn't larger than
  /// M⁻¹ where the force doesn't blow up, and of the residual, that it has no reason to gather where weights are large:
  ///
  ///     ‖W⁻¹r‖_w ≲ ‖r‖ ‖w‖ / (n min m_i)
  ///
  /// With components that have no mass the first is wrong, and the solve is one to a relative residual of 1e-10.
  /// @param weigh  weigh(w) sets the weights
  [[nodiscard]] Outcome solve_within(auto& x, double absolute, auto&& weigh, Statistics& statistics) {
    weigh(product_);
    const double weights = static_cast<double>(product_.stableNorm()), size = static_cast<double>(x.stableNorm());
    const auto n = static_cast<double>(x.size());
    const double rtol = lightest_ > 0 && size > 0 ? absolute * lightest_ * n / (weights * size) : 0;
    return solve(x, std::clamp(rtol, 1e-10, 0.1), statistics);
  }

 private:
  static constexpr Eigen::Index iteration_limit = 1000;
  [[nodiscard]] double forcing(double norm) {
    double eta = 0.1;
    if (last_norm_ > 0) {
      eta = 0.9 * (norm / last_norm_) * (norm / last_norm_);
      const double safeguard = 0.9 * last_eta_ * last_eta_;  // eq. 2.10: not smaller than the last ones make likely
      if (safeguard > 0.1) eta = std::max(eta, safeguard);
    }
    last_norm_ = norm;
    last_eta_ = std::clamp(eta, precision_, 0.1);
    return last_eta_;
  }

  using Chosen = std::conditional_t<std::is_void_v<Preconditioner>, DiagonalOfW<Scalar>, Preconditioner>;
  OwnSolver<Solver<Operator, Chosen>> solver_;  // holds the preconditioner
  Vector x_, product_, residual_, solution_;
  void* source_ = nullptr;
  void (*apply_)(void*, const Vector&, Vector&) = nullptr;
  const Vector* diagonal_ = nullptr;
  Scalar gamma_force_{}, gamma_drift_{};
  double precision_ = 0, last_norm_ = 0, last_eta_ = 0;
  double lightest_ = 0;  // the least mass
};

template <MatrixFacts facts, class Scalar, template <class, class> class Solver, class Preconditioner, class Force>
struct SystemFor<SystemKind::matrix_free, facts, Scalar, MatrixFree<Solver, Preconditioner>, Force> {
  using type = KrylovSystem<Scalar, Solver, Preconditioner>;
};

}}  // namespace phistep::PHISTEP_ABI

namespace Eigen::internal {
template <class Scalar>
struct traits<phistep::ProductOperator<Scalar>> : traits<Eigen::SparseMatrix<Scalar>> {};
template <class Scalar, class Rhs>
struct generic_product_impl<phistep::ProductOperator<Scalar>, Rhs, SparseShape, DenseShape, GemvProduct>
    : generic_product_impl_base<phistep::ProductOperator<Scalar>, Rhs,
                                generic_product_impl<phistep::ProductOperator<Scalar>, Rhs>> {
  template <class Dest>
  static void scaleAndAddTo(Dest& dst, const phistep::ProductOperator<Scalar>& W, const Rhs& x, const Scalar& alpha) {
    dst.noalias() += alpha * W.product(x);
  }
};
}  // namespace Eigen::internal

/// @file
/// W δ = F by a Krylov method (methods.hpp) that knows W = M − γ_f C − γ_f γ_d K by its products alone, at one iterate: by the force's
/// own products, or by one difference each,
///
///     W x ≈ M x − γ_f [Ψ(r + ε γ_d x, v + ε x) − Ψ(r, v)]/ε,
///
/// with ε such that the largest component moves by √u of what its block's components are or become: no fixed length.
///
/// Newton needs no exact δ far from the solution: the relative tolerance of each linear solve is Eisenstat and Walker's
/// second choice, η_k = 0.9 (‖F_k‖/‖F_{k−1}‖)², with η_0 = 0.1 (SIAM J. Sci. Comput. 17 (1996) 16, eq. 2.6), so that few
/// iterations are spent early and Newton still ends quadratically. That is for solves to rounding. To a tolerance one or two
/// corrections are all there are, and η is 1/20 throughout.
#pragma once

#include <Eigen/Core>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <type_traits>
#include <utility>

#include "phistep/base/facts/implicit_solver.hpp"
#include "phistep/base/numbers/arithmetic.hpp"
#include "phistep/base/numbers/finite_witness.hpp"
#include "phistep/base/outcome/outcome.hpp"
#include "phistep/base/outcome/statistics.hpp"
#include "phistep/base/state/blocks.hpp"
#include "phistep/base/state/combination.hpp"
#include "phistep/base/state/unknowns.hpp"
#include "phistep/linear/krylov/methods.hpp"
#include "phistep/step/equation/right_hand_side.hpp"
#include "phistep/step/jacobian/analytic.hpp"
#include "phistep/step/jacobian/differences.hpp"
#include "phistep/step/mass/bound_masses.hpp"
#include "phistep/step/matrix/choice.hpp"
#include "phistep/step/matrix/linear_system.hpp"
#include "phistep/step/solve/linearization.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// Newton with products in place of a matrix, e.g. `newton<MatrixFree<>>()`, by a method of methods.hpp.
/// @tparam Preconditioner  of one's own, a default-constructible class: compute(W) sees a KnownOfProducts at every Newton iteration,
///                         and may keep what it has made for earlier ones; solve(b) is P⁻¹b. By default W's diagonal where the
///                         force knows it; else, in a solve to a tolerance, that of M.
template <KrylovMethod method = KrylovMethod::bicgstab, class Preconditioner = void>
struct MatrixFree {};
template <KrylovMethod method, class Preconditioner>
inline constexpr bool is_matrix_free<MatrixFree<method, Preconditioner>> = true;

/// What is known of W beside its products.
template <class Scalar>
struct KnownOfProducts {
  Scalar gamma_force{}, gamma_drift{};                                 ///< γ_f and γ_d [time]
  const Eigen::Matrix<Scalar, Eigen::Dynamic, 1>* diagonal = nullptr;  ///< null where the force doesn't know it
};

template <class Scalar, KrylovMethod method, class Preconditioner>
class KrylovSystem : public SystemDefaults {
 public:
  using Vector = Eigen::Matrix<Scalar, Eigen::Dynamic, 1>;

  void resize(Eigen::Index n) {
    set(1, 0);  // unknown: as if springs were stiff, and W differed much from M
    iteration_.resize(n);
    for (Vector* each : {&solution_, &residual_, &masses_, &inverse_}) each->setZero(n);
    begin();
  }
  /// A new Newton iteration.
  void begin() { last_norm_ = 0; }
  static void clear() {}
  [[nodiscard]] static bool is_finite() { return true; }

  /// W of this Newton iterate, good for one solve.
  /// @param source     what multiplies: apply(x, out) sets out = W x
  /// @param precision  relative error of its products
  template <class Source>
  void bind(Source& source, const Vector* diagonal, double precision) {
    source_ = &source;
    apply_ = [](void* at, const Vector& x, Vector& out) { static_cast<Source*>(at)->apply(x, out); };
    known_.diagonal = diagonal;
    precision_ = precision;
  }
  [[nodiscard]] Outcome factorize(const auto& masses, Scalar gamma_force, Scalar gamma_drift,
                                  Statistics& /*statistics*/) {
    masses_.setZero();
    masses([this](Eigen::Index i, Eigen::Index j, auto m) {
      if (i == j) masses_[i] += static_cast<Scalar>(m);
    });
    known_.gamma_force = gamma_force;
    known_.gamma_drift = gamma_drift;
    return Outcome::success;
  }

  /// @param rtol  relative residual at which to stop, 0: by Eisenstat and Walker
  [[nodiscard]] Outcome solve(auto& x, double rtol, Statistics& statistics) {
    weights_.resize(0);
    if (rtol == 0) rtol = forcing(static_cast<double>(x.stableNorm()));
    return iterate(x, {0, std::max(rtol, precision_)}, statistics);
  }
  /// x ← W⁻¹ x to an error of about `absolute` in the weighted norm (methods.hpp). With components that have no mass P⁻¹r says little of
  /// it: then to a relative residual of 1e-10. @param weigh  weigh(w) sets the weights
  [[nodiscard]] Outcome solve_within(auto& x, double absolute, auto&& weigh, Statistics& statistics) {
    if (!(masses_.minCoeff() > Scalar{0})) return solve(x, 1e-10, statistics);
    weights_.resize(x.size());
    weigh(weights_);
    return iterate(x, {absolute, precision_}, statistics);
  }

  // For the methods.
  void multiply(const Vector& x, Vector& out) {
    apply_(source_, x, out);
    has_finite_products_ = has_finite_products_ && all_finite(out.data(), out.size());
  }
  void precondition(const Vector& x, Vector& out) const {
    if constexpr (has_own) out = own_.solve(x);
    else out = inverse_.cwiseProduct(x);
  }
  [[nodiscard]] const Vector& weights() const { return weights_; }

 private:
  static constexpr bool has_own = !std::is_void_v<Preconditioner>;

  [[nodiscard]] Outcome iterate(auto& x, KrylovGoal goal, Statistics& statistics) {
    if constexpr (has_own) own_.compute(known_);
    else if (known_.diagonal == nullptr && weights_.size() == 0) inverse_.setOnes();  // scaling by M may hide stiffness
    else
      inverse_ = (known_.diagonal != nullptr ? *known_.diagonal : masses_).unaryExpr([](Scalar w) {
        return w != Scalar{0} ? 1 / w : Scalar{1};
      });
    const Scalar by = to_unit_size(max_abs(x));  // the methods square it
    residual_ = by * x;
    goal.absolute *= static_cast<double>(by);
    goal.max_iterations = static_cast<int>(std::min<Eigen::Index>(2 * x.size(), goal.max_iterations));
    solution_.setZero();
    has_finite_products_ = true;
    const KrylovEnd end = iteration_.solve(*this, goal, residual_, solution_);
    x = solution_ / by;
    statistics.linear_iterations += end.iterations;
    if (!has_finite_products_) return Outcome::non_finite_jacobian;
    return end.converged ? Outcome::success : Outcome::linear_solver_failed;
  }
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

  KrylovIteration<Scalar, method> iteration_;
  std::conditional_t<has_own, Preconditioner, int> own_{};
  KnownOfProducts<Scalar> known_;
  Vector solution_, residual_, masses_, inverse_, weights_;
  void* source_ = nullptr;
  void (*apply_)(void*, const Vector&, Vector&) = nullptr;
  double precision_ = 0, last_norm_ = 0, last_eta_ = 0;
  bool has_finite_products_ = true;
};

template <MatrixFacts facts, class Scalar, KrylovMethod method, class Preconditioner, class Force>
struct SystemFor<SystemKind::matrix_free, facts, Scalar, MatrixFree<method, Preconditioner>, Force> {
  using type = KrylovSystem<Scalar, method, Preconditioner>;
};

template <State S, class Rhs, bool has_K, bool has_C>
class TangentProduct {
 public:
  using Scalar = ScalarOf<S>;
  using Plain = PlainState<S>;
  using Rate = RateOf<S>;
  using Vector = Eigen::Matrix<Scalar, Eigen::Dynamic, 1>;
  using Products = ProductTraits<typename Rhs::Force, std::remove_cvref_t<typename Rhs::View>, Rate>;
  static constexpr int n_static = static_unknowns<S>;

  void resize(const Plain& y, const auto& /*rhs*/) {
    Y_ = direction_ = probe_ = y;
    psi_ = rate_ = make_rate<S>(y);
    diagonal_.setZero(unknowns<S>(y));
    entries_.setZero(unknowns<S>(y));
  }
  static void begin() {}
  static void forget_pattern() {}
  [[nodiscard]] static bool differences_reached_too_far(const auto&, const auto&) { return false; }

  /// Serves products at (t, Y), where Ψ is psi, to the system's next solve.
  void compute(Rhs& rhs, const Gamma<Scalar>& gamma, Scalar t, const Plain& Y, const Rate& psi,
               const NewtonOptions& options, const SolveTolerance<Plain>&, auto& system) {
    rhs_ = &rhs;
    gamma_ = gamma;
    t_ = rhs.inside(t);
    // Copies: products may be needed after the last correction, which moves Y: Ψ is that of the iterate before.
    copy_blocks<S>(Y_, Y);
    psi_ = psi;
    if constexpr (!Products::has_product) scale_ = scales(options);
    if constexpr (Products::has_diagonal) compute_diagonal();
    // Differences are good to √u.
    const double u = static_cast<double>(std::numeric_limits<Scalar>::epsilon());
    system.bind(*this, Products::has_diagonal ? &diagonal_ : nullptr,
                Products::has_product ? std::sqrt(u) : 100 * std::sqrt(u));
  }

  /// out = W x
  void apply(const Vector& x, Vector& out) {
    put_unknowns<S>(x, direction_);
    if constexpr (Rhs::drifts) {
      if constexpr (has_K) position_of<S>(direction_) = gamma_.drift * velocity_of<S>(direction_);
      else position_of<S>(direction_).setZero();
    }
    if constexpr (Products::has_product) multiply(x);
    else if (!differ()) return out.setZero(), void();
    for_each_part(
        [&](Index at, const auto& block, const auto& mass) {
          auto product = part(out, at, block);
          product = gamma_.force * flat(block);
          mass.subtract_product(part(x, at, block), product);
          product = -product;
        },
        Rate::blocks(std::as_const(rate_)), rhs_->masses());
  }

 private:
  void multiply(const Vector& x) {
    set_zero(Rate::blocks(rate_));
    // Entries are numbered through all unknowns, wherever their blocks lie.
    entries_.setZero();
    ProductSink<Scalar> sink{nullptr, x.data(), entries_.data()};
    if constexpr (Rhs::drifts) sink.r = position_of<S>(direction_).data();
    add_product<has_K || !Rhs::drifts, n_static>(rhs_->force(), t_, rhs_->view(Y_), rhs_->trial_memory(),
                                                 rhs_->view(direction_), diagonal_.size(), rate_, sink);
    for_each_block([](auto, const auto& product, const auto& of) { check_result_size(product, of); },
                   Rate::blocks(std::as_const(rate_)), Rate::blocks(std::as_const(psi_)));
    for_each_part([this](Index at, auto& block) { flat(block) += part(entries_, at, block); }, Rate::blocks(rate_));
  }

  /// rate_ = the derivative of Ψ along direction_, by a difference. False where direction_ is zero.
  [[nodiscard]] bool differ() {
    double reach = std::numeric_limits<double>::infinity();
    std::size_t k = 0;
    for_each_solved<S>(
        [&](Index, const auto& block) {
          const double size = largest(block);
          if (size > 0) reach = std::min(reach, scale_.solved[k] / size);
          ++k;
        },
        std::as_const(direction_));
    if constexpr (Rhs::drifts && has_K) {
      const double size = largest(position_of<S>(direction_));
      // The first solved block is v. Where both r and v limit the difference, ε is between their limits, the geometric mean.
      if (size > 0 && std::isfinite(reach)) {
        const double by_drift = scale_.position / size;
        // The root of what has no dimension: no other is scaled exactly by the units.
        reach = Rhs::Traits::uses_velocity ? by_drift * std::sqrt(reach / by_drift) : by_drift;
      }
    }
    if (!std::isfinite(reach)) return false;
    const auto epsilon =
        static_cast<Scalar>(std::sqrt(static_cast<double>(std::numeric_limits<Scalar>::epsilon())) * reach);
    assign<S>(probe_, in<S>(Y_) + epsilon * in<S>(direction_));
    rhs_->evaluate_into(t_, probe_, rate_);
    assign_rate<S>(rate_, (in_rate<S>(rate_) - in_rate<S>(psi_)) / epsilon);
    return true;
  }

  struct Scales {
    double position = 1;
    std::array<double, Rhs::blocks> solved{};
  };
  /// What counts as a usual size of a block's components: what they are, or how far a step moves them.
  [[nodiscard]] Scales scales(const NewtonOptions& options) const {
    const double at_least = options.rtol > 0 ? options.atol / options.rtol : 0;
    const auto usual = [](double size, double least) { return size > 0 || least > 0 ? std::max(size, least) : 1.0; };
    Scales all;
    std::size_t k = 0;
    for_each_block(
        [&](auto, const auto& block, const auto& rate, const auto& mass) {
          double size = largest(block);
          if (size == 0) size = largest_kick(gamma_.force, rate, mass);
          if constexpr (Rhs::drifts)
            if (size == 0 && k == 0 && gamma_.drift != Scalar{0})
              size = largest(position_of<S>(Y_)) / std::abs(static_cast<double>(gamma_.drift));
          all.solved[k++] = usual(size, at_least);
        },
        Blocks<S>::solved(std::as_const(Y_)), Rate::blocks(std::as_const(psi_)), rhs_->masses());
    if constexpr (Rhs::drifts) {
      // The tolerance is one for the unknowns, v: r may be off by what v's error moves it.
      const double time = std::abs(static_cast<double>(gamma_.drift));
      const double size = std::max(largest(position_of<S>(Y_)), time * largest(velocity_of<S>(Y_)));
      all.position = usual(size > 0 ? size : time * all.solved[0], time * at_least);
    }
    return all;
  }

  /// W's diagonal out of the entries that the force emits.
  struct DiagonalSink {
    Vector& W;
    const Gamma<Scalar>& gamma;
    void position(Index i, Index j, Scalar x) {
      if constexpr (has_K)
        if (i == j) W[i] -= gamma.force * gamma.drift * x;
    }
    void velocity(Index i, Index j, Scalar x) {
      if (i == j) W[i] -= gamma.force * x;
    }
    void rate(Index i, Index j, Scalar x) { velocity(i, j, x); }
  };
  void compute_diagonal() {
    diagonal_.setZero();
    each_mass_entry<S>(rhs_->masses(), Y_)([this](Index i, Index j, auto m) {
      if (i == j) diagonal_[i] += static_cast<Scalar>(m);
    });
    DiagonalSink sink{diagonal_, gamma_};
    add_diagonal<has_K || !Rhs::drifts, n_static, Rate>(rhs_->force(), t_, rhs_->view(Y_), rhs_->trial_memory(),
                                                        diagonal_.size(), sink);
  }

  // Bound by compute() for the solve that follows it.
  Rhs* rhs_ = nullptr;
  Gamma<Scalar> gamma_{};
  Scalar t_{};

  Plain Y_, direction_, probe_;
  Rate psi_, rate_;
  Vector diagonal_, entries_;
  Scales scale_;
};

template <State S, class Rhs, KrylovMethod method, class Preconditioner, bool has_K, bool has_C>
struct TangentSource<S, Rhs, MatrixFree<method, Preconditioner>, has_K, has_C> {
  using type = TangentProduct<S, Rhs, has_K, has_C>;
};

}}  // namespace phistep::PHISTEP_ABI

/// @file
/// Products with W = M − γ_f C − γ_f γ_d K at one iterate: from the force's own products, or by one difference each,
///
///     W x ≈ M x − γ_f [Ψ(r + ε γ_d x, v + ε x) − Ψ(r, v)]/ε,
///
/// with ε such that the largest component moves by √u of what its block's components are or become: no fixed length.
#pragma once

#include <Eigen/Core>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <type_traits>
#include <utility>

#include "phistep/base/state/blocks.hpp"
#include "phistep/base/state/combination.hpp"
#include "phistep/base/state/unknowns.hpp"
#include "phistep/base/version.hpp"
#include "phistep/linear/krylov/product_system.hpp"
#include "phistep/step/equation/right_hand_side.hpp"
#include "phistep/step/jacobian/analytic.hpp"
#include "phistep/step/mass/bound_masses.hpp"
#include "phistep/step/solve/linearisation.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

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
  [[nodiscard]] static bool reached_too_far(const auto&, const auto&) { return false; }

  /// Serves products at (t, Y), where Ψ is psi, to the system's next solve.
  void compute(Rhs& rhs, const Gamma<Scalar>& gamma, Scalar t, const Plain& Y, const Rate& psi,
               const NewtonOptions& options, const SolveTolerance<Plain>&, auto& system) {
    rhs_ = &rhs;
    gamma_ = gamma;
    t_ = t;
    // Copies: who asks for a product after the last correction finds the iterate moved, and Ψ still that of the one before.
    copy_blocks<S>(Y_, Y);
    copy_rate(psi_, psi);
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

  /// False without a direction.
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
      // The first solved block is v. Where r and v move by different shares of themselves, halfway between.
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
          const auto factor = mass.scaled(gamma_.force);
          if (size == 0)
            for (Index i = 0; i < rate.size(); ++i)
              size = std::max(size, std::abs(static_cast<double>(factor(i) * rate.data()[i])));
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

template <State S, class Rhs, template <class, class> class Solver, class Preconditioner, bool has_K, bool has_C>
struct TangentSource<S, Rhs, MatrixFree<Solver, Preconditioner>, has_K, has_C> {
  using type = TangentProduct<S, Rhs, has_K, has_C>;
};

}}  // namespace phistep::PHISTEP_ABI

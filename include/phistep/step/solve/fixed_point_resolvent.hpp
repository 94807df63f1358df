/// @file
/// M (Y − b) = γ_f Ψ(t, Y) by fixed-point iteration on w = Y − b: w ← γ_f M⁻¹Ψ(t, Y(w)). One force call an iteration and
/// nothing else.
#pragma once

#include <Eigen/Core>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <type_traits>

#include "phistep/base/numbers/arithmetic.hpp"
#include "phistep/base/numbers/finite_witness.hpp"
#include "phistep/base/outcome/outcome.hpp"
#include "phistep/base/outcome/step_report.hpp"
#include "phistep/base/state/blocks.hpp"
#include "phistep/base/state/reductions.hpp"
#include "phistep/base/state/unknowns.hpp"
#include "phistep/step/jacobian/differences.hpp"
#include "phistep/step/solve/fixed_point.hpp"
#include "phistep/step/solve/increment.hpp"
#include "phistep/step/solve/local_resolvent.hpp"
#include "phistep/step/solve/resolvent.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

template <State S, class Rhs>
class FixedPointResolvent : public ResolventDefaults {
  static_assert(!FieldState<S>, "phistep: fixed_point() of a field needs <phistep/fields.hpp>");

 public:
  using Scalar = ScalarOf<S>;
  using Plain = PlainState<S>;
  using Rate = RateOf<S>;
  using Unknown = typename Increment<S>::Unknown;

  FixedPointResolvent(const Plain& y, const Rhs& rhs, const FixedPoint& solver) : options_{solver.options} {
    resize(y, rhs);
  }
  void resize(const Plain& y, const Rhs&) {
    increment_.resize(y);
    image_ = increment_.w;
    anderson_.resize(image_.size(), options_.depth);
  }

  [[nodiscard]] Outcome resolve(Rhs& rhs, const Gamma<Scalar>& gamma, Scalar t, Plain& Y, const Plain& guess, Rate& psi,
                                SolveRecord& record, bool knows_psi = false, SolveTolerance<Plain> allowed = {}) {
    if (options_.rtol > 0) allowed.target = 0;
    increment_.begin(Y, gamma.drift);
    increment_.start(Y, guess);
    anderson_.begin();
    FixedPointTest test(options_, static_cast<double>(std::numeric_limits<Scalar>::epsilon()), allowed.target);
    for (int k = 1;; ++k) {
      if (k > 1 || !knows_psi) rhs.evaluate_into(t, Y, psi);
      map(rhs, gamma, psi);
      if (!all_finite(residual().data(), residual().size()))
        return first_non_finite(Rate::blocks(psi)) ? Outcome::non_finite_force : Outcome::non_finite_state;
      if (k == 1) weigh(Y);
      const Correction size = this->size(Y, allowed);
      record.add(size.beside_all);
      ++rhs.statistics().iterations;
      const Judgement judgement = test.judge(k, size, anderson_.stretches());
      if (judgement == Judgement::growing) return Outcome::iteration_diverged;
      if (judgement == Judgement::slow) return Outcome::iteration_stalled;
      if (judgement == Judgement::converged && anderson_.stretches()) return Outcome::success;
      // What is left was judged by the rate of accelerated iterates: the last move is one of them, too.
      anderson_.mix(increment_.w, residual(), image_,
                    [&](const auto& a, const auto& b) { return this->inner(Y, a, b); });
      increment_.place(Y);
      if (judgement == Judgement::converged) return Outcome::success;
    }
  }

  /// Y = b again.
  void undo(Plain& Y) {
    increment_.w.setZero();
    increment_.place(Y);
  }

  [[nodiscard]] static const char* solver_name() { return "fixed-point iteration"; }
  [[nodiscard]] const Unknown& increment() const { return increment_.w; }

 private:
  /// f = g(w) − w
  [[nodiscard]] Unknown& residual() { return increment_.delta; }

  /// g = γ_f M⁻¹Ψ, f = g − w
  void map(const Rhs& rhs, const Gamma<Scalar>& gamma, const Rate& psi) {
    for_each_part(
        [&](Index at, const auto& block, const auto& mass) {
          auto image = part(image_, at, block);
          image = flat(block);
          if constexpr (std::remove_cvref_t<decltype(mass)>::is_matrix)
            if (all_finite(block.data(), block.size())) mass.solve(image);
          const auto factor = mass.h_over_mass(gamma.force);
          for (Index i = 0; i < image.size(); ++i) image[i] *= factor(i);
        },
        Rate::blocks(psi), rhs.masses());
    residual() = image_ - increment_.w;
  }
  /// Blocks may have different units: each is measured by a size of its own that stands still during a solve, so that the
  /// recorded increments fall as the iteration contracts. r/γ is there because its rounding reaches f through Ψ.
  void weigh(const Plain& Y) {
    std::size_t k = 0;
    for_each_solved<S>(
        [&](Index at, const auto& y) {
          double size = std::max({largest(y), largest(part(increment_.base, at, y)), largest(part(residual(), at, y))});
          if (k == 0) size = std::max(size, increment_.drift_size(Y, 1));
          // The inverse of a subnormal number would be infinite.
          size = size > 0 ? at_least_normal<Scalar>(size) : 1;
          int exponent = 0;
          std::frexp(size, &exponent);
          sizes_[k] = size;
          scale_[k++] = std::ldexp(Scalar{1}, -exponent);
        },
        Y);
  }
  /// ⟨a, b⟩ with each block in units of its size.
  [[nodiscard]] Scalar inner(const Plain& Y, const auto& a, const auto& b) const {
    if constexpr (Rhs::blocks == 1) return (scale_[0] * a).dot(scale_[0] * b);
    Scalar sum{0};
    std::size_t k = 0;
    for_each_solved<S>(
        [&](Index at, const auto& y) {
          sum += (scale_[k] * part(a, at, y)).dot(scale_[k] * part(b, at, y));
          ++k;
        },
        Y);
    return sum;
  }
  /// The size of f, as that of a correction: relative to Y, or in the weighted RMS norm.
  [[nodiscard]] Correction size(const Plain& Y, const SolveTolerance<Plain>& allowed) {
    Correction worst;
    std::size_t k = 0;
    for_each_solved<S>(
        [&](Index at, const auto& y) {
          const double of = largest(part(residual(), at, y));
          worst.absolute = std::max(worst.absolute, of);
          worst.beside_all = std::max(worst.beside_all, of / sizes_[k++]);
          if (of > 0) worst.relative = std::max(worst.relative, relative_size<Scalar>(of, largest(y)));
        },
        Y);
    if (allowed.target > 0) worst.relative = rms_of_unknowns<S>(residual(), Y, allowed).first;
    else if (options_.rtol > 0) worst.relative = rms_of_unknowns<S>(residual(), Y, increment_.base, options_);
    return worst;
  }

  FixedPointOptions options_;
  Increment<S> increment_;
  Unknown image_;  // g(w)
  Anderson<Scalar, static_unknowns<S>> anderson_;
  std::array<Scalar, Rhs::blocks> scale_{};
  std::array<double, Rhs::blocks> sizes_{};
};

template <State S, class Rhs, bool position>
struct ResolventFor<S, Rhs, FixedPoint, position> {
  using type = FixedPointResolvent<S, Rhs>;
};

/// Verlet's solve for v where the force has no Jacobian. v alone is mild: γ‖M⁻¹∂Ψ/∂v‖ < 1 wherever the explicit half is stable, so
/// that it iterates; where that fails, Newton takes this solve and the next ones, 8, then 16 … 1024, with a dense matrix by differences,
/// unless there are more unknowns than these are for.
template <State S, class Rhs>
class VelocityResolvent : public ResolventDefaults {
  using Dense = NewtonResolvent<S, Rhs, void, false>;
  using Iterated = FixedPointResolvent<S, Rhs>;

 public:
  using Scalar = ScalarOf<S>;
  using Plain = PlainState<S>;
  using Rate = RateOf<S>;

  VelocityResolvent(const Plain& y, Rhs& rhs, const Newton<>& solver)
      : solver_{solver}, iterated_{y, rhs, iteration(y, solver.options)} {}
  void resize(const Plain& y, Rhs& rhs) {
    iterated_ = Iterated{y, rhs, iteration(y, solver_.options)};
    forget();
  }
  void forget() {
    dense_.reset();
    rests_ = 0, rest_ = 8, is_dense_ = false;
  }
  void reset() { forget(); }
  void forget_unsaved() { forget(); }
  [[nodiscard]] Outcome resolve(Rhs& rhs, const Gamma<Scalar>& gamma, Scalar t, Plain& Y, const Plain& guess, Rate& psi,
                                SolveRecord& record, bool knows_psi = false, SolveTolerance<Plain> allowed = {}) {
    is_dense_ = rests_ > 0;
    if (!is_dense_) {
      const Outcome found = iterated_.resolve(rhs, gamma, t, Y, guess, psi, record, knows_psi, allowed);
      if (!failed(found) || unknowns<S>(Y) > dense_difference_limit) return found;
      iterated_.undo(Y);
      knows_psi = false;
      if (!dense_) dense_.emplace(Y, rhs, solver_);
      is_dense_ = true;
      rests_ = rest_, rest_ = std::min(2 * rest_, 1024);
    }
    --rests_;
    return dense_->resolve(rhs, gamma, t, Y, guess, psi, record, knows_psi, allowed);
  }
  [[nodiscard]] Outcome filter(Rhs& rhs, Plain& e) {
    return is_dense_ ? dense_->filter(rhs, e) : Iterated::filter(rhs, e);
  }
  [[nodiscard]] bool keeps_factors() const { return is_dense_; }
  [[nodiscard]] const char* solver_name() const { return is_dense_ ? dense_->solver_name() : Iterated::solver_name(); }
  [[nodiscard]] const auto& increment() const { return is_dense_ ? dense_->increment() : iterated_.increment(); }

 private:
  [[nodiscard]] static FixedPoint iteration(const Plain& y, const NewtonOptions& o) {
    const int most = unknowns<S>(y) <= dense_difference_limit ? 25 : 0;
    return fixed_point({o.rtol, o.atol, o.max_iterations > 0 ? o.max_iterations : most});
  }
  Newton<> solver_;
  Iterated iterated_;
  std::optional<Dense> dense_;
  int rests_ = 0, rest_ = 8;  // solves that are Newton's yet; after the next failure
  bool is_dense_ = false;     // the last one was
};

template <State S, class Rhs>
  requires(static_unknowns<S> == Eigen::Dynamic && !Rhs::Traits::has_velocity_jacobian && !Rhs::Traits::has_pattern &&
           !solves_particlewise<S, Rhs>)
struct ResolventFor<S, Rhs, Newton<>, false> {
  using type = VelocityResolvent<S, Rhs>;
};

}}  // namespace phistep::PHISTEP_ABI

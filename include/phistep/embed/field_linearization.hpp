/// @file
/// Implicit solves of fields, whose numbers the library doesn't see: by Newton's method with a matrix in the user's solver
/// (FieldSolver; for other states step/solve/linearization.hpp), or by fixed-point iteration (step/solve/fixed_point_resolvent.hpp).
#pragma once

#include <algorithm>
#include <cmath>
#include <concepts>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <tuple>
#include <utility>
#include <vector>

#include "phistep/base/facts/implicit_solver.hpp"
#include "phistep/base/numbers/arithmetic.hpp"
#include "phistep/base/outcome/outcome.hpp"
#include "phistep/base/outcome/statistics.hpp"
#include "phistep/base/outcome/step_report.hpp"
#include "phistep/base/state/blocks.hpp"
#include "phistep/base/state/ranks.hpp"
#include "phistep/base/state/reductions.hpp"
#include "phistep/base/state/unknowns.hpp"
#include "phistep/step/equation/explicit_update.hpp"
#include "phistep/step/mass/bound_masses.hpp"
#include "phistep/step/solve/fixed_point_resolvent.hpp"
#include "phistep/step/solve/increment.hpp"
#include "phistep/step/solve/linearization.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

// What solves the linear equations of a field: a class of the user's, or of an adapter. J never leaves it, nor does
// W = M − γ_f C − γ_f γ_d K, with C = ∂Ψ/∂v and K = ∂Ψ/∂r (of a first-order field W = M − γ_f J). All its functions are
// collective.

/// @tparam S  a field, or a motion whose r and v are fields
template <class Solver, class S>
concept FieldSolver = FieldState<S> && std::copyable<Solver> && Solver::is_field_solver &&
    requires(Solver& one, const Solver& done, ScalarOf<S> t, const Gamma<ScalarOf<S>>& gamma,
             typename UnknownsOf<S>::type& x, const typename UnknownsOf<S>::type& y) {
  requires requires {
    { one.linearize(t, y) } -> std::same_as<Outcome>;
  } ||  // J at (t, y)
      (Blocks<S>::drifts && requires {
        { one.linearize(t, y, y) } -> std::same_as<Outcome>;
      });                                             // K and C at (t, r, v)
  { one.factorize(gamma) } -> std::same_as<Outcome>;  // W, and what its solves need
  {
    one.solve(x, double{})
    } -> std::same_as<Outcome>;  // x ← W⁻¹ x to that relative residual, 0: its own choice; on failure x stays
  { done.iterations() } -> std::convertible_to<std::int64_t>;  // of the last solve
  { done.name() } -> std::convertible_to<const char*>;
};

/// The matrix W in the user's solver: it is reused while it serves, and its work is counted. Where it fails on one rank, that rank's
/// share of the next reduction that the step needs anyway is NaN, and so all ranks learn of it.
template <FieldState S, class Rhs, class Solver, bool position, bool stages, bool shifted, bool iterated>
class Linearization<S, Rhs, Solver, position, stages, shifted, iterated> : public KeptFactors<ScalarOf<S>> {
  using Kept = KeptFactors<ScalarOf<S>>;
  using Kept::has_jacobian_, Kept::has_factors_;
  static_assert(
      FieldSolver<Solver, S>,
      "phistep: the implicit steps of a field need a linear solver of its kind: newton(PetscSolver{...}), or a "
      "class as phistep/embed/field_linearization.hpp describes it");

 public:
  using Scalar = ScalarOf<S>;
  using Plain = PlainState<S>;
  using Rate = RateOf<S>;
  using Unknown = typename UnknownsOf<S>::type;
  static constexpr bool matrix_free = false, analytic = false, patterned = false, takes_differences = false;
  static constexpr bool is_promised = Rhs::Traits::is_affine;
  static constexpr bool follows_tolerance = true, is_iterative = true, solves_in_registers = false;
  static constexpr bool has_K = Rhs::drifts && position, has_C = Rhs::couples_unknowns;

  void take(const auto& solver) { solver_.emplace(solver.linear); }
  void resize(const Plain& /*y*/, Rhs& rhs) {
    held_ = rhs.held();
    mass_ = static_cast<double>(std::get<0>(rhs.masses())[0]);
    drop();
  }
  void begin(const Gamma<Scalar>& gamma, Scalar within) { Kept::begin(gamma, within, has_K && !has_C); }
  using Kept::drop;
  void forget_solves() { drop(); }
  void forget() { drop(); }
  void forget_pattern() { drop(); }

  [[nodiscard]] Outcome refresh(Rhs& rhs, const Gamma<Scalar>& gamma, Scalar t, const Plain& Y, const Rate& psi,
                                const NewtonOptions& options, const SolveTolerance<Plain>& allowed) {
    if (!has_jacobian_)
      if (const Outcome bad = linearize(rhs, gamma, t, Y, psi, options, allowed); failed(bad)) return bad;
    ++rhs.statistics().factorizations;
    run([&] { return solver_->factorize(gamma); });
    is_agreed_ = false;
    this->set_factors(true, gamma);
    return Outcome::success;
  }
  [[nodiscard]] Outcome linearize(Rhs& rhs, const Gamma<Scalar>& /*gamma*/, Scalar t, const Plain& Y,
                                  const Rate& /*psi*/, const NewtonOptions& /*options*/,
                                  const SolveTolerance<Plain>& /*allowed*/) {
    ++rhs.statistics().jacobians;
    drop();
    run([&] {
      return std::apply([&](const auto&... block) { return solver_->linearize(t, block...); }, Blocks<S>::all(Y));
    });
    const Outcome outcome = agree(Y);
    has_jacobian_ = !failed(outcome);
    return outcome;
  }
  /// x ← W⁻¹ x. @param allowed  of a controlled run: rules where the options don't
  [[nodiscard]] Outcome solve(Unknown& x, const NewtonOptions& options, Statistics& statistics,
                              const SolveTolerance<Plain>& allowed = {}) {
    if (const Outcome bad = solve_unagreed(x, options, statistics, allowed); failed(bad)) return bad;
    return agree(x);
  }
  /// As solve(), but ranks learn of a failure only by the next reduction or at the step's end: x is NaN on the rank where it failed.
  /// @param square  Σ (x_i weight_i)² over all ranks, which is finite; negative: not known
  [[nodiscard]] Outcome solve_unagreed(Unknown& x, const NewtonOptions& options, Statistics& statistics,
                                       const SolveTolerance<Plain>& allowed, double square = -1) {
    ++statistics.solves;
    double rtol = options.linear_rtol;
    const bool is_sized = sizes(options, allowed);
    if (!is_sized && (stages || !is_agreed_)) {
      if (!Unknown::Ops::is_finite_here(x.handle())) held_->note(Outcome::non_finite_state);
      if (const Outcome bad = agree(x); failed(bad)) return bad;
    }
    if (is_sized) {
      if (square < 0) {
        square = square_here(x, allowed);
        Unknown::Ops::total(x.handle(), std::span<double>{&square, 1});
        if (!std::isfinite(square))
          if (const Outcome bad = agree(x); failed(bad)) return bad;
        if (std::isnan(square)) return Outcome::non_finite_state;
      } else if (!is_agreed_) {
        if (const Outcome bad = agree(x); failed(bad)) return bad;
      }
      // A residual of that size in the run's weights, where x is about W⁻¹'s largest, M⁻¹, times as large.
      const double size = std::sqrt(square / static_cast<double>(x.size())) / mass_;
      const double share = inexact_share * allowed.target;
      rtol = std::clamp(size > 0 ? share / size : 0.5, 1e-12, 0.5);
    }
    run([&] { return solver_->solve(x, rtol); });
    if (failed(held_->found())) x.poison();
    statistics.linear_iterations += solver_->iterations();
    this->scale(x);
    is_agreed_ = true;  // of the factors
    return Outcome::success;
  }
  /// Whether the tolerance of a solve follows the size of its right-hand side.
  [[nodiscard]] static bool sizes(const NewtonOptions& options, const SolveTolerance<Plain>& allowed) {
    return allowed.target > 0 && (stages || options.linear_rtol == 0);
  }
  /// This rank's share of the square of that size: NaN where this rank knows of a failure.
  [[nodiscard]] double square_here(const Unknown& x, const SolveTolerance<Plain>& allowed) const {
    if (failed(held_->found())) return std::numeric_limits<double>::quiet_NaN();
    return Unknown::Ops::square(x.handle(), std::get<0>(Blocks<S>::solved(*allowed.weight)).handle());
  }
  /// The square of that size over all ranks; −1 where no tolerance follows it, or where it isn't finite. A reduction at most.
  [[nodiscard]] double square_of(const Unknown& x, const NewtonOptions& options,
                                 const SolveTolerance<Plain>& allowed) const {
    if (!sizes(options, allowed)) return -1;
    double square = square_here(x, allowed);
    Unknown::Ops::total(x.handle(), std::span<double>{&square, 1});
    return std::isfinite(square) ? square : -1;
  }
  /// One outcome for all ranks from each rank's own; collective.
  [[nodiscard]] Outcome agree(const auto& ranks) {
    const Outcome all = agreed(ranks, held_->found());
    held_->told();
    is_agreed_ = true;
    if (failed(all)) has_factors_ = false;
    return all;
  }
  template <class X>
  void add_position_product(Scalar, const X&, auto&) const {
    static_assert(
        !sizeof(X),
        "phistep: Rosenbrock schemes multiply with dPsi/dr, which a field's solver doesn't: take trapezoidal, "
        "tr_bdf2 or velocity_verlet for a motion of fields");
  }
  [[nodiscard]] static bool differences_reached_too_far(const Plain&, const Unknown&) { return false; }
  [[nodiscard]] static std::int64_t singular_particle() { return -1; }
  [[nodiscard]] static double drift_share() { return 0; }
  [[nodiscard]] static double magnitude() { return 0; }
  [[nodiscard]] const char* name() const { return solver_->name(); }

 private:
  /// Calls f, a function of the user's solver, on this rank; notes the outcome, and holds what it throws.
  void run(auto&& f) {
    held_->run([&] { held_->note(f()); }, [] {});
  }

  std::optional<Solver> solver_;
  std::shared_ptr<HeldException> held_;  // that of the right-hand side
  double mass_ = 1;
  bool is_agreed_ = true;  // all ranks know what the last factorization has come to
};

template <FieldState S, class Rhs>
class FixedPointResolvent<S, Rhs> : public ResolventDefaults {
 public:
  using Scalar = ScalarOf<S>;
  using Plain = PlainState<S>;
  using Rate = RateOf<S>;
  using Unknown = typename Increment<S>::Unknown;
  static constexpr bool checks_state = true;

  FixedPointResolvent(const Plain& y, const Rhs& rhs, const FixedPoint& solver) : options_{solver.options} {
    options_.depth = 0;
    resize(y, rhs);
  }
  void resize(const Plain& y, const Rhs&) {
    increment_.resize(y);
    forget();
  }
  void forget() { expected_ = 1; }
  void reset() { forget(); }
  void forget_unsaved() { forget(); }  // expected_ isn't saved, but changes the last bits of results

  /// Solves for Y. Takes b in Y, the first iterate in the solved blocks of `guess`; leaves Y, and w = Y − b.
  [[nodiscard]] Outcome resolve(Rhs& rhs, const Gamma<Scalar>& gamma, Scalar t, Plain& Y, const Plain& guess, Rate& psi,
                                SolveRecord& record, bool knows_psi = false, SolveTolerance<Plain> allowed = {}) {
    if (options_.rtol > 0) allowed.target = 0;
    is_rms_ = allowed.target > 0 || options_.rtol > 0;
    increment_.begin(Y, gamma.drift);
    is_good_ = is_finite_here(Y);
    if (is_good_) increment_.start(Y, guess);
    else copy_blocks<S>(Y, guess);  // not finite here: Ψ, a call of all ranks together, is called at the guess
    FixedPointTest test(options_, static_cast<double>(std::numeric_limits<Scalar>::epsilon()), allowed.target);
    int done = 0;
    for (int ahead = expected_;; ahead = 1) {
      parts_.clear();
      for (int k = 0; k < ahead; ++k) {
        if (done + k > 0 || !knows_psi) rhs.evaluate_into(t, Y, psi);
        iterate(rhs, gamma, Y, psi, allowed);
      }
      if (is_rms_) Unknown::Ops::total(increment_.base.handle(), parts_);
      else Unknown::Ops::greatest(increment_.base.handle(), parts_);
      for (int k = 0; k < ahead; ++k) {
        const Correction size = this->size(static_cast<std::size_t>(k), done == 0);
        ++done;
        if (!std::isfinite(size.absolute)) {
          forget();
          return first_non_finite(Rate::blocks(psi)) ? Outcome::non_finite_force : Outcome::non_finite_state;
        }
        record.add(size.beside_all);
        ++rhs.statistics().iterations;
        const Judgement judgement = test.judge(done, size);
        if (judgement == Judgement::go_on) continue;
        expected_ = judgement == Judgement::converged ? done : 1;
        if (judgement == Judgement::growing) return Outcome::iteration_diverged;
        if (judgement == Judgement::slow) return Outcome::iteration_stalled;
        return Outcome::success;
      }
    }
  }

  [[nodiscard]] static const char* solver_name() { return "fixed-point iteration"; }
  [[nodiscard]] const Unknown& increment() const { return increment_.w; }

 private:
  static constexpr std::size_t maxima = 4;  // in each iteration: of |f|, |Y|, |b|, |r/γ|

  [[nodiscard]] static bool is_finite_here(const Plain& y) {
    bool all = true;
    for_each_block([&all](auto, const auto& x) { all = all && Unknown::Ops::is_finite_here(x.handle()); },
                   Blocks<S>::all(y));
    return all;
  }
  /// w ← γ_f M⁻¹Ψ, and what this rank knows of it. Where it isn't finite the iterate stays: the other ranks go on, too.
  void iterate(const Rhs& rhs, const Gamma<Scalar>& gamma, Plain& Y, const Rate& psi,
               const SolveTolerance<Plain>& allowed) {
    const auto& rate = std::get<0>(Rate::blocks(psi));
    auto& f = increment_.delta;
    f = field_factor(std::get<0>(rhs.masses()), gamma.force) * rate - increment_.w;
    is_good_ = is_good_ && Unknown::Ops::is_finite_here(f.handle());
    if (is_good_) {
      increment_.move(Y);
      is_good_ = is_finite_here(Y);
      if (!is_good_) increment_.undo(Y);
    }
    const auto bad = [this](double x) { return is_good_ ? x : std::numeric_limits<double>::infinity(); };
    const auto& end = std::get<0>(Blocks<S>::solved(std::as_const(Y)));
    if (allowed.target > 0) {
      const auto& weight = std::get<0>(Blocks<S>::solved(*allowed.weight));
      parts_.push_back(bad(Unknown::Ops::square(f.handle(), weight.handle())));
    } else if (is_rms_) {
      const double rtol = solve_rtol(options_.rtol), atol = rtol * options_.atol / options_.rtol;
      parts_.push_back(bad(Unknown::Ops::square(f.handle(), end.handle(), increment_.base.handle(),
                                                static_cast<Scalar>(atol), static_cast<Scalar>(rtol))));
    } else {
      double drifted = 0;
      if constexpr (Blocks<S>::drifts)
        if (gamma.drift != 0)
          drifted = Unknown::Ops::largest_here(position_of<S>(std::as_const(Y)).handle()) /
                    std::abs(static_cast<double>(gamma.drift));
      parts_.push_back(bad(Unknown::Ops::largest_here(f.handle())));
      parts_.push_back(Unknown::Ops::largest_here(end.handle()));
      parts_.push_back(Unknown::Ops::largest_here(increment_.base.handle()));
      parts_.push_back(drifted);
    }
  }
  /// The size of the k-th iteration of the batch.
  [[nodiscard]] Correction size(std::size_t k, bool is_first) {
    if (is_rms_) {
      const double n = std::max(1.0, static_cast<double>(increment_.w.size()));
      const double norm = std::sqrt(parts_[k] / n);
      return {norm, norm, norm};
    }
    const double* const all = parts_.data() + maxima * k;
    // All corrections of a solve are divided by the same size, so that their ratios show the contraction.
    if (is_first) {
      const double largest = std::max({all[0], all[1], all[2], all[3]});
      beside_ = largest > 0 ? at_least_normal<Scalar>(largest) : 1;
    }
    return {all[0] > 0 ? relative_size<Scalar>(all[0], all[1]) : 0, all[0] / beside_, all[0]};
  }

  FixedPointOptions options_;
  Increment<S> increment_;
  std::vector<double> parts_;
  double beside_ = 1;
  int expected_ = 1;  // iterations
  bool is_rms_ = false, is_good_ = true;
};

}}  // namespace phistep::PHISTEP_ABI

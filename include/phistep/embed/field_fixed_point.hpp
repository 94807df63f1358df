/// @file
/// Fixed-point iteration of a field (fixed_point_resolvent.hpp), as few questions to all ranks as can be: as many iterations as
/// the last solve took are done with what each rank knows by itself, and one reduction then judges all of them. So a step
/// whose solve takes as many as the one before waits once. Plain iteration: Anderson's acceleration would ask for inner
/// products in each.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <tuple>
#include <utility>
#include <vector>

#include "phistep/base/numbers/arithmetic.hpp"
#include "phistep/base/outcome/outcome.hpp"
#include "phistep/base/outcome/step_report.hpp"
#include "phistep/base/state/blocks.hpp"
#include "phistep/base/state/reductions.hpp"
#include "phistep/base/version.hpp"
#include "phistep/embed/field_linearisation.hpp"
#include "phistep/step/mass/bound_masses.hpp"
#include "phistep/step/solve/fixed_point_resolvent.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

template <FieldState S, class Rhs>
class FixedPointResolvent<S, Rhs> {
 public:
  using Scalar = ScalarOf<S>;
  using Plain = PlainState<S>;
  using Rate = RateOf<S>;
  using Unknown = typename Increment<S>::Unknown;
  /// Success says that Y is finite, and so is b.
  static constexpr bool looks_at_all = true;

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
  void forget_unsaved() { forget(); }  // how many iterations are done at once shows in the last bits

  /// In: Y = b; `guess` is where the iteration starts (its solved blocks count). Out: Y, and w = Y − b.
  [[nodiscard]] Outcome resolve(Rhs& rhs, const Gamma<Scalar>& gamma, Scalar t, Plain& Y, const Plain& guess, Rate& psi,
                                SolveRecord& record, bool psi_known = false, SolveTolerance<Plain> allowed = {}) {
    if (options_.rtol > 0) allowed.target = 0;
    is_rms_ = allowed.target > 0 || options_.rtol > 0;
    increment_.begin(Y, gamma.drift);
    is_good_ = is_finite_here(Y);
    if (is_good_) increment_.start(Y, guess);
    else copy_blocks<S>(Y, guess);  // Ψ is asked where it may exist: other ranks ask theirs
    FixedPointTest test(options_, static_cast<double>(std::numeric_limits<Scalar>::epsilon()), allowed.target);
    int done = 0;
    for (int ahead = expected_;; ahead = 1) {
      told_.clear();
      for (int k = 0; k < ahead; ++k) {
        if (done + k > 0 || !psi_known) rhs.evaluate_into(t, Y, psi);
        iterate(rhs, gamma, Y, psi, allowed);
      }
      if (is_rms_) Unknown::Ops::total(increment_.base.handle(), told_);
      else Unknown::Ops::greatest(increment_.base.handle(), told_);
      for (int k = 0; k < ahead; ++k) {
        const Correction size = this->size(static_cast<std::size_t>(k), done == 0);
        ++done;
        if (!std::isfinite(size.absolute)) {
          forget();
          return first_non_finite(Rate::blocks(psi)) ? Outcome::non_finite_force : Outcome::non_finite_state;
        }
        record.add(size.resolution);
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

  [[nodiscard]] static Outcome filter(const Rhs&, const Plain&) { return Outcome::success; }
  [[nodiscard]] static bool keeps_factors() { return false; }
  [[nodiscard]] static const char* solver_name() { return "fixed-point iteration"; }
  [[nodiscard]] const Unknown& increment() const { return increment_.w; }

 private:
  static constexpr std::size_t maxima = 4;  // of f, Y, b, r/γ

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
      told_.push_back(bad(Unknown::Ops::square(f.handle(), weight.handle())));
    } else if (is_rms_) {
      const double rtol = solve_rtol(options_.rtol), atol = rtol * options_.atol / options_.rtol;
      told_.push_back(bad(Unknown::Ops::square(f.handle(), end.handle(), increment_.base.handle(),
                                               static_cast<Scalar>(atol), static_cast<Scalar>(rtol))));
    } else {
      double drifted = 0;
      if constexpr (Blocks<S>::drifts)
        if (gamma.drift != 0)
          drifted = Unknown::Ops::largest_here(position_of<S>(std::as_const(Y)).handle()) /
                    std::abs(static_cast<double>(gamma.drift));
      told_.push_back(bad(Unknown::Ops::largest_here(f.handle())));
      told_.push_back(Unknown::Ops::largest_here(end.handle()));
      told_.push_back(Unknown::Ops::largest_here(increment_.base.handle()));
      told_.push_back(drifted);
    }
  }
  /// Of the k-th iteration told of.
  [[nodiscard]] Correction size(std::size_t k, bool is_first) {
    if (is_rms_) {
      const double n = std::max(1.0, static_cast<double>(increment_.w.size()));
      const double norm = std::sqrt(told_[k] / n);
      return {norm, norm, norm};
    }
    const double* const all = told_.data() + maxima * k;
    // One size stands still during a solve, so that the iteration's own contraction shows.
    if (is_first) {
      const double largest = std::max({all[0], all[1], all[2], all[3]});
      beside_ = largest > 0 ? at_least_normal<Scalar>(largest) : 1;
    }
    return {all[0] > 0 ? relative_size<Scalar>(all[0], all[1]) : 0, all[0] / beside_, all[0]};
  }

  FixedPointOptions options_;
  Increment<S> increment_;
  std::vector<double> told_;
  double beside_ = 1;
  int expected_ = 1;  // iterations
  bool is_rms_ = false, is_good_ = true;
};

}}  // namespace phistep::PHISTEP_ABI

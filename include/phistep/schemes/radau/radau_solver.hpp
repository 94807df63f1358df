/// @file
/// The equations of a Radau IIA step, (1) of radau.hpp, solved: its Jacobian and matrices, kept while they serve; the simplified
/// Newton iteration of radau_stages.hpp, to a tolerance or to rounding. The kernel chooses how the matrices are kept
/// (schemes/radau/shifted_stages.hpp).
#pragma once

#include <Eigen/Core>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <tuple>
#include <type_traits>
#include <utility>

#include "phistep/base/numbers/arithmetic.hpp"
#include "phistep/base/outcome/outcome.hpp"
#include "phistep/base/state/blocks.hpp"
#include "phistep/base/state/reductions.hpp"
#include "phistep/base/state/unknowns.hpp"
#include "phistep/schemes/radau/radau_control.hpp"
#include "phistep/schemes/radau/radau_stages.hpp"
#include "phistep/schemes/radau/radau_tableau.hpp"
#include "phistep/schemes/radau/shifted_stages.hpp"
#include "phistep/step/transaction/trace.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

template <State S>
class RadauSolver {
 public:
  using Scalar = ScalarOf<S>;
  using Plain = PlainState<S>;
  static constexpr bool drifts = Blocks<S>::drifts;
  using Work = RadauStages<Scalar, static_unknowns<S>>;
  using Numbers = typename Work::template Each<Scalar>;
  static constexpr double round_off = static_cast<double>(std::numeric_limits<Scalar>::epsilon()) / 2;

  void resize(const Plain& y) {
    n_ = static_cast<std::size_t>(unknowns<S>(y));
    Work::make(n_, weight_, change_);
    work_.resize(n_);
    forget();
  }
  [[nodiscard]] std::size_t n() const { return n_; }
  /// The unknowns themselves: to be set before an iteration, to be read after it.
  [[nodiscard]] Work& work() { return work_; }

  /// The next step starts elsewhere: J may not serve there.
  void begin() { is_fresh_ = keeps_ = false; }
  /// The next step starts where this one ended. @param keeps  J may serve there, too
  void accept(bool keeps) {
    is_fresh_ = false;
    keeps_ = keeps;
  }
  void forget() {
    begin();
    factored_ = 0;
  }
  /// J is another step's. It isn't used again.
  [[nodiscard]] bool drop_old() { return !is_fresh_ && std::exchange(keeps_, false); }

  /// J and the matrices of the stage equations.
  template <int s, class Eq>
  [[nodiscard]] Outcome prepare(Eq& eq, const auto& masses) {
    constexpr bool affine = Eq::Rhs::Traits::is_affine;
    auto& matrices = eq.stages();
    using Stages = std::remove_cvref_t<decltype(matrices)>;
    if (!matrices.has_jacobian() || (!affine && !is_fresh_ && !keeps_)) {
      factored_ = 0;
      if constexpr (!Stages::analytic) {
        if (!eq.knows_start) eq.evaluate(eq.t, eq.y);
        if (first_non_finite(RateOf<S>::blocks(std::as_const(eq.psi)))) {
          copy_blocks<S>(eq.next, eq.y);  // kept for the failure message
          return Outcome::non_finite_force;
        }
      }
      if (const Outcome outcome = matrices.tangent(eq.rhs(), eq.t, eq.dt, eq.y, eq.psi, eq.allowed()); failed(outcome))
        return outcome;
      is_fresh_ = true;
    }
    if (factored_ == s && factored_dt_ == eq.dt) return Outcome::success;
    const Outcome outcome = matrices.factorize(eq.rhs(), work_.template shift<s>(eq.dt, masses), masses);
    factored_ = failed(outcome) ? 0 : s;
    factored_dt_ = eq.dt;
    if (failed(outcome) || !is_fresh_) return outcome;
    const Outcome checked = matrices.check(eq.rhs(), radau_constants<Scalar, s>.mu.re[0] * eq.dt, eq.t, eq.y, eq.psi);
    if (failed(checked)) {
      forget();
      if (checked == Outcome::non_finite_force) copy_blocks<S>(eq.next, eq.y);  // kept for the failure message
    }
    return checked;
  }

  // The parts of a state, for for_each_number.
  [[nodiscard]] static auto solved(auto& y) { return Blocks<S>::solved(y); }
  [[nodiscard]] static auto positions(auto& y) { return std::tie(position_of<S>(y)); }
  [[nodiscard]] static auto velocities(auto& y) { return std::tie(velocity_of<S>(y)); }

  /// Iterates while `test` says so, with the weights given.
  template <int s>
  [[nodiscard]] Judgement iterate(auto& eq, const auto& masses, const Trace<Plain>& trace, RadauIteration& test) {
    for_each_number([&](std::size_t i, Scalar w) { weight_[i] = w; }, solved(trace.weight));
    work_.template to_stages<s>();
    Judgement judgement = Judgement::go_on;
    // What has no weight yet is left out of the judgement, and may be rounding that never settles: it has some more rounds.
    for (int rounds = trace.has_unsized ? 4 : 0; judgement == Judgement::go_on; --rounds) {
      this->template evaluate<s>(eq);
      const double size = this->template correction<s>(eq, masses);
      judgement = rounds > 0 && becomes(trace.weight) ? test.begin_again() : test.judge(size);
    }
    return judgement;
  }
  /// Whether something without a weight comes to be.
  [[nodiscard]] bool becomes(const Plain& weight) const {
    bool any = false;
    for_each_number([&](std::size_t i, Scalar w) { any = any || (w == 0 && work_.z(i)[0] != 0); }, solved(weight));
    return any;
  }
  /// Iterates until only rounding is left, block by block in units of the largest component.
  template <int s>
  [[nodiscard]] Judgement iterate_to_rounding(auto& eq, const auto& masses) {
    RoundingIteration test{round_off};
    work_.template to_stages<s>();
    Judgement judgement = Judgement::go_on;
    for (bool first = true; judgement == Judgement::go_on; first = false) {
      bool has_scale = true;
      this->template evaluate<s>(eq);
      for_each_solved<S>(
          [&](Index at, const auto& y) {
            Scalar largest{0};
            for (Index i = 0; i < y.size(); ++i) {
              largest = std::max(largest, std::abs(y.data()[i]));
              for (std::size_t j = 0; j < s; ++j)
                largest = std::max(largest, std::abs(work_.z(static_cast<std::size_t>(at + i))[j]));
            }
            for (Index i = 0; i < y.size(); ++i)
              weight_[static_cast<std::size_t>(at + i)] =
                  largest > 0 ? 1 / at_least_normal<Scalar>(largest) : Scalar{1};
            has_scale = has_scale && largest > 0;
          },
          eq.y);
      const double size = this->template correction<s>(eq, masses);
      // From rest, the first correction is what the next is measured by: its own size would be a number with a unit.
      if (has_scale || !first) judgement = test.judge(size);
      else if (!std::isfinite(size)) judgement = Judgement::slow;
      if (judgement != Judgement::converged && test.has_stopped() && size <= magnified<s> * this->template noise<s>(eq))
        return Judgement::converged;
    }
    return judgement;
  }
  /// By how much T and T⁻¹ magnify rounding, at most.
  template <int s>
  static constexpr double magnified = s == 3   ? 64
                                      : s == 5 ? 512
                                               : 4096;
  /// What rounding of y alone makes of a correction, in the same units: in balance, where large terms of Ψ cancel, all of it.
  template <int s>
  [[nodiscard]] double noise(auto& eq) {
    to_stage(eq, s - 1);
    eq.evaluate(eq.t + eq.dt, eq.next);
    for_each_number([&](std::size_t i, Scalar psi) { change_[i] = psi; }, RateOf<S>::blocks(eq.psi));
    for_each_number(
        [flip = Scalar{1}](auto, Scalar& x) mutable { x *= 1 + (flip = -flip) * 2 * static_cast<Scalar>(round_off); },
        Blocks<S>::all(eq.next));
    eq.evaluate(eq.t + eq.dt, eq.next);
    for_each_number([&](std::size_t i, Scalar psi) { change_[i] = psi - change_[i]; }, RateOf<S>::blocks(eq.psi));
    eq.stages().solve_real(change_);
    double sum = 0;
    for (std::size_t i = 0; i < n_; ++i) sum += std::pow(static_cast<double>(weight_[i] * change_[i]), 2);
    return std::sqrt(sum / static_cast<double>(n_));
  }
  /// Which stage has made an iteration fail, for the message: its Ψ is in psi, where it isn't finite.
  template <int s>
  [[gnu::cold, gnu::noinline]] Outcome blame(auto& eq, Judgement judgement) {
    for (std::size_t j = 0; j < s; ++j) {
      bool finite = true;
      for (std::size_t i = 0; i < n_; ++i) finite = finite && std::isfinite(work_.psi(i)[j]);
      if (finite) continue;
      to_stage(eq, j);
      for_each_number([&](std::size_t i, Scalar& psi) { psi = work_.psi(i)[j]; }, RateOf<S>::blocks(eq.psi));
      return Outcome::non_finite_force;
    }
    return judgement == Judgement::growing ? Outcome::newton_diverged : Outcome::newton_stalled;
  }
  /// next = y + Z_s
  template <int s>
  void add_increment(auto& eq) {
    if constexpr (drifts)
      for_each_number([&](std::size_t i, Scalar r, Scalar v,
                          Scalar& to) { to = r + (eq.dt * v + Work::increment(work_.template drifted<s>(eq.dt, i))); },
                      positions(eq.y), velocities(eq.y), positions(eq.next));
    for_each_number([&](std::size_t i, Scalar y, Scalar& to) { to = y + work_.z(i)[s - 1]; }, solved(eq.y),
                    solved(eq.next));
  }

 private:
  /// Ψ at every stage.
  template <int s>
  void evaluate(auto& eq) {
    if constexpr (drifts) work_.template to_positions<s>(eq.dt, velocity_of<S>(eq.y));
    for (std::size_t j = 0; j < s; ++j) {
      to_stage(eq, j);
      eq.evaluate(eq.t + radau_constants<Scalar, s>.c[j] * eq.dt, eq.next);
      for_each_number([&](std::size_t i, Scalar psi) { work_.psi(i)[j] = psi; }, RateOf<S>::blocks(eq.psi));
    }
  }
  /// next = Y_j
  void to_stage(auto& eq, std::size_t j) {
    if constexpr (drifts)
      for_each_number([&](std::size_t i, Scalar y, Scalar& to) { to = y + work_.r(i)[j]; }, positions(eq.y),
                      positions(eq.next));
    for_each_number([&](std::size_t i, Scalar y, Scalar& to) { to = y + work_.z(i)[j]; }, solved(eq.y),
                    solved(eq.next));
  }
  /// ‖δ‖ of one iteration.
  template <int s>
  [[nodiscard]] double correction(auto& eq, const auto& masses) {
    ++eq.rhs().statistics().solves;
    ++eq.rhs().statistics().iterations;
    const auto sum = work_.template correct<s>(eq.stages(), masses, weight_);
    return n_ == 0 ? 0 : std::sqrt(static_cast<double>(sum) / static_cast<double>(s * n_));
  }

  Work work_;
  std::size_t n_ = 0;
  Numbers weight_{}, change_{};
  Scalar factored_dt_{0};                  // [time]
  int factored_ = 0;                       // stages of the factors at hand
  bool is_fresh_ = false, keeps_ = false;  // J: of this step's start, of an earlier one
};

}}  // namespace phistep::PHISTEP_ABI

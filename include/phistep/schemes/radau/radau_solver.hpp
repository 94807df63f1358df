/// @file
/// The equations of a Radau IIA step, (1) of radau.hpp, solved: its Jacobian and matrices, kept while they serve; the simplified
/// Newton iteration of radau_stages.hpp. The kernel chooses how the matrices are kept
/// (schemes/radau/shifted_stages.hpp).
#pragma once

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
    Work::make(n_, weight_);
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

  /// Iterates while `test` says so: a traced step with the weights of its run, another one block by block in units of the largest
  /// component.
  template <int s, class Eq>
  [[nodiscard]] Judgement iterate(Eq& eq, const auto& masses, RadauIteration& test) {
    int rounds = 4;
    if constexpr (Eq::is_traced) {
      for_each_number([&](std::size_t i, Scalar w) { weight_[i] = w; }, solved(eq.trace.weight));
      if (!eq.trace.has_unsized) rounds = 0;
    }
    work_.template to_stages<s>();
    Judgement judgement = Judgement::go_on;
    // What has no weight yet is left out of the judgement, and may be rounding that never settles: it has some more rounds.
    for (; judgement == Judgement::go_on; --rounds) {
      this->template evaluate<s>(eq);
      double share = 1;
      if constexpr (!Eq::is_traced) share = this->template weigh<s>(eq.y, eq.dt);
      const double size = this->template correction<s>(eq, masses);
      judgement = rounds > 0 && becomes() ? test.begin_again() : test.judge(size, share);
    }
    return judgement;
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
  /// Weights by the largest component of each block, 0 where all are 0. Returns how large v is beside r/h, whose rounding reaches v
  /// through Ψ.
  template <int s>
  [[nodiscard]] double weigh(const Plain& y, Scalar h) {
    double share = 1;
    for_each_solved<S>(
        [&](Index at, const auto& block) {
          Scalar largest = max_abs(block);
          for (Index i = 0; i < block.size(); ++i)
            for (std::size_t j = 0; j < s; ++j)
              largest = std::max(largest, std::abs(work_.z(static_cast<std::size_t>(at + i))[j]));
          if constexpr (drifts && solved_blocks<S> == 1)
            if (const Scalar beside = std::abs(max_abs(position_of<S>(y)) / h); beside > largest)
              share = static_cast<double>(largest / beside);
          const Scalar weight = largest > 0 ? 1 / at_least_normal<Scalar>(largest) : Scalar{0};
          std::fill_n(weight_.begin() + at, block.size(), weight);
        },
        y);
    return share;
  }
  /// Whether something without a weight comes to be.
  [[nodiscard]] bool becomes() const {
    for (std::size_t i = 0; i < n_; ++i)
      if (weight_[i] == 0 && work_.z(i)[0] != 0) return true;
    return false;
  }
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
  Numbers weight_{};
  Scalar factored_dt_{0};                  // [time]
  int factored_ = 0;                       // stages of the factors at hand
  bool is_fresh_ = false, keeps_ = false;  // J: of this step's start, of an earlier one
};

}}  // namespace phistep::PHISTEP_ABI

/// @file
/// Radau IIA methods of 3, 5 and 7 stages, orders 5, 9 and 13 (E. Hairer & G. Wanner, J. Comput. Appl. Math. 111 (1999) 93;
/// Solving ODEs II, sect. IV.5 and IV.8): for M y' = Ψ(t, y) and motion, with h = Δt,
///
///     M Z_i = h Σ_j a_ij Ψ(t + c_j h, y + Z_j),     y⁺ = y + Z_s                                                (1)
///
/// L-stable and stiffly accurate, for stiff problems at many digits. Solved by simplified Newton iterations
/// (radau_stages.hpp) from the collocation polynomial u of the step before, whose coefficients about the step's end are
/// also the dense output (order s) and y' there. The error of a step is estimated by
///
///     e = (λ₀/h M − J)⁻¹ M (y'(t) − u'(t)),                                                                     (2)
///
/// λ₀ the real eigenvalue of A⁻¹: y' by the step before, u' by this one's polynomial continued to its start. (2) is the
/// difference to an embedded formula of order s with weight 1/λ₀ on y'(t), without what the method damps (HW II, eq.
/// IV.8.19). It goes as h^{s+1}; radau_control.hpp says how that is used.
#pragma once

#include <Eigen/Core>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <stdexcept>
#include <tuple>
#include <type_traits>
#include <utility>
#include <vector>

#include "phistep/core/arithmetic.hpp"
#include "phistep/core/outcome.hpp"
#include "phistep/core/scheme_facts.hpp"
#include "phistep/core/version.hpp"
#include "phistep/schemes/radau/radau_control.hpp"
#include "phistep/schemes/radau/radau_stages.hpp"
#include "phistep/schemes/scheme_on.hpp"
#include "phistep/state/blocks.hpp"
#include "phistep/state/unknowns.hpp"

namespace phistep::inline PHISTEP_ABI {

/// Radau IIA: `radau` chooses order and step; `radau(5)` has 5 stages. Without a controller `radau` has 3.
struct Radau {
  static constexpr SchemeFacts facts = AStable{.is_l_stable = true, .energy = EnergyBalance::rest};
  [[nodiscard]] static constexpr const char* name() { return "radau"; }
  int stages = 0;  ///< 3, 5 or 7: orders 5, 9 and 13; 0: chosen

  /// @throws std::invalid_argument unless s is 3, 5 or 7
  [[nodiscard]] constexpr Radau operator()(int s) const {
    if (s != 3 && s != 5 && s != 7) throw std::invalid_argument("phistep: radau(stages) needs 3, 5 or 7 stages");
    return {s};
  }
};
/// Radau IIA for stiff problems at many digits: `radau` chooses its order, `radau(5)` has five stages.
inline constexpr Radau radau{};

template <State S>
class SchemeOn<Radau, S> : public SchemeDefaults {
 public:
  using Scalar = ScalarOf<S>;
  using Plain = PlainState<S>;
  template <class Rhs>
  static constexpr KernelNeeds needs{.stages = true, .shifted = true};

  SchemeOn(Radau scheme, const Plain& y) : scheme_{scheme}, control_{scheme.stages} { resize(y); }
  void resize(const Plain& y) {
    n_ = static_cast<std::size_t>(unknowns<S>(y));
    if constexpr (!is_fixed) {
      for (auto* x : {&powers_, &next_powers_}) x->assign(n_, {});
      for (auto* x : {&weight_, &slope_, &error_}) x->assign(n_, Scalar{0});
      if constexpr (drifts) {
        const auto n_r = static_cast<std::size_t>(position_of<S>(y).size());
        for (auto* x : {&position_powers_, &next_position_powers_}) x->assign(n_r, {});
      }
    }
    work_.resize(static_cast<Index>(n_));
    forget();
  }
  [[nodiscard]] int order() const { return 2 * (scheme_.stages == 0 ? 3 : scheme_.stages) - 1; }
  /// It judges its errors itself.
  [[nodiscard]] int error_order() const { return order(); }

  static constexpr bool traces = true, interpolates = true;
  [[nodiscard]] static bool estimates(const auto&) { return true; }
  /// Traced: solved to the tolerance, with order and step length chosen; else to rounding.
  template <class Step>
  [[nodiscard]] Outcome step(auto& kernel, Step& step) {
    if constexpr (Step::is_traced) return controlled(kernel, step);
    else return to_the_end(kernel, step);
  }
  /// The collocation polynomial of the step just accepted.
  void interpolate(Scalar x, Scalar, const Plain&, const Plain& y1, Plain& out) const {
    const auto add = [&](const auto& powers) {
      return [&](std::size_t i, Scalar y, Scalar& to) {
        Scalar sum{0};
        for (auto m = static_cast<std::size_t>(terms_); m-- > 0;) sum = (x - 1) * (sum + powers[i][m]);
        to = y + sum;
      };
    };
    if constexpr (drifts) for_each_number(add(position_powers_), positions(y1), positions(out));
    for_each_number(add(powers_), solved(y1), solved(out));
  }
  template <class Kernel>
  [[nodiscard]] Outcome to_the_end(Kernel& kernel, auto& step) {
    pending_terms_ = 0;
    is_fresh_ = keeps_ = false;
    copy_blocks<S>(step.next, step.y);  // kept for the failure message
    return with_stages((order() + 1) / 2, [&](auto s) { return this->template advance_with<s>(kernel, step); });
  }

  template <class Kernel>
  [[nodiscard]] Outcome controlled(Kernel& kernel, auto& step) {
    auto& trace = step.trace;
    copy_blocks<S>(step.next, step.y);  // as above
    const bool edited = !trace.knows_start;
    if (edited) is_fresh_ = keeps_ = false;
    if (trace.dt_before == 0) terms_ = 0;
    if (const Outcome outcome = kernel.start(step); outcome != Outcome::success) return outcome;
    control_.begin(trace.rtol, edited);
    return with_stages(control_.stages(), [&](auto s) { return this->template trace_with<s>(kernel, step); });
  }
  void accepted() {
    is_fresh_ = false;
    keeps_ = pending_keeps_;
    terms_ = pending_terms_;
    dt_ = pending_dt_;
    std::swap(powers_, next_powers_);
    if constexpr (drifts) std::swap(position_powers_, next_position_powers_);
  }
  void forget() {
    is_fresh_ = keeps_ = false;
    terms_ = pending_terms_ = factored_ = 0;
  }
  void reset() { control_.forget(); }
  using Progress = RadauControl<>;
  [[nodiscard]] const Progress& progress() const { return control_; }
  void resume(const Progress& progress) { control_ = progress; }
  void archive(auto& ar) {
    ar("control", control_, "terms", terms_, "dt", dt_);
    ar.check(terms_ >= 0 && terms_ <= 7);
    if (terms_ > 0)
      for (std::size_t i = 0; i < n_; ++i) ar(powers_[i]);
    if constexpr (std::remove_reference_t<decltype(ar)>::reading) is_fresh_ = keeps_ = false, factored_ = 0;
  }

 private:
  static constexpr int n_static = static_unknowns<S>;
  static constexpr bool drifts = Blocks<S>::drifts, is_fixed = n_static != Eigen::Dynamic;
  using Work = RadauStages<Scalar, n_static>;
  using Powers = typename Work::template Each<typename Work::Row>;
  using Numbers = typename Work::template Each<Scalar>;
  static constexpr double round_off = static_cast<double>(std::numeric_limits<Scalar>::epsilon()) / 2;

  [[nodiscard]] static auto solved(auto& y) { return Blocks<S>::solved(y); }
  [[nodiscard]] static auto positions(auto& y) { return std::tie(position_of<S>(y)); }
  [[nodiscard]] static auto velocities(auto& y) { return std::tie(velocity_of<S>(y)); }
  [[nodiscard]] static Outcome with_stages(int s, auto&& f) {
    if (s == 3) return f(std::integral_constant<int, 3>{});
    if (s == 5) return f(std::integral_constant<int, 5>{});
    return f(std::integral_constant<int, 7>{});
  }
  /// J and the matrices of the stage equations.
  template <int s, class Kernel>
  [[nodiscard]] Outcome prepare(Kernel& kernel, auto& step, const auto& masses) {
    constexpr bool affine = Kernel::Rhs::Traits::is_affine;
    auto& matrices = kernel.stages();
    if (!matrices.has_jacobian() || (!affine && !is_fresh_ && !keeps_)) {
      factored_ = 0;
      if constexpr (!matrices.analytic) {
        kernel.evaluate(step.t, step.y, step.psi);
        if (first_non_finite(RateOf<S>::blocks(std::as_const(step.psi)))) {
          copy_blocks<S>(step.next, step.y);  // kept for the failure message
          return Outcome::non_finite_force;
        }
      }
      if (const Outcome outcome =
              matrices.tangent(kernel.rhs(), step.t, step.dt, step.y, step.psi, kernel.allowed(step));
          failed(outcome))
        return outcome;
      is_fresh_ = true;
    }
    if (factored_ == s && factored_dt_ == step.dt) return Outcome::success;
    const Outcome outcome = matrices.factorize(kernel.rhs(), work_.template shift<s>(step.dt, masses), masses);
    factored_ = failed(outcome) ? 0 : s;
    factored_dt_ = step.dt;
    return outcome;
  }

  /// Ψ at every stage.
  template <int s, class Kernel>
  void evaluate(Kernel& kernel, auto& step) {
    work_.template to_stages<s>();
    if constexpr (drifts) work_.template to_positions<s>(step.dt, velocity_of<S>(step.y));
    for (std::size_t j = 0; j < s; ++j) {
      to_stage(step, j);
      kernel.evaluate(step.t + radau_constants<Scalar, s>.c[j] * step.dt, step.next, step.psi);
      for_each_number([&](std::size_t i, Scalar psi) { work_.psi(i)[j] = psi; }, RateOf<S>::blocks(step.psi));
    }
  }
  /// next = Y_j
  void to_stage(auto& step, std::size_t j) {
    if constexpr (drifts)
      for_each_number([&](std::size_t i, Scalar y, Scalar& to) { to = y + work_.r(i)[j]; }, positions(step.y),
                      positions(step.next));
    for_each_number([&](std::size_t i, Scalar y, Scalar& to) { to = y + work_.z(i)[j]; }, solved(step.y),
                    solved(step.next));
  }
  /// Which stage has made an iteration fail, for the message: its Ψ is in psi, where it isn't finite.
  template <int s>
  [[gnu::cold, gnu::noinline]] Outcome blame(auto& step, Judgement judgement) {
    for (std::size_t j = 0; j < s; ++j) {
      bool finite = true;
      for (std::size_t i = 0; i < n_; ++i) finite = finite && std::isfinite(work_.psi(i)[j]);
      if (finite) continue;
      to_stage(step, j);
      for_each_number([&](std::size_t i, Scalar& psi) { psi = work_.psi(i)[j]; }, RateOf<S>::blocks(step.psi));
      return Outcome::non_finite_force;
    }
    return judgement == Judgement::growing ? Outcome::newton_diverged : Outcome::newton_stalled;
  }
  /// next = y + Z_s
  template <int s>
  void add_increment(auto& step) {
    if constexpr (drifts)
      for_each_number([&](std::size_t i, Scalar r, Scalar v,
                          Scalar& to) { to = r + work_.template position_increment<s>(step.dt, v, i); },
                      positions(step.y), velocities(step.y), positions(step.next));
    for_each_number([&](std::size_t i, Scalar y, Scalar& to) { to = y + work_.increment(i); }, solved(step.y),
                    solved(step.next));
  }

  template <int s, class Kernel>
  [[nodiscard]] Outcome advance_with(Kernel& kernel, auto& step) {
    const auto masses = each_mass_entry<S>(kernel.rhs(), step.y);
    if (const Outcome outcome = this->template prepare<s>(kernel, step, masses); outcome != Outcome::success)
      return outcome;
    work_.clear();
    return to_rounding<s>(kernel, step, masses);
  }
  /// Iterates until only rounding is left, block by block in units of the largest component.
  template <int s, class Kernel>
  [[nodiscard]] Outcome to_rounding(Kernel& kernel, auto& step, const auto& masses) {
    RoundingIteration<> test{round_off};
    Judgement judgement = Judgement::go_on;
    for (bool first = true; judgement == Judgement::go_on; first = false) {
      bool has_scale = true;
      this->template evaluate<s>(kernel, step);
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
          step.y);
      const double size = this->template correction<s>(kernel, masses);
      // From rest, the first correction is what the next is measured by: its own size would be a number with a unit.
      if (has_scale || !first) judgement = test.judge(size);
      else if (!std::isfinite(size)) judgement = Judgement::slow;
    }
    if (judgement != Judgement::converged) return this->template blame<s>(step, judgement);
    this->template add_increment<s>(step);
    return Kernel::Rhs::is_finite(step.next) ? Outcome::success : Outcome::non_finite_state;
  }
  /// ‖δ‖ of one iteration.
  template <int s, class Kernel>
  [[nodiscard]] double correction(Kernel& kernel, const auto& masses) {
    ++kernel.rhs().statistics().solves;
    ++kernel.rhs().statistics().iterations;
    const auto sum = work_.template correct<s>(kernel.stages(), masses, weight_);
    return n_ == 0 ? 0 : std::sqrt(static_cast<double>(sum) / static_cast<double>(s * n_));
  }

  template <int s, class Kernel>
  [[nodiscard]] Outcome trace_with(Kernel& kernel, auto& step) {
    auto& trace = step.trace;
    const double dt = std::abs(static_cast<double>(step.dt));
    const auto masses = each_mass_entry<S>(kernel.rhs(), step.y);
    pending_terms_ = 0;
    if (const Outcome outcome = this->template prepare<s>(kernel, step, masses); outcome != Outcome::success) {
      trace.proposed = control_.failed(dt, 0.5);
      return outcome;
    }
    if (terms_ > 0) work_.template predict<s>(powers_, terms_, step.dt / dt_);
    else work_.clear();
    for_each_number([&](std::size_t i, Scalar weight) { weight_[i] = weight; }, solved(trace.weight));
    RadauIteration<> test = control_.iteration(round_off);
    Judgement judgement = Judgement::go_on;
    while (judgement == Judgement::go_on) {
      this->template evaluate<s>(kernel, step);
      judgement = test.judge(this->template correction<s>(kernel, masses));
    }
    if (judgement != Judgement::converged && keeps_ && !is_fresh_) {
      keeps_ = false;  // an older J's fault, perhaps
      return this->template trace_with<s>(kernel, step);
    }
    if (judgement != Judgement::converged) {
      trace.proposed = control_.failed(dt, test.shrink());
      return this->template blame<s>(step, judgement);
    }
    this->template add_increment<s>(step);
    if (!Kernel::Rhs::is_finite(step.next)) {
      trace.proposed = control_.failed(dt, 0.5);
      return Outcome::non_finite_state;
    }
    this->template estimate<s>(kernel, step, masses);
    bool success = false;
    // A Jacobian that the force gives costs less than the iterations that an old one would add.
    pending_keeps_ = !std::remove_cvref_t<decltype(kernel.stages())>::analytic && control_.is_fast(test);
    trace.proposed = control_.after(dt, trace.size_of(trace.error, step.y, step.next), test, pending_keeps_, success);
    if (!success) return Outcome::error_too_large;
    keep<s>(step);
    return Outcome::success;
  }

  /// trace.error by (2)
  template <int s, class Kernel>
  void estimate(Kernel& kernel, auto& step, const auto& masses) {
    auto& trace = step.trace;
    const Scalar h = step.dt, by = radau_constants<Scalar, s>.mu.re[0] * h;
    for_each_number(
        [&](std::size_t i, Scalar start) {
          slope_[i] = start - work_.template slope_at_start<s>(i) / h;
          error_[i] = 0;
        },
        solved(trace.start));
    masses([this](auto i, auto j, auto m) {
      error_[static_cast<std::size_t>(i)] += static_cast<Scalar>(m) * slope_[static_cast<std::size_t>(j)];
    });
    if constexpr (drifts) {
      for_each_number(
          [&](std::size_t j, Scalar& e, Scalar v) { e = v - work_.template position_slope_at_start<s>(h, v, j) / h; },
          positions(trace.error), velocities(step.y));
      kernel.stages().add_position_product(by, position_of<S>(trace.error), error_);
    }
    ++kernel.rhs().statistics().solves;
    work_.solve_real(kernel.stages(), error_);
    for_each_number([&](std::size_t i, Scalar& e) { e = error_[i]; }, solved(trace.error));
    if constexpr (drifts)
      position_of<S>(trace.error) = by * (position_of<S>(trace.error) + velocity_of<S>(trace.error));
    trace.has_error = true;
  }
  /// The polynomial, for the next step, and y' at this one's end.
  template <int s>
  void keep(auto& step) {
    auto& trace = step.trace;
    work_.template to_powers<s>(next_powers_);
    pending_terms_ = s;
    pending_dt_ = step.dt;
    for_each_number([&](std::size_t i, Scalar& end) { end = next_powers_[i][0] / step.dt; }, solved(trace.end));
    if constexpr (drifts) {
      position_of<S>(trace.end) = velocity_of<S>(std::as_const(step.next));
      if (trace.wants_dense)
        work_.template positions_to_powers<s>(step.dt, velocity_of<S>(step.y), next_position_powers_);
    }
    trace.has_slopes = true;
  }

  struct Nothing {};
  Radau scheme_;
  RadauControl<> control_;
  Work work_;
  std::size_t n_ = 0;
  Powers powers_{}, next_powers_{};  // of the step accepted last, of the one in hand
  [[no_unique_address]] std::conditional_t<drifts, Powers, Nothing> position_powers_{}, next_position_powers_{};
  Numbers weight_{}, slope_{}, error_{};
  Scalar dt_{0}, pending_dt_{0}, factored_dt_{0};  // [time]
  int terms_ = 0, pending_terms_ = 0, factored_ = 0;
  bool is_fresh_ = false, keeps_ = false, pending_keeps_ = false;  // J: of this step's start, of an earlier one
};

}  // namespace phistep::inline PHISTEP_ABI

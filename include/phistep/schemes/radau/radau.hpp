/// @file
/// Radau IIA methods of 3, 5 and 7 stages, orders 5, 9 and 13 (E. Hairer & G. Wanner, J. Comput. Appl. Math. 111 (1999) 93;
/// Solving ODEs II, sect. IV.5 and IV.8): for M y' = Ψ(t, y) and motion, with h = Δt,
///
///     M Z_i = h Σ_j a_ij Ψ(t + c_j h, y + Z_j),     y⁺ = y + Z_s                                                (1)
///
/// L-stable and stiffly accurate, for stiff problems at many digits. Solved by simplified Newton iterations
/// (radau_solver.hpp) from the collocation polynomial u of the step before, whose coefficients about the step's end are
/// also the dense output (order s) and y' there. The error of a step is estimated by
///
///     e = (λ₀/h M − J)⁻¹ M (y'(t) − u'(t)),                                                                     (2)
///
/// λ₀ the real eigenvalue of A⁻¹: y' by the step before, u' by this one's polynomial continued to its start. (2) is the
/// difference to an embedded formula of order s with weight 1/λ₀ on y'(t), without what the method damps (HW II, eq.
/// IV.8.19). It goes as h^{s+1}; radau_control.hpp says how that is used.
#pragma once

#include <cmath>
#include <cstddef>
#include <stdexcept>
#include <type_traits>
#include <utility>

#include "phistep/base/facts/scheme_facts.hpp"
#include "phistep/base/machine/memory.hpp"
#include "phistep/base/outcome/outcome.hpp"
#include "phistep/base/state/blocks.hpp"
#include "phistep/base/state/unknowns.hpp"
#include "phistep/schemes/radau/radau_control.hpp"
#include "phistep/schemes/radau/radau_solver.hpp"
#include "phistep/schemes/radau/radau_tableau.hpp"
#include "phistep/step/kernel/scheme_on.hpp"
#include "phistep/step/mass/bound_masses.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

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
  static constexpr KernelNeeds needs{.carries = can_carry<Rhs>, .stages = true, .shifted = true};

  SchemeOn(Radau scheme, const Plain& y) : scheme_{scheme}, control_{scheme.stages} { resize(y); }
  void resize(const Plain& y) {
    solver_.resize(y);
    Work::make(solver_.n(), powers_, next_powers_, slope_, error_);
    if constexpr (drifts)
      Work::make(static_cast<std::size_t>(position_of<S>(y).size()), position_powers_, next_position_powers_);
    forget();
  }
  [[nodiscard]] int order() const { return 2 * (scheme_.stages == 0 ? 3 : scheme_.stages) - 1; }
  /// It judges its errors itself.
  [[nodiscard]] int error_order() const { return order(); }

  [[nodiscard]] static bool takes_singular_mass() { return true; }
  static constexpr bool traces = true, interpolates = true;
  [[nodiscard]] static bool estimates(const auto&) { return true; }
  [[nodiscard]] static bool leaves_force() { return false; }  // the last Ψ is that before the last correction
  /// A traced step is solved to the tolerance, and chooses order and Δt; another one to rounding.
  template <class Eq>
  [[nodiscard]] Outcome step(Eq& eq) {
    copy_blocks<S>(eq.next, eq.y);  // kept for the failure message
    pending_terms_ = 0;
    if constexpr (Eq::is_traced) {
      auto& trace = eq.trace;
      const bool edited = !trace.knows_start;
      if (edited) solver_.begin();
      if (trace.dt_before == 0) terms_ = 0;
      if (const Outcome outcome = eq.start(); outcome != Outcome::success) return outcome;
      control_.begin(trace.rtol, edited);
      return with_stages(control_.stages(), [&](auto s) { return this->template trace_with<s>(eq); });
    } else {
      solver_.begin();
      RadauIteration to_rounding{Solver::round_off, 1, 50, Solver::round_off};
      return with_stages((order() + 1) / 2, [&](auto s) {
        return this->template solve<s>(eq, each_mass_entry<S>(eq.rhs().masses(), eq.y), to_rounding);
      });
    }
  }
  /// The collocation polynomial of the step just accepted, in powers of x − 1. In its first half what these have lost in rounding at
  /// x = 0 is put back, so that it begins at y0.
  void interpolate(Scalar x, Scalar, const Plain& y0, const Plain& y1, Plain& out) const {
    const auto add = [&](const auto& powers) {
      const auto from_end = [&](std::size_t i, Scalar back) {
        Scalar sum{0};
        for (auto m = static_cast<std::size_t>(terms_); m-- > 0;) sum = back * (sum + powers[i][m]);
        return sum;
      };
      return [&, from_end](std::size_t i, Scalar start, Scalar end, Scalar& to) {
        const Scalar back = x - 1, sum = from_end(i, back);
        if (2 * x >= 1) return void(to = end + sum);
        const Scalar whole = from_end(i, Scalar{-1}), lost = start - (end + whole);
        to = start + ((sum - whole) - 2 * (1 + back) * lost);
      };
    };
    if constexpr (drifts)
      for_each_number(add(position_powers_), Solver::positions(y0), Solver::positions(y1), Solver::positions(out));
    for_each_number(add(powers_), Solver::solved(y0), Solver::solved(y1), Solver::solved(out));
  }
  void accepted() {
    solver_.accept(pending_keeps_);
    terms_ = pending_terms_;
    dt_ = pending_dt_;
    std::swap(powers_, next_powers_);
    if constexpr (drifts) std::swap(position_powers_, next_position_powers_);
  }
  void forget() {
    solver_.forget();
    terms_ = pending_terms_ = 0;
  }
  void reset() { control_.forget(); }
  using Progress = RadauControl;
  [[nodiscard]] const Progress& progress() const { return control_; }
  void resume(const Progress& progress) { control_ = progress; }
  void archive(auto& ar) {
    ar("control", control_, "terms", terms_, "dt", dt_);
    ar.check(terms_ >= 0 && terms_ <= 7);
    if (terms_ > 0)
      for (std::size_t i = 0; i < solver_.n(); ++i) ar(powers_[i]);
    if constexpr (std::remove_reference_t<decltype(ar)>::reading) solver_.forget();
  }

 private:
  using Solver = RadauSolver<S>;
  using Work = typename Solver::Work;
  static constexpr bool drifts = Blocks<S>::drifts;
  using Powers = typename Work::template Each<typename Work::Row>;

  [[nodiscard]] static Outcome with_stages(int s, auto&& f) {
    if (s == 3) return f(std::integral_constant<int, 3>{});
    if (s == 5) return f(std::integral_constant<int, 5>{});
    return f(std::integral_constant<int, 7>{});
  }
  /// h/λ₀, of the real matrix
  template <int s>
  [[nodiscard]] static Gamma<Scalar> real_gamma(Scalar h) {
    const Scalar gamma = radau_constants<Scalar, s>.mu.re[0] * h;
    return {gamma, gamma};
  }
  /// The stage equations of a step, solved, and its end.
  template <int s, class Eq>
  [[nodiscard]] Outcome solve(Eq& eq, const auto& masses, RadauIteration& test) {
    if (const Outcome bad = solver_.template prepare<s>(eq, masses); failed(bad)) return bad;
    if (const Outcome bad = eq.check_start(real_gamma<s>(eq.dt)); failed(bad)) return bad;
    if (Eq::is_traced && terms_ > 0) solver_.work().template predict<s>(powers_, terms_, eq.dt / dt_);
    else solver_.work().clear();
    const RadauIteration again = test;
    if (const Judgement judgement = solver_.template iterate<s>(eq, masses, test); judgement != Judgement::converged) {
      if (!solver_.drop_old()) return solver_.template blame<s>(eq, judgement);
      test = again;
      return this->template solve<s>(eq, masses, test);
    }
    solver_.template add_increment<s>(eq);
    return Eq::Rhs::is_finite(eq.next) ? Outcome::success : Outcome::non_finite_state;
  }
  template <int s, class Eq>
  [[nodiscard]] Outcome trace_with(Eq& eq) {
    auto& trace = eq.trace;
    const double dt = std::abs(static_cast<double>(eq.dt));
    const auto masses = each_mass_entry<S>(eq.rhs().masses(), eq.y);
    RadauIteration test = control_.iteration(Solver::round_off);
    if (const Outcome bad = this->template solve<s>(eq, masses, test); failed(bad)) {
      trace.proposed = control_.failed(dt, test.shrink());
      return bad;
    }
    this->template end_slope<s>(eq);
    if (const Outcome bad = this->template estimate<s>(eq, masses); failed(bad)) {
      trace.proposed = control_.failed(dt, 0.5);
      return bad;
    }
    if (trace.has_hidden && solver_.drop_old()) return this->template trace_with<s>(eq);
    if (const Outcome bad = eq.look_at_end(); failed(bad)) return bad;
    bool success = false;
    // A Jacobian that the force gives costs less than the iterations that an old one would add.
    pending_keeps_ =
        !std::remove_cvref_t<decltype(eq.stages())>::analytic && control_.is_fast(test) && !trace.has_hidden;
    trace.proposed = control_.after(dt, eq.size_of_error(), test, pending_keeps_, success);
    if (!success) return Outcome::error_too_large;
    keep<s>(eq);
    return Outcome::success;
  }

  /// trace.error by (2)
  template <int s>
  [[nodiscard]] Outcome estimate(auto& eq, const auto& masses) {
    auto& trace = eq.trace;
    const Scalar h = eq.dt, by = radau_constants<Scalar, s>.mu.re[0] * h;
    set_zero(Blocks<S>::all(trace.error));
    for_each_number([&](std::size_t i, Scalar start,
                        Scalar& e) { e = start - Work::template slope_at_start<s>(solver_.work().w(i)) / h; },
                    Solver::solved(trace.start), Solver::solved(trace.error));
    if (const Outcome bad = eq.add_defect(Scalar{1}, trace.error); failed(bad)) return bad;
    for_each_number(
        [&](std::size_t i, Scalar& e) {
          slope_[i] = e;
          error_[i] = 0;
          e *= by;
        },
        Solver::solved(trace.error));
    eq.keep_unfiltered(trace.error);
    masses([this](auto i, auto j, auto m) {
      error_[static_cast<std::size_t>(i)] += static_cast<Scalar>(m) * slope_[static_cast<std::size_t>(j)];
    });
    if constexpr (drifts) {
      for_each_number(
          [&](std::size_t j, Scalar& e, Scalar v) {
            e = v - (h * v + Work::template slope_at_start<s>(solver_.work().template drifted<s>(h, j))) / h;
          },
          Solver::positions(trace.error), Solver::velocities(eq.y));
      eq.stages().add_position_product(by, position_of<S>(trace.error), error_);
    }
    ++eq.rhs().statistics().solves;
    eq.stages().solve_real(error_);
    for_each_number([&](std::size_t i, Scalar& e) { e = error_[i]; }, Solver::solved(trace.error));
    if constexpr (drifts)
      position_of<S>(trace.error) = by * (position_of<S>(trace.error) + velocity_of<S>(trace.error));
    trace.has_error = true;
    return eq.see_hidden({by, by}, control_.allowed());
  }
  /// The polynomial, and y' at the step's end.
  template <int s>
  void end_slope(auto& eq) {
    auto& trace = eq.trace;
    for_each_number(
        [&](std::size_t i, Scalar& end) {
          Work::template to_powers<s>(solver_.work().w(i), next_powers_[i]);
          end = next_powers_[i][0] / eq.dt;
        },
        Solver::solved(trace.end));
    if constexpr (drifts) position_of<S>(trace.end) = velocity_of<S>(std::as_const(eq.next));
  }
  /// The polynomial serves the next step, and inside this one.
  template <int s>
  void keep(auto& eq) {
    pending_terms_ = s;
    pending_dt_ = eq.dt;
    if constexpr (drifts)
      if (eq.trace.wants_dense)
        for_each_number(
            [&](std::size_t i, Scalar v) {
              Work::template to_powers<s>(solver_.work().template drifted<s>(eq.dt, i), next_position_powers_[i]);
              next_position_powers_[i][0] += eq.dt * v;
            },
            Solver::velocities(eq.y));
    eq.trace.has_slopes = true;
  }

  Radau scheme_;
  RadauControl control_;
  Solver solver_;
  Powers powers_{}, next_powers_{};  // of the step accepted last, of the one in hand
  [[no_unique_address]] Only<drifts, Powers> position_powers_{}, next_position_powers_{};
  typename Solver::Numbers slope_{}, error_{};
  Scalar dt_{0}, pending_dt_{0};  // [time]
  int terms_ = 0, pending_terms_ = 0;
  bool pending_keeps_ = false;
};

}}  // namespace phistep::PHISTEP_ABI

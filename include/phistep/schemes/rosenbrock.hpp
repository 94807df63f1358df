/// @file
/// Rosenbrock schemes: linearly implicit Runge-Kutta steps, whose stages are linear equations with one matrix
/// (H. H. Rosenbrock, Comput. J. 5 (1963) 329; Hairer & Wanner, Solving ODEs II, sect. IV.7, eq. 7.25):
///
///     Y_i = y + Σ_{j<i} a_ij u_j                                                                                (1)
///     (M − γΔtJ) u_i = γΔt Ψ(t + α_iΔt, Y_i) + γM Σ_{j<i} c_ij u_j + γγ_iΔt² Ψ_t(t, y)                          (2)
///     y⁺ = Y_s + u_s                                                                                            (3)
///
/// with J = Ψ_y(t, y). (3) is how a stiffly accurate scheme ends: Y_s is itself a solution of the embedded order, so that
/// the last u_s estimates the error. J must be the Jacobian, or the order is lost: an analytic one, automatic
/// differentiation or differences. For motion, y = (r, v), the solves are of n unknowns (linear_stages.hpp).
#pragma once

#include <array>
#include <type_traits>
#include <utility>

#include "phistep/base/machine/memory.hpp"
#include "phistep/base/outcome/outcome.hpp"
#include "phistep/base/state/blocks.hpp"
#include "phistep/base/state/combination.hpp"
#include "phistep/base/state/unknowns.hpp"
#include "phistep/schemes/rodas.hpp"
#include "phistep/step/kernel/scheme_on.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

template <class Tableau, State S>
class SchemeOn<Rosenbrock<Tableau>, S> : public SchemeDefaults {
 public:
  using Scalar = ScalarOf<S>;
  using Plain = PlainState<S>;
  template <class Rhs>
  static constexpr KernelNeeds needs{.carries = can_carry<Rhs>, .stages = true};
  static constexpr std::size_t stages = Tableau::stages;

  SchemeOn(Rosenbrock<Tableau>, const Plain& y) { resize(y); }
  void resize(const Plain& y) {
    if constexpr (!on_stack) u_.fill(y), weighted_ = y;
    inside_.fill(y);
  }
  [[nodiscard]] static int order() { return Tableau::order; }
  [[nodiscard]] static int error_order() { return Tableau::order; }

  [[nodiscard]] static bool takes_singular_mass() { return true; }
  static constexpr bool traces = true;
  [[nodiscard]] static bool estimates(const auto&) { return true; }
  [[nodiscard]] static bool leaves_force() { return false; }  // the last Ψ is that at Y_s

  [[nodiscard]] Outcome step(auto& eq) {
    return with_stages([&](auto& u, Plain& weighted) {
      if (const Outcome bad = all(eq, u, weighted, All{}); failed(bad)) return bad;
      eq.tell([&](auto& trace) {
        copy_blocks<S>(trace.error, u[stages - 1]);
        trace.has_error = true;
        if (trace.wants_dense) keep_inside(u, std::make_index_sequence<Tableau::dense>{});
      });
      const Scalar gamma = static_cast<Scalar>(Tableau::gamma) * eq.dt;
      return eq.see_falling_rates({gamma, gamma}, true);
    });
  }

  static constexpr bool interpolates = Tableau::dense > 0;
  /// y(t + xΔt) = (1−x) y + x {y⁺ + (1−x) [k₁ + x (k₂ + x k₃)]}, k = Σ_j h_j u_j
  void interpolate(Scalar x, Scalar, const Plain& y0, const Plain& y1, Plain& out) const {
    copy_blocks<S>(out, inside_[Tableau::dense - 1]);
    const auto k = in<S>(out), start = in<S>(y0), end = in<S>(y1);
    for (std::size_t j = inside_.size() - 1; j-- > 0;) assign<S>(out, in<S>(inside_[j]) + x * k);
    assign<S>(out, (1 - x) * start + x * (end + (1 - x) * k));
  }

 private:
  static constexpr bool on_stack = fits_registers<S>;

  /// f(u, scratch): a small state's stages live in registers.
  [[nodiscard]] Outcome with_stages(auto&& f) {
    if constexpr (on_stack) {
      std::array<Plain, stages> u;
      Plain weighted;
      return f(u, weighted);
    } else {
      return f(u_, weighted_);
    }
  }

  using All = std::make_index_sequence<stages>;
  template <const auto& table, std::size_t i, std::size_t n = i>
  [[nodiscard]] static auto sum(const std::array<Plain, stages>& u) {
    return weighted_sum<S, TableRow<table, i, n>>(u);
  }
  template <std::size_t... k>
  void keep_inside(const auto& u, std::index_sequence<k...>) {
    (assign<S>(inside_[k], sum<Tableau::inside, k, stages>(u)), ...);
  }
  /// Y_i = Y_{i−1} + u_{i−1}
  [[nodiscard]] static constexpr bool follows(std::size_t i) {
    for (std::size_t j = 0; j < i; ++j)
      if (Tableau::a[i][j] != (j == i - 1 ? 1 : Tableau::a[i - 1][j])) return false;
    return i > 0;
  }

  template <class Eq, std::size_t... i>
  [[nodiscard]] static Outcome all(Eq& eq, auto& u, Plain& weighted, std::index_sequence<i...>) {
    if (const Outcome outcome = eq.linearize(); outcome != Outcome::success) return outcome;
    const Scalar gamma = static_cast<Scalar>(Tableau::gamma) * eq.dt;
    if (const Outcome outcome = eq.factorize(gamma); outcome != Outcome::success) return outcome;
    if (const Outcome bad = eq.check_start({gamma, gamma}); failed(bad)) return bad;
    Outcome outcome = Outcome::success;
    static_cast<void>(((outcome = stage<i>(eq, gamma, u, weighted), outcome == Outcome::success) && ...));
    if (outcome != Outcome::success) return outcome;
    add<S>(eq.next, in<S>(u[stages - 1]));  // (3)
    if (Eq::Rhs::is_finite(eq.next)) return Outcome::success;
    static_cast<void>((blame<i>(eq, u) || ...));
    return Outcome::non_finite_state;
  }
  /// Where u_i isn't finite: leaves Y_i and Ψ there for the failure message.
  template <std::size_t i>
  [[nodiscard, gnu::cold, gnu::noinline]] static bool blame(auto& eq, const auto& u) {
    if (all_finite(Blocks<S>::all(u[i]))) return false;
    if constexpr (i > 0) {
      assign<S>(eq.next, in<S>(eq.y) + sum<Tableau::a, i>(u));
      eq.evaluate(eq.t + static_cast<Scalar>(Tableau::alpha[i]) * eq.dt, eq.next);
    }
    return true;
  }

  template <std::size_t i, class Eq>
  [[nodiscard]] static Outcome stage(Eq& eq, Scalar gamma, auto& u, Plain& weighted) {
    Plain &Y = eq.next, &b = u[i];
    const auto psi = in_rate<S>(eq.psi);
    if constexpr (i == 0) {
      copy_blocks<S>(Y, eq.y);
      assign_solved<S>(b, gamma * psi);
      if constexpr (Blocks<S>::drifts) position_of<S>(b) = gamma * velocity_of<S>(Y);
    } else {
      if constexpr (follows(i)) add<S>(Y, in<S>(u[i - 1]));
      else assign<S>(Y, in<S>(eq.y) + sum<Tableau::a, i>(u));  // (1)
      eq.evaluate(eq.t + static_cast<Scalar>(Tableau::alpha[i]) * eq.dt, Y);
      assign<S>(weighted, sum<Tableau::c, i>(u));
      set_zero(Blocks<S>::solved(b));
      eq.add_mass_product(b, static_cast<Scalar>(Tableau::gamma), weighted);
      if constexpr (Blocks<S>::drifts)
        position_of<S>(b) = gamma * velocity_of<S>(Y) + static_cast<Scalar>(Tableau::gamma) * position_of<S>(weighted);
      add_solved<S>(b, gamma * psi);
    }
    if constexpr (Eq::has_time && Tableau::gammas[i] != 0)
      add_solved<S>(b, gamma * static_cast<Scalar>(Tableau::gammas[i]) * eq.dt * in_rate<S>(eq.psi_t()));
    if constexpr (i == stages - 1) eq.keep_unfiltered_product(b);
    return solve<i>(eq, gamma, u);
  }

  /// κ_i = 1 + γ Σ_{j<i} c_ij κ_j: where Ψ doesn't change during the step, u_i = κ_i u_1.
  [[nodiscard]] static constexpr long double kappa(std::size_t i) {
    long double sum = 1;
    for (std::size_t j = 0; j < i; ++j) sum += Tableau::gamma * Tableau::c[i][j] * kappa(j);
    return sum;
  }
  /// u_i from the right-hand side of (2), which stands in its place. An iteration begins with κ_i u_1:
  /// (M − γΔtJ)(u_i − κ_i u_1) = b_i − κ_i b_1. κ_s = 0, so that u_s has room for b_1 until it is its turn.
  template <std::size_t i, class Eq>
  [[nodiscard]] static Outcome solve(Eq& eq, Scalar gamma, auto& u) {
    constexpr long double share = kappa(i), none = 1e-6L;
    using Stages = std::remove_cvref_t<decltype(eq.stages())>;
    if constexpr (Stages::iterates && (share > none || share < -none)) {
      static_assert(kappa(stages - 1) < none && kappa(stages - 1) > -none);
      if (eq.stages().follows_error()) {
        if constexpr (i == 0) copy_blocks<S>(u[stages - 1], u[0]);
        else return solve_beyond(eq, gamma, static_cast<Scalar>(share), u, u[i]);
      }
    }
    return eq.solve(gamma, u[i]);
  }
  [[nodiscard]] static Outcome solve_beyond(auto& eq, Scalar gamma, Scalar share, const auto& u, Plain& x) {
    add<S>(x, -share * in<S>(u[stages - 1]));
    if (const Outcome bad = eq.solve(gamma, x); failed(bad)) return bad;
    add<S>(x, share * in<S>(u[0]));
    return Outcome::success;
  }

  [[no_unique_address]] Only<!on_stack, std::array<Plain, stages>> u_;
  [[no_unique_address]] Only<!on_stack, Plain> weighted_;
  std::array<Plain, static_cast<std::size_t>(Tableau::dense)> inside_;
};

}}  // namespace phistep::PHISTEP_ABI

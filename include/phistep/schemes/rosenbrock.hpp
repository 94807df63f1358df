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

#include "phistep/core/outcome.hpp"
#include "phistep/core/version.hpp"
#include "phistep/problem/kernel.hpp"
#include "phistep/schemes/rodas.hpp"
#include "phistep/state/blocks.hpp"
#include "phistep/state/unknowns.hpp"

namespace phistep::inline PHISTEP_ABI {

template <class Tableau, State S>
class SchemeOn<Rosenbrock<Tableau>, S> : public SchemeDefaults {
 public:
  using Scalar = ScalarOf<S>;
  using Plain = PlainState<S>;
  template <class Rhs>
  static constexpr KernelNeeds needs{.stages = true};
  static constexpr int stages = Tableau::stages;

  SchemeOn(Rosenbrock<Tableau>, const Plain& y) { resize(y); }
  void resize(const Plain& y) {
    if constexpr (!on_stack) u_.fill(y), weighted_ = y;
    inside_.fill(y);
  }
  [[nodiscard]] static int order() { return Tableau::order; }
  [[nodiscard]] static int error_order() { return Tableau::order; }

  static constexpr bool traces = true;
  [[nodiscard]] static bool estimates(const auto&) { return true; }

  template <class Step>
  [[nodiscard]] Outcome step(auto& kernel, Step& step) {
    return with_stages([&](auto& u, Plain& weighted) {
      if (const Outcome bad = all(kernel, step, u, weighted, indices); failed(bad)) return bad;
      if constexpr (Step::is_traced) {
        copy_blocks<S>(step.trace.error, u[stages - 1]);
        step.trace.has_error = true;
        if (step.trace.wants_dense) keep_inside(u);
      }
      return Outcome::success;
    });
  }

  static constexpr bool interpolates = Tableau::dense > 0;
  /// y(t + xΔt) = (1−x) y + x {y⁺ + (1−x) [k₁ + x (k₂ + x k₃)]}, k = Σ_j h_j u_j
  void interpolate(Scalar x, Scalar, const Plain& y0, const Plain& y1, Plain& out) const {
    copy_blocks<S>(out, inside_[Tableau::dense - 1]);
    for_each_index<Tableau::dense - 1>([&](auto k) {
      for_each_block([x](auto, auto& to, const auto& next) { to = next + x * to; }, Blocks<S>::all(out),
                     Blocks<S>::all(inside_[Tableau::dense - 2 - k]));
    });
    for_each_block([x](auto, auto& to, const auto& a, const auto& b) { to = (1 - x) * a + x * (b + (1 - x) * to); },
                   Blocks<S>::all(out), Blocks<S>::all(y0), Blocks<S>::all(y1));
  }

 private:
  static constexpr auto indices = std::make_integer_sequence<int, stages>{};
  static constexpr int size = static_size<decltype(Blocks<S>::all(std::declval<Plain&>()))>;
  static constexpr bool on_stack = size != Eigen::Dynamic && size <= 64;

  template <int n>
  static void for_each_index(auto&& f) {
    [&]<int... k>(std::integer_sequence<int, k...>) { (f(std::integral_constant<int, k>{}), ...); }
    (std::make_integer_sequence<int, n>{});
  }
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

  void keep_inside(const auto& u) {
    for_each_index<Tableau::dense>([&](auto k) {
      for_each_block([&](auto block, auto& to) { to = sum<Weights::inside, k, stages>(block, u); },
                     Blocks<S>::all(inside_[k]));
    });
  }

  enum class Weights { a, c, inside };
  template <Weights which, int i>
  [[nodiscard]] static constexpr long double weight(int j) {
    if constexpr (which == Weights::a) return Tableau::a[i][j];
    else if constexpr (which == Weights::c) return Tableau::c[i][j];
    else return Tableau::inside[i][j];
  }
  /// The last weight before n that isn't zero, −1 where there is none.
  template <Weights which, int i>
  [[nodiscard]] static constexpr int last_non_zero(int n) {
    while (--n >= 0 && weight<which, i>(n) == 0) {
    }
    return n;
  }
  /// Σ_{j<n} weights_j u_j of one block, as one expression without its zeros. The newest stage, for which all wait, comes last.
  template <Weights which, int i, int n>
  [[nodiscard]] static auto sum(auto block, const auto& u) {
    constexpr int j = last_non_zero<which, i>(n);
    const auto term = static_cast<Scalar>(weight<which, i>(j)) * std::get<block()>(Blocks<S>::all(u[j]));
    if constexpr (last_non_zero<which, i>(j) < 0) return term;
    else return sum<which, i, j>(block, u) + term;
  }
  /// y + Σ_{j<n} a_ij u_j, likewise
  template <int i, int n>
  [[nodiscard]] static auto moved(const auto& y, auto block, const auto& u) {
    constexpr int j = last_non_zero<Weights::a, i>(n);
    const auto term = static_cast<Scalar>(weight<Weights::a, i>(j)) * std::get<block()>(Blocks<S>::all(u[j]));
    if constexpr (last_non_zero<Weights::a, i>(j) < 0) return y + term;
    else return moved<i, j>(y, block, u) + term;
  }
  template <int i>
  static constexpr bool moves = last_non_zero<Weights::a, i>(i) >= 0;
  /// Y_i = Y_{i−1} + u_{i−1}
  [[nodiscard]] static constexpr bool follows(int i) {
    for (int j = 0; j < i; ++j)
      if (Tableau::a[i][j] != (j == i - 1 ? 1 : Tableau::a[i - 1][j])) return false;
    return i > 0;
  }

  template <class Kernel, int... i>
  [[nodiscard]] static Outcome all(Kernel& kernel, auto& step, auto& u, Plain& weighted,
                                   std::integer_sequence<int, i...>) {
    if (const Outcome outcome = kernel.linearise(step); outcome != Outcome::success) return outcome;
    const Scalar gamma = static_cast<Scalar>(Tableau::gamma) * step.dt;
    if (const Outcome outcome = kernel.factorise(gamma); outcome != Outcome::success) return outcome;
    Outcome outcome = Outcome::success;
    static_cast<void>(((outcome = stage<i>(kernel, step, gamma, u, weighted), outcome == Outcome::success) && ...));
    if (outcome != Outcome::success) return outcome;
    add(step.next, u[stages - 1]);  // (3)
    return Kernel::Rhs::is_finite(step.next) ? Outcome::success : Outcome::non_finite_state;
  }
  static void add(Plain& y, const Plain& u) {
    for_each_block([](auto, auto& to, const auto& by) { to += by; }, Blocks<S>::all(y), Blocks<S>::all(u));
  }

  template <int i, class Kernel>
  [[nodiscard]] static Outcome stage(Kernel& kernel, typename Kernel::Data& step, Scalar gamma, auto& u,
                                     Plain& weighted) {
    Plain& Y = step.next;
    if constexpr (!moves<i>) copy_blocks<S>(Y, step.y);
    else if constexpr (follows(i)) add(Y, u[i - 1]);
    else
      for_each_block([&](auto block, auto& to, const auto& y) { to = moved<i, i>(y, block, u); }, Blocks<S>::all(Y),
                     Blocks<S>::all(step.y));  // (1)
    // Where nothing has moved, Ψ is known.
    constexpr bool is_new = moves<i> || (Tableau::alpha[i] != 0 && Kernel::has_time);
    if constexpr (i > 0 && is_new)
      kernel.evaluate(step.t + static_cast<Scalar>(Tableau::alpha[i]) * step.dt, Y, step.psi);
    Plain& b = u[i];
    if constexpr (i > 0) {
      for_each_block([&](auto block, auto& to) { to = sum<Weights::c, i, i>(block, u); }, Blocks<S>::all(weighted));
      for_each_block([](auto, auto& to) { to.setZero(); }, Blocks<S>::solved(b));
      kernel.add_mass_product(b, static_cast<Scalar>(Tableau::gamma), weighted);
    }
    if constexpr (Blocks<S>::drifts) {
      position_of<S>(b) = gamma * velocity_of<S>(std::as_const(Y));
      if constexpr (i > 0)
        position_of<S>(b) += static_cast<Scalar>(Tableau::gamma) * position_of<S>(std::as_const(weighted));
    }
    for_each_block(
        [gamma](auto, auto& to, const auto& psi) {
          if constexpr (i > 0) to += gamma * psi;
          else to = gamma * psi;
        },
        Blocks<S>::solved(b), RateOf<S>::blocks(std::as_const(step.psi)));
    if constexpr (Kernel::has_time && Tableau::gammas[i] != 0)
      for_each_block([by = gamma * static_cast<Scalar>(Tableau::gammas[i]) * step.dt](
                         auto, auto& to, const auto& psi_t) { to += by * psi_t; },
                     Blocks<S>::solved(b), RateOf<S>::blocks(kernel.psi_t()));
    return kernel.solve(gamma, b);  // (2)
  }

  struct Nothing {};
  [[no_unique_address]] std::conditional_t<on_stack, Nothing, std::array<Plain, stages>> u_;
  [[no_unique_address]] std::conditional_t<on_stack, Nothing, Plain> weighted_;
  std::array<Plain, static_cast<std::size_t>(Tableau::dense)> inside_;
};

}  // namespace phistep::inline PHISTEP_ABI

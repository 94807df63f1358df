/// @file
/// Explicit Runge-Kutta pairs, for M y' = Ψ(t, y) and for motion under any force, f(r, v, t) included:
///
///     Y_i = y + Δt Σ_{j<i} a_ij k_j,    k_i = M⁻¹Ψ(t + c_i Δt, Y_i)                                              (1)
///     y⁺  = y + Δt Σ b_j k_j                                                                                    (2)
///
/// (Hairer, Nørsett & Wanner, Solving ODEs I, sect. II.4, II.5; the pairs themselves are in runge_kutta_tableaus.hpp.) The step
/// goes on with the formula of higher order; the error of the lower one is in runge_kutta_estimate.hpp.
///
/// The slope of a motion's r is v, at stage j the sum (1) of the k: r needs no slopes of its own,
///
///     r_i = r + c_i Δt v + Δt² Σ_l (Σ_j a_ij a_jl) k_l                                                          (3)
///
/// (sect. II.14, eq. 14.5).
#pragma once

#include <array>
#include <cstddef>
#include <iterator>
#include <type_traits>
#include <utility>

#include "phistep/base/facts/scheme_facts.hpp"
#include "phistep/base/outcome/outcome.hpp"
#include "phistep/base/state/blocks.hpp"
#include "phistep/base/state/combination.hpp"
#include "phistep/base/state/unknowns.hpp"
#include "phistep/schemes/explicit_stages.hpp"
#include "phistep/schemes/runge_kutta/runge_kutta_estimate.hpp"
#include "phistep/schemes/runge_kutta/runge_kutta_tableaus.hpp"
#include "phistep/step/kernel/scheme_on.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

// The solution inside an explicit Runge-Kutta step, from its slopes k_j and no force call: with z = 1 − x,
//
//     y(t + xΔt) = y + xΔt {p₀ + z [p₁ + x (p₂ + z (p₃ + x (p₄ + …)))]},     p_m = Σ_j P_mj k_j                   (1)
//     p₀ = (y⁺ − y)/Δt,   p₁ = k_0 − p₀,   p₂ = 2p₀ − k_0 − k⁺                                                  (2)
//
// (Hairer, Nørsett & Wanner, Solving ODEs I, sect. II.6, eq. 6.29). (2) alone is Hermite's cubic; the tableau has the rest.

template <class Tableau>
class RungeKuttaInterpolant {
  static constexpr std::size_t stages = Tableau::stages, rows = 3 + std::size(Tableau::inside);

  [[nodiscard]] static constexpr long double P(std::size_t m, std::size_t j) {
    const long double b = Tableau::a[Tableau::end][j], first = j == 0 ? 1 : 0, last = j == Tableau::end ? 1 : 0;
    if (m == 0) return b;
    if (m == 1) return first - b;
    if (m == 2) return 2 * b - first - last;
    return Tableau::inside[m - 3][j];
  }

 public:
  using Weights = std::array<long double, stages>;

  /// The weights w_j(x) in y(t + xΔt) = y + Δt Σ_j w_j k_j.
  [[nodiscard]] static constexpr Weights weights(long double x) {
    Weights w{};
    for (std::size_t j = 0; j < stages; ++j) {
      for (std::size_t m = rows; m-- > 0;) w[j] = P(m, j) + (m % 2 == 0 ? 1 - x : x) * w[j];
      w[j] *= x;
    }
    return w;
  }
  /// out = (1) at x, of the step dt from y0 with slopes k. The r of a motion moves with v = y0.v + Δt Σ a_jl k_l at stage j.
  template <State S, class Rate>
  static void at(ScalarOf<S> x, ScalarOf<S> dt, const PlainState<S>& y0, const std::array<Rate, stages>& k,
                 PlainState<S>& out) {
    using Scalar = ScalarOf<S>;
    const Weights w = weights(static_cast<long double>(x));
    copy_blocks<S>(out, y0);
    for (std::size_t j = 0; j < stages; ++j)
      if (w[j] != 0)
        for_each_block([by = dt * static_cast<Scalar>(w[j])](auto, auto& to, const auto& slope) { to += by * slope; },
                       Blocks<S>::solved(out), Rate::blocks(k[j]));
    if constexpr (Blocks<S>::drifts) {
      auto& r = position_of<S>(out);
      r += x * dt * velocity_of<S>(y0);
      for (std::size_t l = 0; l < stages; ++l) {
        long double sum = 0;
        for (std::size_t j = l + 1; j < stages; ++j) sum += w[j] * Tableau::a[j][l];
        if (sum != 0) r += dt * (dt * (static_cast<Scalar>(sum) * std::get<0>(Rate::blocks(k[l]))));
      }
    }
  }
};

/// An explicit pair as a scheme. @tparam Tableau  Tsit5 or Dop853
template <class Tableau>
struct RungeKutta {
  static constexpr SchemeFacts facts{.motion_only = false,
                                     .is_explicit = true,
                                     .is_symplectic = false,
                                     .is_a_stable = false,
                                     .is_l_stable = false,
                                     .energy = EnergyBalance::rest};
  [[nodiscard]] static constexpr int order() { return Tableau::order; }
  [[nodiscard]] static constexpr const char* name() { return Tableau::name; }
};

/// Order 5, six force calls a step: smooth problems that are not stiff, at 2 to 6 digits.
inline constexpr RungeKutta<Tsit5> tsit5{};
/// Order 8, twelve force calls a step: smooth problems that are not stiff, at 6 digits and more.
inline constexpr RungeKutta<Dop853> dop853{};

template <class Tableau, State S>
class SchemeOn<RungeKutta<Tableau>, S> : public SchemeDefaults {
  static constexpr std::size_t end = Tableau::end, stages = Tableau::stages;
  static constexpr bool drifts = Blocks<S>::drifts;
  using Estimate = RungeKuttaEstimate<Tableau, S>;
  using Rate = RateOf<S>;
  using Stages = ExplicitStages<S, Tableau::stages>;

 public:
  using Scalar = ScalarOf<S>;
  using Plain = PlainState<S>;
  template <class Rhs>
  static constexpr KernelNeeds needs{.position = false};

  SchemeOn(RungeKutta<Tableau>, const Plain& y) { resize(y); }
  void resize(const Plain& y) {
    k_.resize(y);
    inside_ = y;
    known_ = 0;
  }
  [[nodiscard]] static int order() { return Tableau::order; }
  /// The power of Δt in the estimate.
  [[nodiscard]] static int error_order() { return Tableau::error_order; }

  static constexpr bool traces = true;
  [[nodiscard]] static bool estimates(const auto&) { return true; }
  static constexpr bool reads_weights = Estimate::has_two;

  [[nodiscard]] Outcome step(auto& eq) {
    known_ = 0;
    t_ = eq.t;
    if (const Outcome bad = eq.slope_at_start(k_[0]); failed(bad)) return bad;
    const bool arrived = [&]<std::size_t... i>(std::index_sequence<i...>) {
      return (stage<i + 1>(eq.rhs(), eq.t, eq.dt, eq.y, eq.next) && ...);
    }
    (std::make_index_sequence<end - 1>{}) && move<end>(eq.dt, eq.y, eq.next);
    if (!arrived) {
      k_.blame(eq.psi);
      return Outcome::non_finite_state;
    }
    known_ = end;
    return Outcome::success;
  }
  /// The estimate, and the slope at the end where it is part of that
  [[nodiscard]] Outcome error(auto& eq) {
    auto& trace = eq.trace;
    if constexpr (Estimate::needs_end)
      if (const Outcome bad = reach_end(eq); failed(bad)) return bad;
    if (const Outcome bad = eq.look_at_end([&] { return reach_end(eq); }); failed(bad)) return bad;
    if constexpr (reads_weights)
      if (trace.rate != nullptr) eq.weigh_births();
    Estimate::tell(k_, eq.dt, trace);
    if constexpr (requires { Tableau::sure_to; })
      if (trace.rtol > Tableau::sure_to) Estimate::doubt_few_digits(k_, eq);
    return Outcome::success;
  }

  /// The slope at the end, where the next step starts
  [[nodiscard]] Outcome reach_end(auto& eq) {
    if (known_ > end) return Outcome::success;
    if (!k_.evaluate(eq.rhs(), end, eq.t + eq.dt, eq.next) || !all_finite(Rate::blocks(k_[end]))) {
      eq.psi = k_[end];
      return Outcome::non_finite_force;
    }
    known_ = end + 1;
    assign_solved<S>(eq.trace.end, in_rate<S>(k_[end]));
    if constexpr (drifts) position_of<S>(eq.trace.end) = velocity_of<S>(eq.next);
    eq.trace.has_slopes = true;
    return Outcome::success;
  }

  static constexpr bool interpolates = true, is_sure_inside = Tableau::is_sure_inside;
  static constexpr std::array<double, 2> doubtful_at{Tableau::doubtful[0], Tableau::doubtful[1]};
  /// Calls the force at the stages that dense output needs beyond those of the step from y0 just accepted. False where it
  /// isn't finite there.
  [[nodiscard]] bool know_inside(auto& rhs, Scalar dt, const Plain& y0) {
    if (known_ == stages) return true;
    if (known_ < end) return false;
    rhs.begin(t_, dt, y0);
    copy_blocks<S>(inside_, y0);  // for properties of the state (radii …), which stages don't write
    return [&]<std::size_t... i>(std::index_sequence<i...>) {
      return ((known_ > end + i || stage<end + i>(rhs, t_, dt, y0, inside_)) && ...);
    }
    (std::make_index_sequence<stages - end>{}) && all_finite(Rate::blocks(k_[stages - 1])) && (known_ = stages, true);
  }
  void interpolate(Scalar x, Scalar dt, const Plain& y0, const Plain&, Plain& out) const {
    RungeKuttaInterpolant<Tableau>::template at<S>(x, dt, y0, k_.all(), out);
  }
  void forget() { known_ = 0; }

 private:
  template <std::size_t i>
  using Row = TableRow<Tableau::a, i, i>;

  /// (1) of stage i: where a k before it isn't finite, neither is Y_i, and the force is not called.
  template <std::size_t i, class Rhs>
  [[nodiscard]] bool stage(Rhs& rhs, Scalar t, Scalar dt, const Plain& y, Plain& Y) {
    if (!move<i>(dt, y, Y)) return false;
    return k_.evaluate(rhs, i, t + static_cast<Scalar>(Tableau::c[i]) * dt, Y);
  }
  /// out = y + Δt Σ_j a_ij k_j, by (3) for r. False: it isn't finite.
  template <std::size_t i>
  [[nodiscard, gnu::always_inline]] inline bool move(Scalar dt, const Plain& y, Plain& out) const {
    if constexpr (solved_blocks<S> == 1) return move_block<i, 0>(dt, y, out);  // g++ inlines it so
    return [&]<std::size_t... k>(std::index_sequence<k...>) {
      bool finite = true;
      ((finite = move_block<i, k>(dt, y, out) && finite), ...);
      return finite;
    }
    (std::make_index_sequence<solved_blocks<S>>{});
  }
  template <std::size_t i, std::size_t k>
  [[nodiscard, gnu::always_inline]] inline bool move_block(Scalar dt, const Plain& y, Plain& out) const {
    using Drifted = OfPositions<Tableau, Row<i>>;
    const Scalar drift = static_cast<Scalar>(Tableau::c[i]) * dt, kick = dt * dt;
    const auto& from = std::get<k>(Blocks<S>::solved(y));
    auto&& to = std::get<k>(Blocks<S>::solved(out));
    if constexpr (FieldState<S>) {
      if constexpr (drifts && k == 0)
        position_of<S>(out) = position_of<S>(y) + drift * from + k_.template field_sum<Drifted, k>(kick);
      to = from + k_.template field_sum<Row<i>, k>(dt);
      return is_finite_block(to);
    } else {
      constexpr int size = Stages::template size_of<decltype(to)>;
      const Input<Scalar> start{from.data()};
      const auto solved = [=, sum = k_.template sum<Row<i>, k>()](auto n)
                              PHISTEP_DETAIL_INLINED { return moved<i == end>(start[n], dt, sum, n); };
      if constexpr (drifts && k == 0) {
        const Input<Scalar> r{position_of<S>(y).data()};
        const auto kernel = [=, sum = k_.template sum<Drifted, k>()](auto n, auto& r1, auto& v1)
                                PHISTEP_DETAIL_INLINED {
                                  r1 = r[n] + moved<false>(drift * start[n], kick, sum, n);
                                  v1 = solved(n);
                                };
        return update_block<size>(to.size(), kernel, position_of<S>(out).data(), to.data());
      } else {
        const auto kernel = [=](auto n, auto& y1) PHISTEP_DETAIL_INLINED { y1 = solved(n); };
        return update_block<size>(to.size(), kernel, to.data());
      }
    }
  }
  /// x + h Σ_j w_j k_j: at the step's end with one rounding of x.
  template <bool at_end>
  [[nodiscard, gnu::always_inline]] static auto moved(auto x, Scalar h, const auto& sum, auto n) {
    if constexpr (std::remove_cvref_t<decltype(sum)>::is_empty) return x;
    else if constexpr (at_end) return x + h * sum(n);
    else return sum.add_to(x, h, n);
  }

  Stages k_;
  Plain inside_;           // scratch of know_inside
  Scalar t_{0};            // [time] where the step started
  std::size_t known_ = 0;  // so many of the k_j belong to the step done last
};

}}  // namespace phistep::PHISTEP_ABI

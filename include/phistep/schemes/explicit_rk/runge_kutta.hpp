/// @file
/// Explicit Runge-Kutta pairs, for M y' = Ψ(t, y) and for motion under any force, f(r, v, t) included:
///
///     Y_i = y + Δt Σ_{j<i} a_ij k_j,    k_i = M⁻¹Ψ(t + c_i Δt, Y_i)                                              (1)
///     y⁺  = y + Δt Σ b_j k_j                                                                                    (2)
///     e   = Δt Σ (b_j − b̂_j) k_j                                                                                (3)
///
/// (Hairer, Nørsett & Wanner, Solving ODEs I, sect. II.4, II.5; the pairs themselves are in runge_kutta_tableaus.hpp.) The step
/// goes on with the formula of higher order, e is the error of the lower one. A pair with two of these, e₅ and e₃ of orders 5 and
/// 3, has the estimate ‖e₅‖²/√(‖e₅‖² + 0.01 ‖e₃‖²), which goes as Δt⁸ (eq. II.10.17).
///
/// The slope of a motion's r is v, at stage j the sum (1) of the k: r needs no slopes of its own,
///
///     r_i = r + c_i Δt v + Δt² Σ_l (Σ_j a_ij a_jl) k_l                                                          (4)
///
/// (sect. II.14, eq. 14.5).
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <type_traits>
#include <utility>

#include "phistep/core/outcome.hpp"
#include "phistep/core/scheme_facts.hpp"
#include "phistep/core/version.hpp"
#include "phistep/schemes/acceleration.hpp"
#include "phistep/schemes/explicit_rk/runge_kutta_interpolant.hpp"
#include "phistep/schemes/explicit_rk/runge_kutta_tableaus.hpp"
#include "phistep/schemes/scheme_on.hpp"
#include "phistep/schemes/weighted_sum.hpp"
#include "phistep/state/blocks.hpp"
#include "phistep/state/unknowns.hpp"

namespace phistep::inline PHISTEP_ABI {

/// An explicit pair as a scheme. @tparam Tableau  Tsit5 or Dop853
template <class Tableau>
struct RungeKutta {
  static constexpr SchemeFacts facts = ExplicitOfAny{.energy = EnergyBalance::rest};
  [[nodiscard]] static constexpr int order() { return Tableau::order; }
  [[nodiscard]] static constexpr const char* name() { return Tableau::name; }
};

/// Order 5, six force calls a step: smooth problems that are not stiff, at 2 to 6 digits.
inline constexpr RungeKutta<Tsit5> tsit5{};
/// Order 8, twelve force calls a step: smooth problems that are not stiff, at 6 digits and more.
inline constexpr RungeKutta<Dop853> dop853{};

/// Weights of the k_j, as types, so that sums are unrolled, and zeros are left out.
namespace runge_kutta {
template <class Tableau, std::size_t i>
using Stage = TableRow<Tableau::a, i, i>;
/// b_j − b̂_j
template <class Tableau>
struct Error {
  static constexpr std::size_t count = std::size(Tableau::e);
  static constexpr long double at(std::size_t j) { return Tableau::e[j]; }
};
/// The same for the formula of order 3.
template <class Tableau>
struct ErrorOfOrder3 {
  static constexpr std::size_t count = Tableau::end;
  static constexpr long double at(std::size_t j) { return Tableau::a[Tableau::end][j] - Tableau::b_3[j]; }
};
/// (4): the weights of the k_l where those of the slopes are w_j.
template <class Tableau, class Weights>
struct OfPositions {
  static constexpr std::size_t count = Weights::count == 0 ? 0 : Weights::count - 1;
  static constexpr long double at(std::size_t l) {
    long double sum = 0;
    for (std::size_t j = l + 1; j < Weights::count; ++j) sum += Weights::at(j) * Tableau::a[j][l];
    return sum;
  }
};
}  // namespace runge_kutta

template <class Tableau, State S>
class SchemeOn<RungeKutta<Tableau>, S> : public SchemeDefaults {
  static constexpr std::size_t end = Tableau::end, stages = Tableau::stages;
  static constexpr bool drifts = Blocks<S>::drifts;

 public:
  using Scalar = ScalarOf<S>;
  using Plain = PlainState<S>;
  using Rate = RateOf<S>;
  template <class Rhs>
  static constexpr KernelNeeds needs{.position = false};

  SchemeOn(RungeKutta<Tableau>, const Plain& y) { resize(y); }
  void resize(const Plain& y) {
    k_.fill(make_rate<S>(y));
    inside_ = y;
    known_ = 0;
  }
  [[nodiscard]] static int order() { return Tableau::order; }
  /// The power of Δt in the estimate.
  [[nodiscard]] static int error_order() { return Tableau::error_order; }

  static constexpr bool traces = true;
  static constexpr bool has_two_estimates = requires { Tableau::b_3; };
  static constexpr bool reads_weights = has_two_estimates;
  [[nodiscard]] static bool estimates(const auto&) { return true; }

  template <class Kernel, class Step>
  [[nodiscard]] Outcome step(Kernel& kernel, Step& step) {
    known_ = 0;
    t_ = step.t;
    if (const Outcome bad = start(kernel, step); failed(bad)) return bad;
    const bool arrived = [&]<std::size_t... i>(std::index_sequence<i...>) {
      return (stage<i + 1>(kernel.rhs(), step.t, step.dt, step.y, step.next) && ...);
    }
    (std::make_index_sequence<end - 1>{}) && move<end>(step.dt, step.y, step.next);
    if (!arrived) {
      blame(step.psi);
      return Outcome::non_finite_state;
    }
    known_ = end;
    if constexpr (Step::is_traced) return slopes_and_error(kernel.rhs(), step);
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
    copy_blocks<S>(inside_, y0);  // what a view of the whole state shares
    return [&]<std::size_t... i>(std::index_sequence<i...>) {
      return ((known_ > end + i || stage<end + i>(rhs, t_, dt, y0, inside_)) && ...);
    }
    (std::make_index_sequence<stages - end>{}) && all_finite(Rate::blocks(k_[stages - 1])) && (known_ = stages, true);
  }
  void interpolate(Scalar x, Scalar dt, const Plain& y0, const Plain&, Plain& out) const {
    RungeKuttaInterpolant<Tableau>::template at<S>(x, dt, y0, k_, out);
  }
  void forget() { known_ = 0; }

 private:
  template <std::size_t i>
  using Row = runge_kutta::Stage<Tableau, i>;
  template <class Weights>
  using OfPositions = runge_kutta::OfPositions<Tableau, Weights>;

  /// k_0 = M⁻¹Ψ(t, y), where it isn't known a force call
  template <class Step>
  [[nodiscard]] Outcome start(auto& kernel, Step& step) {
    if constexpr (Step::is_traced) {
      if (const Outcome bad = kernel.start(step); failed(bad)) return bad;
      for_each_block([](auto, auto& k, const auto& slope) { k = slope; }, Rate::blocks(k_[0]),
                     Blocks<S>::solved(step.trace.start));
      return Outcome::success;
    } else {
      kernel.rhs().evaluate_into(step.t, step.y, k_[0]);
      if (accelerate(kernel.rhs(), k_[0])) return Outcome::success;
      step.psi = k_[0];
      return Outcome::non_finite_force;
    }
  }
  /// (1) of stage i: where a k before it isn't finite, neither is Y_i, and the force is not called.
  template <std::size_t i, class Rhs>
  [[nodiscard]] bool stage(Rhs& rhs, Scalar t, Scalar dt, const Plain& y, Plain& Y) {
    if (!move<i>(dt, y, Y)) return false;
    rhs.evaluate_into(t + static_cast<Scalar>(Tableau::c[i]) * dt, Y, k_[i]);
    return accelerate(rhs, k_[i]);
  }
  /// The slope at the end where it is wanted, and (3)
  [[nodiscard]] Outcome slopes_and_error(auto& rhs, auto& step) {
    auto& trace = step.trace;
    constexpr bool estimate_asks = runge_kutta::Error<Tableau>::count > end;
    if (estimate_asks || trace.wants_dense) {
      rhs.evaluate_into(step.t + step.dt, step.next, k_[end]);
      if (!accelerate(rhs, k_[end]) || !all_finite(Rate::blocks(k_[end]))) {
        step.psi = k_[end];
        return Outcome::non_finite_force;
      }
      known_ = end + 1;
      for_each_block([](auto, auto& slope, const auto& k) { slope = k; }, Blocks<S>::solved(trace.end),
                     Rate::blocks(std::as_const(k_[end])));
      if constexpr (drifts) position_of<S>(trace.end) = velocity_of<S>(step.next);
      trace.has_slopes = true;
    }
    const Scalar dt = step.dt;
    double high = 0, low = 0;  // squares of ‖e₅‖ and ‖e₃‖
    const auto of_block = [&]<class Weights, class Low, std::size_t k>(Scalar by, auto& e, auto& e3,
                                                                       const auto& weight) {
      const auto put = [by](auto weights, auto& to) {
        const auto kernel = [by, weights](auto i, auto& x) { x = by * weights(i); };
        // Where it isn't finite, the norm of it will tell.
        static_cast<void>(update_block<size_of<decltype(to)>>(to.size(), kernel, to.data()));
      };
      put(sum<Weights, k>(), e);
      if constexpr (has_two_estimates) {
        put(sum<Low, k>(), e3);
        for (Index i = 0; i < e.size(); ++i) {
          high += square(weight.data()[i] * e.data()[i]);
          low += square(weight.data()[i] * e3.data()[i]);
        }
      }
    };
    using High = runge_kutta::Error<Tableau>;
    using Low = typename decltype(low_weights())::type;
    for_each_block(
        [&](auto k, auto& e, auto& e3, const auto& weight) {
          of_block.template operator()<High, Low, k>(dt, e, e3, weight);
          if constexpr (drifts && k == 0)
            of_block.template operator()<OfPositions<High>, OfPositions<Low>, k>(
                dt * dt, position_of<S>(trace.error), position_of<S>(trace.predicted), position_of<S>(trace.weight));
        },
        Blocks<S>::solved(trace.error), Blocks<S>::solved(trace.predicted), Blocks<S>::solved(trace.weight));
    if (high > 0) trace.error_scale = 1 / std::sqrt(1 + 0.01 * (low / high));
    trace.has_error = true;
    return Outcome::success;
  }
  [[nodiscard]] static double square(Scalar x) { return static_cast<double>(x) * static_cast<double>(x); }
  [[nodiscard]] static auto low_weights() {
    if constexpr (has_two_estimates) return std::type_identity<runge_kutta::ErrorOfOrder3<Tableau>>{};
    else return std::type_identity<runge_kutta::Error<Tableau>>{};
  }
  /// out = y + Δt Σ_j a_ij k_j, by (4) for r. False: it isn't finite.
  template <std::size_t i>
  [[nodiscard]] bool move(Scalar dt, const Plain& y, Plain& out) const {
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
    auto&& to = std::get<k>(Blocks<S>::solved(out));
    constexpr int size = size_of<decltype(to)>;
    const Input<Scalar> start{std::get<k>(Blocks<S>::solved(y)).data()};
    const auto solved = [=, sum = sum<Row<i>, k>()](auto n) { return moved<i == end>(start[n], dt, sum, n); };
    if constexpr (drifts && k == 0) {
      const Input<Scalar> r{position_of<S>(y).data()};
      const Scalar drift = static_cast<Scalar>(Tableau::c[i]) * dt, kick = dt * dt;
      const auto kernel = [=, sum = sum<OfPositions<Row<i>>, k>()](auto n, auto& r1, auto& v1) {
        r1 = r[n] + moved<false>(drift * start[n], kick, sum, n);
        v1 = solved(n);
      };
      return update_block<size>(to.size(), kernel, position_of<S>(out).data(), to.data());
    } else {
      const auto kernel = [=](auto n, auto& y1) { y1 = solved(n); };
      return update_block<size>(to.size(), kernel, to.data());
    }
  }
  /// x + h Σ_j w_j k_j: at the step's end with one rounding of x.
  template <bool at_end>
  [[nodiscard, gnu::always_inline]] static auto moved(auto x, Scalar h, const auto& sum, auto n) {
    if constexpr (std::remove_cvref_t<decltype(sum)>::is_empty) return x;
    else if constexpr (at_end) return x + h * sum(n);
    else return sum.add_to(x, h, n);
  }
  template <class Weights, std::size_t k>
  [[nodiscard]] auto sum() const {
    return WeightedSum<Weights, Rate, false, k>{k_};
  }
  template <class Block>
  static constexpr int size_of = std::remove_cvref_t<Block>::SizeAtCompileTime;
  /// psi: kept for the failure message: the first k that isn't finite.
  [[gnu::cold, gnu::noinline]] void blame(Rate& psi) const {
    psi = k_[0];
    for (const Rate& k : k_)
      if (first_non_finite(Rate::blocks(k))) {
        psi = k;
        return;
      }
  }

  std::array<Rate, stages> k_;
  Plain inside_;           // scratch of know_inside
  Scalar t_{0};            // [time] where the step started
  std::size_t known_ = 0;  // so many of the k_j belong to the step done last
};

}  // namespace phistep::inline PHISTEP_ABI

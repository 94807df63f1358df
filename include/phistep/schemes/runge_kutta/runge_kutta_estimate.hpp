/// @file
/// The error estimate of an explicit Runge-Kutta pair, of the formulas of order p and p̂,
///
///     e = Δt Σ (b_j − b̂_j) k_j                                                                                  (1)
///
/// A pair with two of these, e₅ and e₃ of orders 5 and 3, has the estimate ‖e₅‖²/√(‖e₅‖² + 0.01 ‖e₃‖²), which goes as Δt⁸
/// (Hairer, Nørsett & Wanner, Solving ODEs I, eq. II.10.17). Where Ψ jumps, e₅ may vanish by chance, and
/// its square with it: the estimate is at least 0.03 ‖e₃‖², errors relative to y, which goes as Δt⁸, too, and rules few
/// smooth steps; where e₃ doesn't go as Δt⁴, it is at least 0.1 ‖e₃‖. That of a motion's r follows from the k, too: its
/// slopes are the velocities of the stages (eq. II.14.5).
///
/// Of few digits e may fall behind: in y' = cos ωt, tsit5's error is 0.1 |e| at ωΔt = 1, 0.3 at 2, 1.1 at 4 and 3 at 6.3, where
/// a tolerance of 1e-3 leads; of hundreds of such steps the errors add up. Above an rtol of `sure_to` ‖e‖² is taken
/// rtol/`sure_to` times, which keeps the error at a fifth of what is allowed (dop853's is 0.02 to 0.14 |e|). Steps that skip
/// whole periods show by ‖e‖ beside Δt ‖k⁺ − k‖: 2e-4 of it at 2, 3e-3 at 4, and up to all of it farther on.
#pragma once

#include <algorithm>
#include <cstddef>
#include <iterator>
#include <type_traits>

#include "phistep/base/machine/loop_hints.hpp"
#include "phistep/base/numbers/pack.hpp"
#include "phistep/base/state/blocks.hpp"
#include "phistep/base/state/ranks.hpp"
#include "phistep/base/state/unknowns.hpp"
#include "phistep/schemes/explicit_stages.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// The weights of the k_l in a sum over a motion's velocities, with weights w_j: Σ_j w_j a_jl.
template <class Tableau, class Weights>
struct OfPositions {
  static constexpr std::size_t count = Weights::count == 0 ? 0 : Weights::count - 1;
  static constexpr long double at(std::size_t l) {
    long double sum = 0;
    for (std::size_t j = l + 1; j < Weights::count; ++j) sum += Weights::at(j) * Tableau::a[j][l];
    return sum;
  }
};

/// @tparam Tableau  has the error's weights e, and b_3 where it has two estimates
template <class Tableau, State S>
class RungeKuttaEstimate {
  using Scalar = ScalarOf<S>;
  using Stages = ExplicitStages<S, Tableau::stages>;
  // Weights of the k_j, as types, so that sums are unrolled, and zeros are left out.
  using High = TableRow<Tableau::e, 0, std::size(Tableau::e[0])>;  // b_j − b̂_j
  /// k⁺ − k
  struct Change {
    static constexpr std::size_t count = Tableau::end + 1;
    static constexpr long double at(std::size_t j) { return j == 0 ? -1 : j == Tableau::end ? 1 : 0; }
  };

 public:
  static constexpr bool has_two = requires { Tableau::b_3; };
  static constexpr bool needs_end = High::count > Tableau::end;  ///< the estimate uses k⁺

  /// Error and, of two estimates, its factor.
  [[gnu::always_inline]] static void tell(const Stages& k, Scalar dt, auto& trace) {
    using Low = typename decltype(low_weights())::type;
    Squares all;
    for_each_block(
        [&](auto block, auto& e, auto& e3, const auto& weight) {
          of_block<High, Low, block>(k, dt, e, e3, weight, all);
          if constexpr (Blocks<S>::drifts && block == 0)
            of_block<OfPositions<Tableau, High>, OfPositions<Tableau, Low>, block>(
                k, dt * dt, position_of<S>(trace.error), position_of<S>(trace.predicted), position_of<S>(trace.weight),
                all);
        },
        Blocks<S>::solved(trace.error), Blocks<S>::solved(trace.predicted), Blocks<S>::solved(trace.weight));
    if constexpr (has_two && FieldState<S>) {
      double sums[] = {all.high, all.low};
      total_of_ranks(trace.weight, sums);
      all = {sums[0], sums[1]};
    }
    if (all.high > 0) {
      trace.error_scale_square = all.high / (all.high + 0.01 * all.low);
      if constexpr (has_two) {
        const double least = 0.03 * trace.rtol * all.low;
        const auto n = static_cast<double>(count_of(Blocks<S>::all(trace.error)));
        trace.error_scale_square = std::max(trace.error_scale_square, least / n * (least / all.high));
        if (!trace.smoothness.holds(all.low, static_cast<double>(dt), order_of_low))
          trace.error_scale_square = std::max(trace.error_scale_square, 0.01 * all.low / all.high);
      }
    }
    trace.has_error = true;
  }
  /// The factor of few digits. @param eq  of the step
  [[gnu::noinline]] static void doubt_few_digits(const Stages& k, auto& eq) requires requires { Tableau::sure_to; }
  {
    auto& trace = eq.trace;
    trace.error_scale_square = trace.rtol / Tableau::sure_to;
    auto& change = trace.predicted;
    for_each_block(
        [&](auto block, auto& to) {
          k.template put<Change, block>(eq.dt, to);
          if constexpr (Blocks<S>::drifts && block == 0)
            k.template put<OfPositions<Tableau, Change>, block>(eq.dt * eq.dt, position_of<S>(change));
        },
        Blocks<S>::solved(change));
    const double e = eq.size_of_error(), most = eq.size_of(change, eq.next);
    if (e > 2e-3 * most) trace.error_scale_square *= std::min(e / (2e-3 * most), 100.0);
  }

 private:
  static constexpr int order_of_low = 4;  ///< ‖e₃‖ goes as Δt⁴
  struct Squares {
    double high = 0, low = 0;  ///< of ‖e₅‖ and ‖e₃‖
  };
  [[nodiscard]] static auto low_weights() {
    if constexpr (!has_two) return std::type_identity<High>{};
    else
      return std::type_identity<DifferenceOfWeights<TableRow<Tableau::a, Tableau::end, Tableau::end>,
                                                    TableRow<Tableau::b_3, 0, Tableau::end>>>{};
  }
  template <class Upper, class Low, std::size_t block>
  [[gnu::always_inline]] static void of_block(const Stages& k, Scalar by, auto& e, auto& e3, const auto& weight,
                                              Squares& all) {
    constexpr int size = Stages::template size_of<decltype(e)>;
    if constexpr (!has_two || FieldState<S> || few_numbers(size) || !std::is_same_v<Scalar, double>) {
      k.template put<Upper, block>(by, e);
      if constexpr (has_two) {
        k.template put<Low, block>(by, e3);
        all.high += square(e, weight);
        all.low += square(e3, weight);
      }
    } else {  // the same in one pass
      PackSum<Scalar> high, low;
      const auto sum = k.template sum<Upper, block>();
      const auto sum3 = k.template sum<Low, block>();
      for_each_pack<Scalar>(e.size(), [&](auto i) PHISTEP_DETAIL_INLINED {
        const auto error = sum(i) * by, w = i(weight.data()), of = error * w, of3 = sum3(i) * by * w;
        error.store(e.data() + i.i);
        high.add(of * of);
        low.add(of3 * of3);
      });
      all.high += high.total();
      all.low += low.total();
    }
  }
  /// Σ (e_i w_i)²
  [[nodiscard, gnu::always_inline]] static inline double square(const auto& e, const auto& weight) {
    if constexpr (FieldState<S>) return std::remove_cvref_t<decltype(e)>::Ops::square(e.handle(), weight.handle());
    double sum = 0;
    if constexpr (!FieldState<S>)
      for (Index i = 0; i < e.size(); ++i) {
        const auto x = static_cast<double>(weight.data()[i] * e.data()[i]);
        sum += x * x;
      }
    return sum;
  }
};

}}  // namespace phistep::PHISTEP_ABI

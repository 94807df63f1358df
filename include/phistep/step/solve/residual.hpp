/// @file
/// The residual of a resolve at its iterate,
///
///     F(Y) = γ_f Ψ(t, Y) − M w,     w = Y − b
///
/// and how much of it rounding can account for.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>
#include <utility>

#include "phistep/base/numbers/arithmetic.hpp"
#include "phistep/base/outcome/outcome.hpp"
#include "phistep/base/state/blocks.hpp"
#include "phistep/base/state/reductions.hpp"
#include "phistep/base/state/unknowns.hpp"
#include "phistep/step/equation/explicit_update.hpp"
#include "phistep/step/solve/increment.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

template <State S, class Rhs>
struct Residual {
  using Scalar = ScalarOf<S>;
  using Plain = PlainState<S>;
  using Rate = RateOf<S>;

  Rhs& rhs;
  const Gamma<Scalar>& gamma;
  const Scalar t;  ///< [time]
  Rate& psi;       ///< Ψ at the iterate evaluated last
  bool knows_psi;  ///< that is where the iteration starts
  Increment<S>& increment;

  /// F in increment.delta, with Ψ by a force call.
  void evaluate(const Plain& Y) {
    if (!std::exchange(knows_psi, false)) rhs.evaluate_into(t, Y, psi);
    assemble();
  }
  /// Whether it is finite; of fields a reduction or two.
  [[nodiscard]] Outcome check() const {
    if (is_finite_block(F())) return Outcome::success;
    return first_non_finite(Rate::blocks(psi)) ? Outcome::non_finite_force : Outcome::non_finite_state;
  }
  /// F with the Ψ at hand.
  void assemble() {
    for_each_rate([this](Index at, const auto& rate, const auto& mass) {
      auto&& out = part(F(), at, rate);
      out = gamma.force * flat(rate);
      mass.subtract_product(part(increment.w, at, rate), out);
    });
  }
  /// ‖M⁻¹F‖, by components; ‖F‖ under a matrix mass.
  [[nodiscard]] double residual_size() const {
    if constexpr (FieldState<S>) return largest(F()) / static_cast<double>(std::get<0>(rhs.masses())[0]);
    else return size_of_numbers();
  }
  /// No larger than what rounding leaves of γ_f Ψ − M w where both cancel.
  [[nodiscard]] bool residual_is_rounding() const {
    bool rounding = true;
    for_each_rate([&](Index at, const auto& rate, const auto&) {
      rounding = rounding && largest(part(F(), at, rate)) <= 8 * round_off * force_size(rate);
    });
    return rounding;
  }
  /// The size of what F is made of: W times all that it is made for, and the force.
  /// @param magnitude, drift_share  the system's ‖W‖ and ‖γ_f γ_d K‖ / ‖W‖
  [[nodiscard]] double all_terms(const Plain& Y, const Plain& guess, double magnitude, double drift_share) const {
    // The start counts, too: where Y is far smaller, the rounding of start + δ is what is left.
    double size = std::max({static_cast<double>(least_normal<Scalar>),  // below, rounding doesn't shrink any more
                            largest(increment.base), increment.drift_size(Y, drift_share),
                            increment.drift_size(guess, drift_share)});
    for_each_solved<S>(
        [&size](Index, const auto& y, const auto& start) {
          size = std::max({size, largest(y), largest(start)});
        },
        Y, guess);
    double all = magnitude * size;
    for_each_rate([&](Index, const auto& rate, const auto&) { all = std::max(all, force_size(rate)); });
    return all;
  }

 protected:
  [[nodiscard]] auto& F() const { return increment.delta; }

 private:
  static constexpr double round_off = static_cast<double>(std::numeric_limits<Scalar>::epsilon());

  [[nodiscard]] double force_size(const auto& rate) const {
    return std::abs(static_cast<double>(gamma.force)) * largest(rate);
  }
  [[nodiscard]] double size_of_numbers() const {
    const auto each = [&](auto&& f) {
      for_each_rate([&](Index at, const auto& rate, const auto& mass) {
        const auto inverse_mass = mass.h_over_mass(Scalar{1});
        for (Index i = 0; i < rate.size(); ++i) f(std::abs(static_cast<double>(inverse_mass(i) * F()[at + i])));
      });
    };
    double most = 0, sum = 0;
    each([&](double x) { most = std::max(most, x); });
    if (most > 0) each([&](double x) { sum += (x / most) * (x / most); });  // squares of velocities may leave the range
    return most * std::sqrt(sum);
  }
  void for_each_rate(auto&& f) const { for_each_part(f, Rate::blocks(std::as_const(psi)), rhs.masses()); }
};

}}  // namespace phistep::PHISTEP_ABI

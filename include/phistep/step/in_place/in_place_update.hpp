/// @file
/// The explicit update of a step that is one pass, written straight into the state, and still all or nothing:
///
///     a state of the library's own memory   in place, once it is certain that no result can overflow
///     a view of the caller's                into the caller's places; what was gathered from them is the way back
///
/// Beside the state and commit by swap costs a second set of arrays in the caches: 1.7 to 1.9 × an unguarded loop in place,
/// against 1.4 × here (1e3 and 1e4 particles, AVX-512). Certainty costs one read of Ψ: the bounds on r and v are taken by a
/// read once, then grow by what each step can add, |v⁺| ≤ |v| + |γ/m| |Ψ| and |r⁺| ≤ |r| + |before| |v| + |after| |v⁺|.
/// A step by hand is done beside the state: to read r, v and Ψ first costs more (2.1 ×).
#pragma once

#include <Eigen/Core>

#include <algorithm>
#include <array>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <limits>
#include <tuple>
#include <type_traits>
#include <utility>

#include "phistep/base/machine/loop_hints.hpp"
#include "phistep/base/numbers/pack.hpp"
#include "phistep/base/numbers/pack_math.hpp"
#include "phistep/base/numbers/update.hpp"
#include "phistep/base/state/blocks.hpp"
#include "phistep/base/state/copy_views.hpp"
#include "phistep/step/equation/explicit_update.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// Σ|x|: at least the largest of n magnitudes, not finite where one of them isn't. It may be infinite though all are finite.
///
/// A sum keeps a NaN to the end; a maximum, which costs the same, forgets it. Four sums: one waits for its own last addition.
template <std::floating_point Scalar>
[[nodiscard]] Scalar sum_of_magnitudes(const Scalar* x, std::ptrdiff_t n) {
  using P = Pack<Scalar, native_width<Scalar>>;
  constexpr std::ptrdiff_t width = P::width;
  P sums[4] = {0, 0, 0, 0};
  std::ptrdiff_t i = 0;
  for (; i + 4 * width <= n; i += 4 * width) unrolled<4>([&](auto k) { sums[k] += abs(P::load(x + i + k * width)); });
  Scalar rest = 0;
  for (; i < n; ++i) rest += std::abs(x[i]);
  return sum((sums[0] + sums[1]) + (sums[2] + sums[3])) + rest;
}

template <State S, class Rhs>
class InPlaceUpdate {
 public:
  using Scalar = ScalarOf<S>;
  using Plain = PlainState<S>;

  void forget() { knows_bounds_ = false; }
  /// A step of `place` begins, or several; null where they must stay beside the state.
  /// @param unedited  it is what the last step left
  void begin(S* place, bool unedited) {
    place_ = place;
    unedited_ = unedited;
    // A step that fails, throws or isn't done here leaves bounds that have to be computed again.
    bounds_hold_ = std::exchange(knows_bounds_, false) && unedited;
  }
  /// All are done.
  void end() { knows_bounds_ = bounds_hold_; }
  /// True: the state is y + γ M⁻¹Ψ, and finite. False: nothing has changed, and the step has to be done beside it.
  /// @param y  the state, or what was gathered from it
  [[nodiscard]] bool advance(const Rhs& rhs, const Plain& y, const auto& by, const auto& psi) {
    if (place_ == nullptr) return false;
    if constexpr (!is_owned) {
      if (write_through(rhs, y, by, psi)) return true;
      copy_views<S>(*place_, y);
      return false;
    } else {
      const bool bounds_hold = std::exchange(bounds_hold_, false);
      // Two sets of short arrays fit the innermost cache anyway (crossover measured: 100 particles). Past the caches all
      // that counts is how many bytes move: beside the state Ψ is read once.
      const Index n = std::get<drifting>(Blocks<S>::all(y)).size();
      if (!unedited_ || n < 300) return false;
      if (PHISTEP_DETAIL_STREAMS != 0 && n >= stream_from() / static_cast<Index>(sizeof(Scalar))) return false;
      if (!bounds_hold) measure(rhs, y);
      if (!excludes_overflow(by, psi)) return false;
      for_each_update<S>(
          y, by, psi, rhs.masses(),
          [](const auto& kernel, auto& to, auto&... position) {
            update_in_place_unwatched(to.size(), kernel, to.data(), position.data()...);
          },
          *place_);
      return bounds_hold_ = true;
    }
  }

 private:
  static constexpr bool is_owned = std::is_same_v<S, Plain>;
  static constexpr std::size_t blocks = std::tuple_size_v<decltype(Blocks<S>::all(std::declval<Plain&>()))>;
  static constexpr std::size_t drifting = Blocks<S>::drifts ? 1 : 0;

  void measure(const Rhs& rhs, const Plain& y) {
    for_each_block([this](auto k, const auto& x) { largest_[k] = sum_of_magnitudes(x.data(), x.size()); },
                   Blocks<S>::all(y));
    for_each_block(
        [this](auto k, const auto& x, const auto& mass) {
          Scalar& most = largest_inverse_mass_[k] = 0;
          const auto inverse = mass.h_over_mass(Scalar{1});
          for (Index i = 0; i < x.size(); ++i) most = std::max(most, std::abs(static_cast<Scalar>(inverse(i))));
        },
        Blocks<S>::solved(y), rhs.masses());
  }
  /// Moves the bounds on |r| and |v| to the end of the step. False where they no longer exclude an overflow.
  [[nodiscard]] bool excludes_overflow(const auto& by, const auto& psi) {
    constexpr Scalar rounding = 1 + 16 * std::numeric_limits<Scalar>::epsilon();
    bool excluded = true;
    const auto grow = [&excluded](Scalar& bound, Scalar more) {
      bound = rounding * (bound + more);
      excluded = excluded && bound <= std::numeric_limits<Scalar>::max() / 8;  // false for a NaN
    };
    for_each_block(
        [&](auto k, const auto& rate) {
          Scalar& v = largest_[k + drifting];
          const Scalar before = v;
          grow(v, std::abs(by.kick) * largest_inverse_mass_[k] * sum_of_magnitudes(rate.data(), rate.size()));
          if constexpr (drifting == 1 && k == 0)
            grow(largest_[0],
                 std::abs(static_cast<Scalar>(by.before)) * before + std::abs(static_cast<Scalar>(by.after)) * v);
        },
        psi);
    return excluded;
  }

  /// False: something isn't finite (or the layout isn't served), and some places are written.
  [[nodiscard]] bool write_through(const Rhs& rhs, const Plain& y, const auto& by, const auto& psi) {
    bool finite = true;
    for_each_update<S>(
        y, by, psi, rhs.masses(),
        [&finite](const auto& kernel, auto&... to) { finite = finite && write(kernel, to...); }, *place_);
    return finite;
  }
  template <class Kernel>
  [[nodiscard]] static bool write(const Kernel& kernel, auto& to, auto&... more) {
    using View = std::remove_cvref_t<decltype(to)>;
    if (is_contiguous(to) && (is_contiguous(more) && ...)) return update(to.size(), kernel, to.data(), more.data()...);
    constexpr bool is_vector = View::IsVectorAtCompileTime;
    constexpr Index rows = is_vector ? 1 : Index{View::RowsAtCompileTime}, chunk = 512;
    if constexpr ((!is_vector && View::IsRowMajor) || rows < 1 || rows > 64) return false;
    else return write_chunks<rows, chunk / rows>(kernel, to, more...);
  }
  /// A chunk at a time passes through L1 on its way to places apart.
  template <Index rows, Index most, class Kernel, class... Views>
  [[nodiscard]] static bool write_chunks(const Kernel& kernel, Views&... to) {
    const Index all = std::max({outer_parts(to)...});
    for (Index i = 0; i < all; i += most) {
      const Index n = std::min(most, all - i);
      Scalar results[sizeof...(Views)][static_cast<std::size_t>(rows * most)];
      const auto shifted = [&kernel, first = i * rows](auto j, auto&... x) { kernel(j + first, x...); };
      const bool finite = [&]<std::size_t... k>(std::index_sequence<k...>) {
        if (!update_in_place(n * rows, shifted, results[k]...)) return false;
        (put(outer_part(to, i, n), results[k]), ...);
        return true;
      }
      (std::index_sequence_for<Views...>{});
      if (!finite) return false;
    }
    return true;
  }
  static void put(auto&& part, const Scalar* numbers) {
    using Numbers = typename std::remove_cvref_t<decltype(part)>::PlainObject;
    part = Eigen::Map<const Numbers>(numbers, part.rows(), part.cols());
  }
  S* place_ = nullptr;  // during a step
  bool unedited_ = false, bounds_hold_ = false;
  bool knows_bounds_ = false;                                     // for the next call
  std::array<Scalar, blocks> largest_{};                          // no number of a block is larger
  std::array<Scalar, blocks - drifting> largest_inverse_mass_{};  // [1/mass]
};

}}  // namespace phistep::PHISTEP_ABI

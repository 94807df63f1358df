/// @file
/// Ψ(t+Δt) of one step may serve as Ψ(t) of the next, unless the state was edited in between, which the guard detects.
#pragma once

#include <Eigen/Core>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <tuple>
#include <type_traits>

#include "phistep/core/version.hpp"
#include "phistep/simd/fingerprint.hpp"
#include "phistep/state/blocks.hpp"

namespace phistep::inline PHISTEP_ABI {

/// Whether Ψ at a time serves at another: t₀ + (n+1)Δt and (t₀ + nΔt) + Δt differ in their last bits; Ψ doesn't care.
template <bool uses_time, class Scalar>
[[nodiscard]] bool same_time(Scalar t, Scalar known) {
  if constexpr (!uses_time) return true;
  else
    return std::abs(t - known) <= 8 * std::numeric_limits<Scalar>::epsilon() * std::max(std::abs(t), std::abs(known));
}

/// Remembers at which (t, y) a force was last evaluated, by y's bits: a small fixed state's own, a large one's fingerprint.
/// With `position_only`, for forces that see r alone, edits of v do no harm and are not looked for.
template <State S, bool position_only, bool uses_time>
class EditGuard {
 public:
  using Scalar = ScalarOf<S>;
  using Plain = PlainState<S>;

  EditGuard() {
    // A copied stepper copies this: it must not read what was never written.
    if constexpr (by_value) set_zero(Blocks<S>::all(last_));
  }

  void forget() { kind_ = Kind::nothing; }

  /// Ψ is known at (t, y), and the caller vouches that the next step starts from y (see `holds_unedited`).
  void remember_unchecked(Scalar t) {
    t_ = t;
    kind_ = Kind::vouched;
  }
  /// Ψ is known at (t, y).
  void remember(Scalar t, const Plain& y) {
    t_ = t;
    kind_ = Kind::checked;
    if constexpr (by_value) copy_blocks<S>(last_, y);
    else last_ = hash(y);
  }
  [[nodiscard]] bool holds(Scalar t, const Plain& y) const {
    if (kind_ != Kind::checked || !same_time<uses_time>(t, t_)) return false;
    if constexpr (FieldState<S>) return all_ranks(y, hash(y) == last_);  // an edit on one is an edit
    else if constexpr (!by_value) return hash(y) == last_;
    else if constexpr (position_only)
      return equal_bits(std::get<0>(Blocks<S>::all(y)), std::get<0>(Blocks<S>::all(last_)));
    else return equal_blocks<S>(y, last_);
  }
  /// The same, on the caller's word that the state is what the last step left.
  [[nodiscard]] bool holds_unedited(Scalar t) const { return kind_ != Kind::nothing && same_time<uses_time>(t, t_); }

  /// For a checkpoint. After it the guard knows the saved state, by its bits, and no other.
  void archive(auto& ar) {
    ar("kind", kind_, "t", t_, "y", last_);
    ar.check(kind_ <= Kind::checked);
  }

 private:
  enum class Kind : std::uint8_t { nothing, vouched, checked };
  static constexpr int size = static_size<decltype(Blocks<S>::all(std::declval<Plain&>()))>;
  static constexpr bool by_value = size != Eigen::Dynamic && size <= 64;

  [[nodiscard]] static std::uint64_t hash(const Plain& y) {
    std::uint64_t all = 0;
    for_each_block(
        [&all](auto k, const auto& block) {
          if (position_only && k != 0) return;
          if constexpr (FieldBlock<decltype(block)>)
            all = std::rotl(all, 1) + std::remove_cvref_t<decltype(block)>::Ops::fingerprint(block.handle());
          else all = fingerprint(block.data(), block.size(), all);
        },
        Blocks<S>::all(y));
    return all;
  }

  std::conditional_t<by_value, Plain, std::uint64_t> last_{};
  Scalar t_{};
  Kind kind_ = Kind::nothing;
};

}  // namespace phistep::inline PHISTEP_ABI

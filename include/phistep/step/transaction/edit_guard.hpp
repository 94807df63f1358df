/// @file
/// Ψ(t+Δt) of one step may serve as Ψ(t) of the next, unless the state was edited in between, which the guard detects.
#pragma once

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <tuple>
#include <type_traits>
#include <utility>

#include "phistep/base/machine/memory.hpp"
#include "phistep/base/numbers/fingerprint.hpp"
#include "phistep/base/state/blocks.hpp"
#include "phistep/base/state/ranks.hpp"
#include "phistep/base/state/unknowns.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// Whether Ψ at a time serves at another: t₀ + (n+1)Δt and (t₀ + nΔt) + Δt differ in their last bits; Ψ doesn't care.
template <bool uses_time, class Scalar>
[[nodiscard]] bool same_time(Scalar t, Scalar known) {
  if constexpr (!uses_time) return true;
  else
    return std::abs(t - known) <= 8 * std::numeric_limits<Scalar>::epsilon() * std::max(std::abs(t), std::abs(known));
}

/// Remembers at which (t, y) a force was last evaluated, by y's bits: a small state's own, a large one's fingerprint.
/// With `position_only`, for forces that see r alone, edits of v do no harm and are not checked.
template <State S, bool position_only, bool uses_time>
class EditGuard {
 public:
  using Scalar = ScalarOf<S>;
  using Plain = PlainState<S>;

  EditGuard() {
    // A copied stepper copies this: it must not read what was never written.
    if constexpr (by_value) set_zero(Blocks<S>::all(last_));
  }

  /// Room for a copy of states like y, where that is sooner made and compared than a fingerprint taken.
  void reserve(const Plain& y) {
    if constexpr (may_keep) {
      has_room_ = count_of(seen(y)) <= most_kept;
      if (has_room_) kept_ = y;
    }
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
    else if (is_kept_ = has_room_; !is_kept_) last_ = hash(y);
    else if constexpr (may_keep)
      for_each_block([](auto, auto& to, const auto& from) { to = from; }, seen(kept_), seen(y));
  }
  [[nodiscard]] bool holds(Scalar t, const Plain& y) const {
    if (kind_ != Kind::checked || !same_time<uses_time>(t, t_)) return false;
    if constexpr (FieldState<S>) return all_ranks(y, hash(y) == last_);  // an edit on one is an edit
    else if constexpr (may_keep) return is_kept_ ? equal_bits(seen(y), seen(kept_)) : hash(y) == last_;
    else return equal_bits(seen(y), seen(last_));
  }
  /// The same, on the caller's word that the state is what the last step left.
  [[nodiscard]] bool holds_unedited(Scalar t) const { return kind_ != Kind::nothing && same_time<uses_time>(t, t_); }

  /// For a checkpoint. After it the guard knows the saved state, by its bits, and no other.
  void archive(auto& ar) {
    if constexpr (may_keep)
      if (std::exchange(is_kept_, false)) last_ = hash(kept_);  // what is read is a fingerprint, too
    ar("kind", kind_, "t", t_, "y", last_);
    ar.check(kind_ <= Kind::checked);
  }

 private:
  enum class Kind : std::uint8_t { nothing, vouched, checked };
  static constexpr bool by_value = fits_registers<S>;

  static constexpr bool may_keep = !by_value && !FieldState<S>;  // a copy of it
  static constexpr Index most_kept = 4096;                       // 32 KiB of doubles

  /// The blocks whose edits count.
  [[nodiscard]] static auto seen(auto& y) {
    if constexpr (position_only) return std::tie(position_of<S>(y));
    else return Blocks<S>::all(y);
  }
  [[nodiscard]] static std::uint64_t hash(const Plain& y) {
    std::uint64_t all = 0;
    for_each_block(
        [&all](auto, const auto& block) {
          if constexpr (FieldBlock<decltype(block)>)
            all = std::rotl(all, 1) + std::remove_cvref_t<decltype(block)>::Ops::fingerprint(block.handle());
          else all = fingerprint(block.data(), block.size(), all);
        },
        seen(y));
    return all;
  }

  std::conditional_t<by_value, Plain, std::uint64_t> last_{};
  [[no_unique_address]] Only<may_keep, Plain> kept_;
  bool has_room_ = false, is_kept_ = false;  // kept_ is large enough for the state; it holds it, else last_ does
  Scalar t_{};
  Kind kind_ = Kind::nothing;
};

}}  // namespace phistep::PHISTEP_ABI

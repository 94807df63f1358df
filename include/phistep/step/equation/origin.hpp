/// @file
/// Where a step comes from: what its caller knows of the state handed over, and which ends of it are times where the force
/// may jump.
///
/// A run ends steps at the times it is given, its own end among them, and at events. There a load may jump: the step that
/// ends at such a time T takes Ψ(T⁻), the one that starts there Ψ(T⁺) (E. Hairer, S. P. Nørsett & G. Wanner, Solving ODEs I,
/// sect. II.6). So that no rounding of T, the user's or ours, puts it on the wrong side, the force is asked six
/// roundings inside, which is also more than Ψ known at a time may be off its time (same_time in edit_guard.hpp).
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

#include "phistep/base/version.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// What a caller of a step knows of it.
struct Origin {
  enum Edits : std::uint8_t {
    unknown,        ///< whether the state is what the last step left: it is checked
    rest_unedited,  ///< of the particles outside the active set (base/state/active_set.hpp) it is known
    unedited,       ///< it is: the caller owns the loop
  };
  Edits edits = unknown;
  bool starts_at_jump = false, ends_at_jump = false;  ///< the force may jump there

  constexpr Origin(Edits known) : edits{known} {}  // NOLINT(google-explicit-constructor)
  constexpr Origin(Edits known, bool at_start, bool at_end)
      : edits{known}, starts_at_jump{at_start}, ends_at_jump{at_end} {}
  /// The origin of the first or the last part of the step.
  [[nodiscard]] constexpr Origin first_part() const { return {edits, starts_at_jump, false}; }
  [[nodiscard]] constexpr Origin last_part() const { return {unknown, false, ends_at_jump}; }
  [[nodiscard]] constexpr Origin with(Edits known) const { return {known, starts_at_jump, ends_at_jump}; }
  friend constexpr bool operator==(const Origin& origin, Edits known) { return origin.edits == known; }
};

/// The times at which a step may ask its force.
template <class Scalar>
class Times {
 public:
  Times() = default;
  Times(Scalar t, Scalar dt, const Origin& origin) {
    if (!origin.starts_at_jump && !origin.ends_at_jump) return;
    constexpr Scalar u = std::numeric_limits<Scalar>::epsilon();
    const Scalar end = t + dt, off = 6 * u * std::max(std::abs(t), std::abs(end)), sign = dt < 0 ? -1 : 1;
    if (std::abs(dt) <= 4 * off) return;
    // At t = 0 the clock goes on for ever.
    const Scalar first = t + sign * 6 * u * std::max(std::abs(t), u * std::abs(dt)), last = end - sign * off;
    if (origin.starts_at_jump) (sign < 0 ? last_ : first_) = first;
    if (origin.ends_at_jump) (sign < 0 ? first_ : last_) = last;
  }
  /// t, or the time next to it inside. [time]
  [[nodiscard]] Scalar operator()(Scalar t) const { return std::min(std::max(t, first_), last_); }

 private:
  Scalar first_ = -std::numeric_limits<Scalar>::infinity(), last_ = std::numeric_limits<Scalar>::infinity();
};

}}  // namespace phistep::PHISTEP_ABI

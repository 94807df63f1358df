/// @file
/// What is known of one particle that may sleep.
#pragma once

#include <cstdint>

#include "phistep/base/version.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// One particle, asleep or awake.
struct Sleeper {
  enum class Kind : std::uint8_t {
    held,     ///< by the user
    awake,    ///<
    watched,  ///< slow: computed as any other
    asleep    ///< not computed
  };
  Kind kind = Kind::awake;
  bool moves = false;            ///< held, with a velocity or a spin
  std::uint64_t properties = 0;  ///< fingerprint of its mass, radius …
  std::uint64_t seen = 0;        ///< … and of its numbers in the state: asleep, or held at rest
  std::int32_t naps = 0;         ///< how often its sleep expired
  std::int32_t quiet = 0;        ///< steps
  double impulse = 0;            ///< [force] left out while it sleeps
  double since = 0;              ///< [time] by the clock: quiet from then on
  double expires = 0;            ///< [time] by the clock: when its sleep does

  [[nodiscard]] bool is_asleep() const { return kind == Kind::asleep; }
  [[nodiscard]] bool is_computed() const { return kind == Kind::awake || kind == Kind::watched; }
  /// It stays as it is, so that a change of it is an edit.
  [[nodiscard]] bool rests() const { return kind == Kind::asleep || (kind == Kind::held && !moves); }
  /// Who touches it can't sleep.
  [[nodiscard]] bool disturbs() const { return kind == Kind::awake || (kind == Kind::held && moves); }
};

}}  // namespace phistep::PHISTEP_ABI

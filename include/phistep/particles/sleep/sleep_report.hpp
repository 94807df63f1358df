/// @file
/// When particles may fall asleep (particles/sleep/sleeping.hpp), and what that saved and cost.
#pragma once

#include <cstdint>
#include <utility>

#include "phistep/base/outcome/statistics.hpp"
#include "phistep/base/version.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// When particles fall asleep.
struct SleepOptions {
  double speed =
      0;  ///< [length/time] below which a particle counts as at rest, and the change that wakes it; 0: none sleeps
  int steps = 100;  ///< for so many steps
  int every = 25;   ///< steps between two checks of who may fall asleep
};

/// What sleep has saved and cost since the stepper was made.
struct SleepReport {
  std::int64_t asleep = 0;         ///< particles now
  std::int64_t fell_asleep = 0;    ///< how often one did
  std::int64_t woken = 0;          ///< how often one was woken
  std::int64_t skipped = 0;        ///< particle-steps that were not computed
  double energy_removed = 0;       ///< kinetic energy taken from those put to rest [energy]
  double impulse_not_applied = 0;  ///< Σ∫|F|dt over sleepers, F what pushed each on the mean before [force·time]

  void archive(auto& ar) {
    ar("asleep", asleep, "fell_asleep", fell_asleep, "woken", woken, "skipped", skipped, "energy_removed",
       energy_removed, "impulse_not_applied", impulse_not_applied);
    for (const std::int64_t count : {asleep, fell_asleep, woken, skipped}) ar.check(can_be_count(count));
  }

  template <class OStream>
    requires requires(OStream& out) { out << "" << std::int64_t{} << double{}; }
  friend OStream& operator<<(OStream& out, const SleepReport& r) {
    return out << "  asleep              " << r.asleep << "  (fell asleep " << r.fell_asleep << " times, woken "
               << r.woken << ")\n  skipped             " << r.skipped << " particle steps\n  energy removed      "
               << r.energy_removed << "\n  impulse not applied " << r.impulse_not_applied << '\n';
  }
};

/// Runs a scene with sleeping and without, and prints the difference in the user's observables.
/// @param scene        scene(options) runs it all and returns what the observables are read from
/// @param observables  pairs of a name and a function of that result to a number
template <class OStream, class Scene, class... Observable>
void compare_sleep(OStream& out, SleepOptions options, Scene&& scene,
                   const std::pair<const char*, Observable>&... observables) {
  const auto asleep = scene(options);
  options.speed = 0;
  const auto awake = scene(options);
  const auto line = [&](const char* name, double a, double b) {
    out << "  " << name << ": " << a << " with sleeping, " << b << " without, difference " << a - b << '\n';
  };
  (line(observables.first, static_cast<double>(observables.second(asleep)),
        static_cast<double>(observables.second(awake))),
   ...);
}

}}  // namespace phistep::PHISTEP_ABI

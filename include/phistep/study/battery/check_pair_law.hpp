/// @file
/// Whether a pair law is one that the kernels of particles/pairs can take:
///
///     const BatteryReport report = check_pair_law(LennardJones{}, 0.8, 2.5);
///
/// It is finite between the two distances; packs of numbers give what numbers give; with `energy(r²)`, F/r = −2 dV/d(r²).
#pragma once

#include <algorithm>
#include <cmath>

#include "phistep/base/numbers/pack.hpp"
#include "phistep/study/battery/battery_report.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// Whether the kernels of pairs can take a law, at 65 distances: a line for each check.
/// @param law      called with r² [length²] and, for laws of two kinds of particles, their tags
/// @param nearest  the smallest distance that occurs [length]
/// @param cutoff   [length]
template <class Law, class... Tag>
[[nodiscard]] BatteryReport check_pair_law(const Law& law, double nearest, double cutoff, Tag... tag) {
  using P = Pack<double, native_width<double>>;
  BatteryReport report;
  bool finite = true;
  double by_packs = 0, by_energy = 0;
  const auto relative = [](double a, double b, double scale) { return std::abs(a - b) / std::max(std::abs(b), scale); };
  const int count = 64;
  const double typical = std::abs(static_cast<double>(law(0.25 * (nearest + cutoff) * (nearest + cutoff), tag...)));
  for (int k = 0; k <= count; ++k) {
    const double r = nearest + (cutoff - nearest) * (k + 0.5) / (count + 1), r2 = r * r;
    const double strength = law(r2, tag...);
    finite = finite && std::isfinite(strength);
    by_packs = std::max(by_packs, relative(P{law(P{r2}, tag...)}[0], strength, typical));
    if constexpr (requires { law.energy(r2, tag...); }) {
      // The central difference of order 4: its error is (h/r²)⁴ of the strength, rounding 1e-16 r²/h.
      const double h = 1e-3 * r2;
      const auto energy = [&](double at) { return static_cast<double>(law.energy(r2 + at * h, tag...)); };
      const double slope = (8 * (energy(1) - energy(-1)) - (energy(2) - energy(-2))) / (12 * h);
      by_energy = std::max(by_energy, relative(-2 * slope, strength, std::max(typical, std::abs(energy(0)) / r2)));
    }
  }
  report.check(finite, "finite between the two distances");
  report.check(by_packs <= 1e-12, "packs give what numbers give, to %.1e", by_packs);
  if constexpr (requires { law.energy(cutoff, tag...); })
    report.check(by_energy <= 1e-6, "the force is the slope of the energy, to %.1e", by_energy);
  return report;
}

}}  // namespace phistep::PHISTEP_ABI

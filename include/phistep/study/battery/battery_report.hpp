/// @file
/// What a battery has found, and two short ones: whether a struct of blocks, or any other type, serves as a state, and whether a
/// pair law is one that the kernels of particles/pairs can take.
///
///     const BatteryReport report = check_state(Body{attitude, spin});
///     const BatteryReport report = check_pair_law(LennardJones{}, 0.8, 2.5);
///
/// Of a state copies own their numbers; each NaN is found; a step y' = 1 changes each solved number by Δt, and a failed one none;
/// the same run twice has the same bits. A law is finite between the two distances; packs of numbers give what numbers give; with
/// `energy(r²)`, F/r = −2 dV/d(r²).
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <limits>
#include <ostream>
#include <string>
#include <utility>
#include <vector>

#include "phistep/base/numbers/pack.hpp"
#include "phistep/base/state/blocks.hpp"
#include "phistep/run/stepper/phi_stepper.hpp"
#include "phistep/schemes/phi.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// One line for each check. Contextually true where all hold.
struct BatteryReport {
  struct Line {
    bool holds;
    std::string text;  ///< what was checked, and the figures
  };
  std::vector<Line> lines{};  ///< in the order of the checks

  /// @param text  where there are figures, a format of printf for them
  void check(bool holds, const std::string& text, auto... figures) {
    if constexpr (sizeof...(figures) == 0) {
      lines.push_back({holds, text});
    } else {
      char line[200];
      std::snprintf(line, sizeof line, text.c_str(), figures...);
      lines.push_back({holds, line});
    }
  }
  [[nodiscard]] explicit operator bool() const {
    for (const Line& line : lines)
      if (!line.holds) return false;
    return !lines.empty();
  }
  friend std::ostream& operator<<(std::ostream& out, const BatteryReport& report) {
    for (const Line& line : report.lines) out << (line.holds ? "holds   " : "BROKEN  ") << line.text << '\n';
    return out;
  }
};

namespace battery {
/// Ψ = 1 for each number, for any state; NaN if `broken`.
template <State S>
struct Ones {
  const bool* broken;
  static constexpr bool uses_velocity = false, uses_time = false;
  void add(auto /*t*/, const auto& /*y*/, auto& out) const {
    using Scalar = ScalarOf<S>;
    for_each_block(
        [this](auto, auto& psi) { psi.array() += *broken ? std::numeric_limits<Scalar>::quiet_NaN() : Scalar{1}; },
        RateOf<S>::blocks(out));
  }
};
}  // namespace battery

/// Whether a type serves as a state: a line for each check. @param state  finite, with at least one number in each block
template <State S>
[[nodiscard]] BatteryReport check_state(const S& state) {
  using Plain = PlainState<S>;
  using Scalar = ScalarOf<S>;
  BatteryReport report;
  Plain start, y;
  copy_blocks<S>(start, state);
  copy_blocks<S>(y, state);
  bool has_numbers = true;
  for_each_block([&](auto, const auto& block) { has_numbers = has_numbers && block.size() > 0; }, Blocks<S>::all(y));
  if (!has_numbers) return report.check(false, "each block has a number to check"), report;
  report.check(equal_blocks<S>(start, y) && all_finite(Blocks<S>::all(y)), "a copy has the same bits, all finite");
  for_each_block(
      [&](auto k, auto& block) {
        const Scalar kept = block.data()[0];
        block.data()[0] = std::numeric_limits<Scalar>::quiet_NaN();
        const std::string name = "block " + std::to_string(static_cast<std::size_t>(k));
        report.check(!all_finite(Blocks<S>::all(y)), name + ": a NaN is found");
        report.check(all_finite(Blocks<S>::all(start)), name + ": a copy owns its numbers");
        block.data()[0] = kept;
      },
      Blocks<S>::all(y));

  bool broken = false;
  const Scalar dt = Scalar{0.125};
  PhiStepper stepper{y, battery::Ones<Plain>{&broken}, forward_euler};
  const bool stepped{stepper.step(y, Scalar{0}, dt)};
  Scalar worst = 0;
  for_each_block(
      [&](auto k, const auto& after, const auto& before) {
        if (Blocks<S>::drifts && k == 0) return;
        worst = std::max(worst, (after - before).array().abs().maxCoeff() - dt);
        worst = std::max(worst, dt - (after - before).array().abs().minCoeff());
      },
      Blocks<S>::all(y), Blocks<S>::all(start));
  Scalar largest = 1;
  for_each_block([&](auto, const auto& block) { largest = std::max(largest, max_abs(block)); }, Blocks<S>::all(y));
  report.check(stepped && worst <= 4 * std::numeric_limits<Scalar>::epsilon() * largest,
               "a step of y' = 1 adds dt to each number");

  Plain before = y;
  broken = true;
  stepper.reset();
  const bool failed{!stepper.step(y, dt, dt)};
  report.check(failed && equal_blocks<S>(before, y), "a step that fails leaves every bit");
  broken = false;
  const auto run = [&] {
    Plain x = start;
    PhiStepper one{x, battery::Ones<Plain>{&broken}, trapezoidal};
    bool good = true;
    for (int k = 0; k < 8; ++k) good = one.step(x, static_cast<Scalar>(k) * dt, dt) && good;
    return std::pair{good, x};
  };
  const auto [good, once] = run();
  report.check(good, "eight implicit steps succeed");
  report.check(equal_blocks<S>(once, run().second), "the same run twice has the same bits");
  return report;
}

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
  const auto relative = [](double a, double b, double scale) {
    const double error = a == b ? 0 : std::abs(a - b) / std::max(std::abs(b), scale);
    return std::isnan(error) ? std::numeric_limits<double>::infinity() : error;  // std::max passes over a NaN
  };
  const int count = 64;
  const double typical = std::abs(static_cast<double>(law(0.25 * (nearest + cutoff) * (nearest + cutoff), tag...)));
  for (int k = 0; k <= count; ++k) {
    const double r = nearest + (cutoff - nearest) * (k + 0.5) / (count + 1), r2 = r * r;
    const double strength = law(r2, tag...);
    if (finite = finite && std::isfinite(strength); !finite) break;
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

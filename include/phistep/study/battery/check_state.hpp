/// @file
/// Whether a struct of blocks, or any other type, serves as a state:
///
///     const BatteryReport report = check_state(Body{attitude, spin});
///
/// Its copies own their numbers; each NaN is found; a step y' = 1 changes each solved number by Δt, and a failed one none; the
/// same run twice has the same bits.
#pragma once

#include <algorithm>
#include <cstddef>
#include <limits>
#include <string>
#include <utility>

#include "phistep/base/state/blocks.hpp"
#include "phistep/run/stepper/phi_stepper.hpp"
#include "phistep/schemes/phi.hpp"
#include "phistep/study/battery/battery_report.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

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
  report.check(equal_blocks<S>(start, y) && all_finite(Blocks<S>::all(y)), "a copy has the same bits, all finite");
  for_each_block(
      [&](auto k, auto& block) {
        const Scalar kept = block.data()[0];
        block.data()[0] = std::numeric_limits<Scalar>::quiet_NaN();
        const std::string name = "block " + std::to_string(static_cast<std::size_t>(k));
        report.check(block.size() > 0 && !all_finite(Blocks<S>::all(y)), name + ": a NaN is found");
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

}}  // namespace phistep::PHISTEP_ABI

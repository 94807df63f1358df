#pragma once

// Steppers of vectors to put through it: of each kind that keeps something from step to step.

#include "contract/machine.hpp"

namespace machine {

inline Vec spread(Eigen::Index n, double phase) {
  return Vec::LinSpaced(n, phase, phase + 0.7 * static_cast<double>(n)).array().sin();
}

struct FirstOrder {
  static constexpr bool has_past = false;
  static Vec start(int n) { return spread(n, 0.4); }
};
struct SecondOrder {
  static constexpr bool has_past = false;
  static Motion<Vec> start(int n) { return {spread(n, 0.4), spread(n, 1.9)}; }
};

/// By any scheme: constants of namespace phistep, or functions that make one.
template <const auto& scheme>
struct Flow : FirstOrder {
  static auto stepper(const Vec& y, Mood* mood) { return PhiStepper{y, Timed<states::DrivenPull>{{}, mood}, scheme}; }
};
template <const auto& scheme>
struct Swing : SecondOrder {
  static auto stepper(const Motion<Vec>& y, Mood* mood) {
    return PhiStepper{y, Position<states::Pull>{{}, mood}, scheme};
  }
};
template <const auto& scheme>
struct DampedSwing : SecondOrder {
  static auto stepper(const Motion<Vec>& y, Mood* mood) {
    return PhiStepper{y, Everything<states::DampedPull>{{}, mood}, scheme};
  }
};
inline constexpr auto phi_07 = phi(0.7);
inline constexpr auto starts_damped = rannacher(2);

struct Starts : Flow<starts_damped> {
  static constexpr bool has_past = true;  // how many half steps were done
};

}  // namespace machine

#pragma once

// Steppers to put through it: one of each kind that keeps something from step to step.

#include <phistep/particles.hpp>

#include "properties/machine_vectors.hpp"

namespace machine {

/// A gas in a periodic box: its list of neighbours lives long.
struct Gas {
  static constexpr bool has_past = false;
  using State = Particles<double, 3>;
  static State start(int n) {
    Eigen::Matrix3Xd r(3, n), v(3, n);
    for (Index k = 0; k < n; ++k) {
      r.col(k) << static_cast<double>(k % 2), static_cast<double>(k / 2 % 2), static_cast<double>(k / 4);
      v.col(k) = 0.5 * spread(3, static_cast<double>(k));
    }
    State gas{1.2 * r, v};
    gas.set_box(Box<double, 3>::periodic({0, 0, 0}, {5, 5, 5}));
    return gas;
  }
  static auto force(Mood* mood) {
    // Soft and smooth, so that no edit makes it stiff and no rounding makes a jump at the cutoff.
    const auto soft = [](auto r2) {
      const auto x = 1.0 - r2 / 3.24;
      return x * x;
    };
    return Pairs{soft, 1.8, {.skin = 0.3}} + Trouble{mood};
  }
  static bool edit(State& y, const Edit& edit) {
    if (y.size() == 0 || edit.kind != Edit::others) return false;
    y.set_mass(Vec(Vec::Constant(y.size(), 1.25 + edit.value)));
    return true;
  }
  static void resize(State& y, int n, const Edit& edit) {
    if (n > y.size()) {
      State more = start(n);
      const Index old = y.size();
      more.erase_if([old](Index i) { return i < old; });
      y.add(more);
    } else if (n < y.size()) {
      int gone = static_cast<int>(y.size()) - n;
      y.erase_if([&gone, &edit](Index i) { return (i + edit.which) % 2 == 0 && gone-- > 0; });
    }
  }
};
struct GasByVerlet : Gas {
  static auto stepper(const State& y, Mood* mood) { return PhiStepper{y, force(mood), velocity_verlet}; }
};

/// A list's reference positions are memory, which a fresh stepper hasn't.
inline Promise with_list(Promise promise) {
  promise.forgets = false;
  return promise;
}

/// Grains that touch, rub and remember.
struct Grains {
  static constexpr bool has_past = true;
  using State = Particles<double, 2, Spin>;
  static State start(int n) {
    Eigen::Matrix2Xd r(2, n), v(2, n);
    for (Index k = 0; k < n; ++k) {
      r.col(k) << 0.95 * static_cast<double>(k % 3), 0.96 * static_cast<double>(k / 3);
      v.col(k) = 0.1 * spread(2, static_cast<double>(k));
    }
    State grains{r, v};
    grains.set_radius(0.5);
    return grains;
  }
  static auto stepper(const State& y, Mood* mood) {
    const Hooke law{.stiffness = 20, .restitution = 0.7, .friction = 0.4};
    return PhiStepper{y, Contact{law} + Trouble{mood}, symplectic_euler};
  }
};

}  // namespace machine

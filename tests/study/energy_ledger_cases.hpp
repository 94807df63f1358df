#pragma once

// What energy_ledger.test.cpp and its full half share.

#include <phistep/observe/completed_step.hpp>
#include <phistep/observe/dense_output.hpp>
#include <phistep/phistep.hpp>
#include <phistep/sparse.hpp>

#include <cmath>
#include <random>
#include <sstream>
#include <stdexcept>
#include <vector>

#include "problems/oscillator.hpp"
#include "problems/spring_net.hpp"
#include "support/catch.hpp"

namespace energy_ledger_cases {

using namespace phistep;

using One = Eigen::Matrix<double, 1, 1>;

/// n steps with the ledger as their only observer.
template <class Stepper, class S, class Ledger>
void march(Stepper& stepper, S& y, double h, int n, Ledger& ledger, auto&& edit, double t0 = 0) {
  ledger.begin(t0, y);
  DenseOutput<S> dense;
  for (int k = 0; k < n; ++k) {
    const double t = t0 + k * h;
    edit(k, y);
    const S start = y;
    const auto done = stepper.step(y, t, h);
    if (!done) throw std::runtime_error(done.message());
    const S end = y;
    ledger(CompletedStep<S>{t, h, t0 + (k + 1) * h, start, end, dense});
  }
}
template <class Stepper, class S, class Ledger>
void march(Stepper& stepper, S& y, double h, int n, Ledger& ledger) {
  march(stepper, y, h, n, ledger, [](int, S&) {});
}

inline constexpr double omega_squared = 4;
inline const auto spring = with_energy([](const One& r) -> One { return -omega_squared * r; },
                                       [](const One& r) { return omega_squared * r.squaredNorm() / 2; });
inline const auto pendulum = with_energy([](const One& r) -> One { return One{-9.81 * std::sin(r[0])}; },
                                         [](const One& r) { return 9.81 * (1 - std::cos(r[0])); });

/// The bound on closure: a step's accounts are a few products of the size of E, each rounded; over n steps their errors
/// add up like a walk, and at worst to n times as much.
inline double rounding(int n) { return 8 * 2.2e-16 * std::max(8.0, std::sqrt(n)); }

/// A force f(r, v, t) counts as damping: only a struct can say that it ignores v.
struct Drive : ForceTerm {
  static constexpr bool uses_velocity = false;
  void add(double t, const auto&, auto& out) const { out.force[0] += std::cos(t); }
};
/// A spring whose stiffness may be changed.
struct Tunable : ForceTerm {
  double k = 4;
  static constexpr bool uses_velocity = false, uses_time = false;
  void add(double, const auto& y, auto& out) const { out.force -= k * y.r; }
  double energy(double, const auto& y) const { return k * y.r.squaredNorm() / 2; }
};
/// Pulls the first particle of a net to and fro.
struct Shaker : ForceTerm {
  static constexpr bool uses_velocity = false;
  static constexpr Structure structure = Structure::none;
  double force, omega;
  Shaker(double f, double w) : force{f}, omega{w} {}
  void add(double t, const auto&, auto& out) const { out.force[0] += force * std::sin(omega * t); }
  void add_jacobian(double, const auto&, auto&) const {}
};

}  // namespace energy_ledger_cases

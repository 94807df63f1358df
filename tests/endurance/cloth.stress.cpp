// A damped cloth, hung up by two corners and let go flat: it must come to rest and stay there, its energy only fall.
#include <phistep/phistep.hpp>
#include <phistep/sparse.hpp>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "endurance/drift.hpp"
#include "support/catch.hpp"

namespace {

/// 12 × 12 unit masses one apart, two corners of which don't move; springs along, across and diagonally, a dashpot beside
/// each, and a little drag.
struct Cloth {
  using State = phistep::Motion<Eigen::VectorXd>;
  static constexpr int side = 12, particles = side * side;
  static constexpr double stiffness = 1e4, damping = 20, drag = 0.2, gravity = 1;

  [[nodiscard]] static std::vector<phistep::Spring> springs() {
    std::vector<phistep::Spring> all;
    for (int y = 0; y < side; ++y)
      for (int x = 0; x < side; ++x) {
        const int i = x + side * y;
        if (x + 1 < side) all.push_back({i, i + 1, stiffness, 1});
        if (y + 1 < side) all.push_back({i, i + side, stiffness, 1});
        if (x + 1 < side && y + 1 < side) {
          all.push_back({i, i + side + 1, stiffness / 2, std::sqrt(2.0)});
          all.push_back({i + 1, i + side, stiffness / 2, std::sqrt(2.0)});
        }
      }
    return all;
  }
  [[nodiscard]] static bool is_held(int i) { return i == 0 || i == side - 1; }
  /// Held particles weigh 1e20 and feel no gravity.
  [[nodiscard]] static Eigen::VectorXd masses() {
    Eigen::VectorXd m = Eigen::VectorXd::Ones(3 * particles);
    for (int i = 0; i < particles; ++i)
      if (is_held(i)) m.segment<3>(3 * i).setConstant(1e20);
    return m;
  }
  [[nodiscard]] static Eigen::VectorXd weights() {
    Eigen::VectorXd f = Eigen::VectorXd::Zero(3 * particles);
    for (int i = 0; i < particles; ++i)
      if (!is_held(i)) f[3 * i + 2] = -gravity;
    return f;
  }
  [[nodiscard]] static State start() {
    State y{Eigen::VectorXd::Zero(3 * particles), Eigen::VectorXd::Zero(3 * particles)};
    for (int i = 0; i < particles; ++i) y.r.segment<3>(3 * i) << i % side, i / side, 0;
    return y;
  }
  [[nodiscard]] static auto force() {
    return phistep::spring_network<3>(springs(), phistep::SpringDamping{damping}) + phistep::UniformForce{weights()} +
           phistep::LinearDrag{drag};
  }
  /// Kinetic, of the springs, of the height.
  [[nodiscard]] static long double energy(const State& y) {
    static const auto all = springs();
    static const Eigen::VectorXd m = masses(), f = weights();
    long double sum = 0;
    for (Eigen::Index k = 0; k < y.v.size(); ++k)
      sum += static_cast<long double>(m[k]) * y.v[k] * y.v[k] / 2 - static_cast<long double>(f[k]) * y.r[k];
    for (const auto& s : all) {
      const long double stretch = (y.r.segment<3>(3 * s.i) - y.r.segment<3>(3 * s.j)).cast<long double>().norm() -
                                  static_cast<long double>(s.length);
      sum += s.stiffness * stretch * stretch / 2;
    }
    return sum;
  }
  /// Of those that may move.
  [[nodiscard]] static double fastest(const State& y) {
    double most = 0;
    for (int i = 0; i < particles; ++i)
      if (!is_held(i)) most = std::max(most, y.v.segment<3>(3 * i).norm());
    return most;
  }
};

void hangs(const std::string& name, auto scheme, double dt, int fall, int rest) {
  auto y = Cloth::start();
  phistep::PhiStepper stepper{y, Cloth::force(), scheme, phistep::mass(Cloth::masses())};
  double rise = 0;
  long double energy = Cloth::energy(y);
  const long double start = energy;
  auto told = std::chrono::steady_clock::now();
  const auto step = [&](int n) {
    if (const auto done = stepper.step(y, n * dt, dt); !done) FAIL(done.message());
    const long double now = Cloth::energy(y);
    rise = std::max(rise, static_cast<double>(now - energy));
    energy = now;
    if (std::chrono::steady_clock::now() - told > std::chrono::seconds{15}) {
      told = std::chrono::steady_clock::now();
      figures::progress(name + ", step " + std::to_string(n));
    }
  };
  for (int n = 0; n < fall; ++n) step(n);
  const auto there = y;
  const double fallen = static_cast<double>(start - energy), speed = Cloth::fastest(y);
  const double rise_falling = std::exchange(rise, 0);
  double fastest = 0, away = 0;
  for (int n = fall; n < fall + rest; ++n) {
    step(n);
    fastest = std::max(fastest, Cloth::fastest(y));
    away = std::max(away, (y.r - there.r).lpNorm<Eigen::Infinity>());
  }
  const std::string which = figures::text(fall) + " steps: ", then = figures::text(rest) + " steps more: ";
  figures::told(fallen, name + ", cloth", which + "energy lost");
  // Rounding of positions in the springs' energy: u r times forces of some 100, for 500 springs, against 800 lost.
  figures::at_most(1e-13, rise_falling / fallen, name + ", cloth: the energy only falls",
                   which + "largest rise in a step, of all lost");
  figures::at_most(1e-13, rise / fallen, name + ", cloth at rest: the energy only falls",
                   then + "largest rise in a step, of all lost");
  // Forces round by k u r = 1e4 · 1e-16 · 12 = 1e-11; drag of 0.2 lets that move a mass at 6e-11, and its weight, as a
  // pendulum's of length 12, 1e-10 far.
  figures::at_most(6e-11, speed, name + ", cloth: it comes to rest", which + "speed");
  figures::at_most(6e-11, fastest, name + ", cloth: it stays at rest", then + "largest speed");
  figures::at_most(1e-10, away, name + ", cloth: it stays where it is", then + "farthest from there");
}

}  // namespace

TEST_CASE("a damped cloth comes to rest, and stays") {
  hangs("backward Euler", phistep::backward_euler, 0.05, 10000, 10000);
  hangs("midpoint", phistep::midpoint, 0.02, 20000, 10000);
}

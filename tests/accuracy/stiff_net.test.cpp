// A membrane of springs in steps from well below to far above what an explicit scheme could take: every oscillation
// follows the exact map of the scheme (numerical frequency, damping and all), and the cost hardly grows with the
// stiffness. By backward Euler too: the full tier.
#include <phistep/phistep.hpp>

#include <cmath>
#include <random>
#include <vector>

#include "support/catch.hpp"

using namespace phistep;

namespace {

constexpr int inside = 12, side = inside + 2, steps = 20;
constexpr double pi = 3.14159265358979323846;

/// A square net with springs of stiffness k along its lines, held at the rim by masses of 1e20. Stretched by a quarter
/// (ratio = 0.8), its out-of-plane oscillations have ω² = 4 k (1 − ratio)(sin²(pπ/2N) + sin²(qπ/2N)), N = inside + 1,
/// up to the square of the amplitude; with springs of no length at rest (ratio = 0) exactly so, in every direction.
struct Membrane {
  double k, ratio;
  Motion<Eigen::Matrix3Xd> state{Eigen::Matrix3Xd::Zero(3, side* side), Eigen::Matrix3Xd::Zero(3, side* side)};
  Eigen::VectorXd masses = Eigen::VectorXd::Ones(side * side);

  static bool is_rim(int x, int y) { return x == 0 || y == 0 || x == side - 1 || y == side - 1; }

  Membrane(double stiffness, double rest, double amplitude) : k{stiffness}, ratio{rest} {
    std::mt19937 random(11);
    std::normal_distribution<double> normal;
    for (int y = 0; y < side; ++y)
      for (int x = 0; x < side; ++x) {
        const int i = y * side + x;
        if (ratio > 0) state.r.col(i) << x, y, 0;
        if (is_rim(x, y)) masses[i] = 1e20;
        else state.r(2, i) = amplitude * normal(random);  // every mode there is
      }
  }
  [[nodiscard]] auto force() const {
    std::vector<Spring> springs;
    for (int y = 0; y < side; ++y)
      for (int x = 0; x < side; ++x) {
        if (x + 1 < side) springs.push_back({y * side + x, y * side + x + 1, k, ratio});
        if (y + 1 < side) springs.push_back({y * side + x, y * side + x + side, k, ratio});
      }
    return spring_network<3>(springs);
  }
};

struct Mode {
  int p, q;
  [[nodiscard]] double omega(const Membrane& m) const {
    const double a = std::sin(p * pi / (2 * (inside + 1))), b = std::sin(q * pi / (2 * (inside + 1)));
    return 2 * std::sqrt(m.k * (1 - m.ratio) * (a * a + b * b));
  }
  /// The mode's part in the third row.
  [[nodiscard]] double part(const Eigen::Matrix3Xd& u) const {
    double sum = 0;
    for (int y = 0; y < side; ++y)
      for (int x = 0; x < side; ++x)
        if (!Membrane::is_rim(x, y))
          sum += u(2, y * side + x) * std::sin(p * pi * x / (inside + 1)) * std::sin(q * pi * y / (inside + 1));
    return sum * 4 / ((inside + 1) * (inside + 1));
  }
};

/// Largest error of three modes over `steps` steps of length 1 against the scheme's exact map, relative to the modes' size;
/// and iterations of conjugate gradients a step.
struct Result {
  double error = 0, energy_error = 0, linear_iterations = 0;
  Statistics work;
};
Result run(auto scheme, double phi, double k, double ratio, double amplitude) {
  Membrane membrane(k, ratio, amplitude);
  auto& y = membrane.state;
  PhiStepper stepper{y, membrane.force(), scheme, mass(membrane.masses)};
  const std::vector<Mode> modes{{1, 1}, {5, 2}, {inside, inside}};
  std::vector<Eigen::Vector2d> exact;  // (r, v/ω)
  for (const Mode& mode : modes) exact.emplace_back(mode.part(y.r), 0);
  const auto start = exact;
  Result result;
  for (int n = 0; n < steps; ++n) {
    const auto report = stepper.step(y, n, 1.0);
    CAPTURE(k, phi, ratio, n, report.message());
    REQUIRE(report);
    for (std::size_t m = 0; m < modes.size(); ++m) {
      const double a = modes[m].omega(membrane);
      Eigen::Matrix2d map{{1 - phi * (1 - phi) * a * a, a}, {-a, 1 - phi * (1 - phi) * a * a}};
      exact[m] = (map / (1 + phi * phi * a * a) * exact[m]).eval();
      const Eigen::Vector2d now(modes[m].part(y.r), modes[m].part(y.v) / a);
      result.error = std::max(result.error, (now - exact[m]).norm() / start[m].norm());
      if (phi == 0.5)
        result.energy_error = std::max(result.energy_error, std::abs(now.squaredNorm() / start[m].squaredNorm() - 1));
    }
  }
  result.work = stepper.statistics();
  result.linear_iterations = static_cast<double>(result.work.linear_iterations) / steps;
  return result;
}

}  // namespace

#if PHISTEP_FULL
// A membrane of springs, by backward Euler too.

TEST_CASE("a stiff net follows the scheme's exact map, mode by mode") {
  for (const double k : {1.0, 1e2, 1e4, 1e6, 1e8}) {
    CAPTURE(k);
    // Linear: what is left is rounding. φ = ½ keeps each solve's error for good, and Newton may stop where its corrections
    // are 4e-11 (u^⅔) of the velocity: 20 steps make 8e-10.
    const Result linear = run(trapezoidal, 0.5, k, 0, 1), damped = run(backward_euler, 1, k, 0, 1);
    CHECK(linear.error <= 8e-10);
    CHECK(linear.energy_error <= 1.6e-9);
    CHECK(damped.error <= 8e-10);
    CHECK(linear.work.fallbacks + damped.work.fallbacks == 0);
    // Stretched: springs rotate, which adds terms of the order of the squared slope, 1e-8 … a few times, in each step.
    const Result stretched = run(trapezoidal, 0.5, k, 0.8, 1e-5), sinking = run(backward_euler, 1, k, 0.8, 1e-5);
    CHECK(stretched.error <= 1e-6);
    CHECK(stretched.energy_error <= 2e-6);
    CHECK(sinking.error <= 1e-6);
  }
}

TEST_CASE("the cost of a step grows more slowly than the square root of the stiffness") {
  double before = 0;
  for (const double k : {1.0, 1e2, 1e4, 1e6, 1e8}) {
    const double now =
        std::max(run(trapezoidal, 0.5, k, 0, 1).linear_iterations, run(backward_euler, 1, k, 0, 1).linear_iterations);
    CAPTURE(k, before, now);
    if (before > 0) CHECK(now < 10 * before);  // √100
    before = now;
  }
  // Theory: with Δt²k/m → ∞ the condition number becomes that of the net itself, (2N/π)² = 68, whatever k; each digit then
  // takes some √68/2 · ln 10 = 10 iterations, and the sixteen digits of rounding 160.
  CHECK(before < 250);
}

#endif

// Preflight's Δt is stable, one and a half times it is not: on scenes that are run, not on formulas alone. And what it
// says of terms, accuracy, contacts and nonsense.
#include <phistep/preflight.hpp>
#include <phistep/sparse.hpp>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <numbers>
#include <random>
#include <sstream>
#include <string>
#include <vector>

#include "problems/heat.hpp"
#include "support/catch.hpp"

using namespace phistep;
using Vec = Eigen::VectorXd;
using Mat2 = Eigen::Matrix2Xd;
using Mat3 = Eigen::Matrix3Xd;

namespace {

/// The largest factor by which a tiny random change of the state has grown in up to `steps` steps; infinite where a step
/// fails. Positions and first-order states are changed, velocities are not: a free network then doesn't drift away.
template <class S>
double growth(auto& stepper, const S& start, double dt, int steps) {
  std::mt19937 random(7);
  std::normal_distribution<double> normal;
  S y = start;
  auto& moved = std::get<0>(Blocks<S>::all(y));
  const auto& still = std::get<0>(Blocks<S>::all(start));
  for (Eigen::Index i = 0; i < moved.size(); ++i) moved.data()[i] += 1e-9 * normal(random);
  const double before = (moved - still).norm();
  double most = 1;
  stepper.reset();
  for (int n = 0; n < steps; ++n) {
    if (!stepper.step(y, dt * n, dt)) return std::numeric_limits<double>::infinity();
    const double now = (moved - still).norm() / before;
    most = std::max(most, std::isfinite(now) ? now : std::numeric_limits<double>::infinity());
    if (most > 1e6) break;
  }
  return most;
}

/// At the limit itself, errors of a scheme that doesn't damp grow in proportion to time; a thousandth below, by at most
/// 1/√(1 − 0.999²) = 22 for each mode. At 1.5 times the limit Verlet's stiffest mode grows by 6.9 a step.
constexpr double bounded = 60, blown_up = 1e6;

/// start must be at rest, so that the change is all that moves.
template <class S>
PreflightReport check_scene(const char* name, auto stepper, const S& start) {
  const PreflightReport report = preflight(stepper, start, 1.0);
  INFO(name << ": " << report.text());
  REQUIRE(report.stable_dt > 0);
  REQUIRE(std::isfinite(report.stable_dt));
  const double below = growth(stepper, start, report.stable_dt, 4000);
  CHECK(below < bounded);
  CHECK(growth(stepper, start, 1.5 * report.stable_dt, 4000) >= blown_up);
  // Where it really ends.
  double low = 1, high = 1.5;
  while (high - low > 0.01) {
    const double middle = (low + high) / 2;
    (growth(stepper, start, middle * report.stable_dt, 1000) < blown_up ? low : high) = middle;
  }
  std::printf("%-46s %s  stable dt %-10.4g true limit / it: %.2f   growth at it: %.3g\n", name,
              report.whole.exact ? "eigenvalues" : "bounds     ", report.stable_dt, low, below);
  return report;
}

std::vector<Spring> chain(int n, double k) {
  std::vector<Spring> springs;
  for (int i = 0; i + 1 < n; ++i) springs.push_back({i, i + 1, k, 1.0});
  return springs;
}
/// Springs between all pairs nearer than `reach`, at rest as they are.
template <class Positions>
std::vector<Spring> net(const Positions& r, double k, double reach) {
  std::vector<Spring> springs;
  for (Eigen::Index i = 0; i < r.cols(); ++i)
    for (Eigen::Index j = i + 1; j < r.cols(); ++j)
      if (const double length = (r.col(i) - r.col(j)).norm(); length < reach) springs.push_back({i, j, k, length});
  return springs;
}
template <class Positions>
Motion<Positions> at_rest(const Positions& r) {
  return {r, Positions(Positions::Zero(r.rows(), r.cols()))};
}
Mat2 triangles(int side) {
  Mat2 r(2, side * side);
  for (int i = 0; i < r.cols(); ++i) r.col(i) << i % side + 0.5 * (i / side), std::sqrt(0.75) * (i / side);
  return r;
}
Motion<Vec> chain_state(int n) { return {Vec::LinSpaced(n, 0, n - 1), Vec::Zero(n)}; }

/// −Δ with zero beside the edges, on a side×side grid of spacing 1.
Eigen::SparseMatrix<double> laplacian_2d(int side) {
  std::vector<Eigen::Triplet<double>> entries;
  for (int i = 0; i < side * side; ++i) {
    entries.emplace_back(i, i, -4);
    if (i % side > 0) entries.emplace_back(i, i - 1, 1);
    if (i % side < side - 1) entries.emplace_back(i, i + 1, 1);
    if (i >= side) entries.emplace_back(i, i - side, 1);
    if (i + side < side * side) entries.emplace_back(i, i + side, 1);
  }
  Eigen::SparseMatrix<double> A(side * side, side * side);
  A.setFromTriplets(entries.begin(), entries.end());
  return A;
}

}  // namespace

TEST_CASE("stable at preflight's dt, not at 1.5 times it: motion, Verlet") {
  {
    const auto y = chain_state(400);
    const auto report = check_scene("chain, velocity_verlet",
                                    PhiStepper{y, spring_network<1>(chain(400, 300)), velocity_verlet, mass(2.0)}, y);
    // ω = 2√(k/m) for an endless chain.
    CHECK(report.stable_dt == Approx(0.999 * 2 / (2 * std::sqrt(150.0))).epsilon(1e-6));
  }
  {
    Mat2 r(2, 225);
    for (int i = 0; i < 225; ++i) r.col(i) << i % 15, i / 15;
    const auto y = at_rest(r);
    check_scene("square lattice, velocity_verlet",
                PhiStepper{y, spring_network<2>(net(r, 1e4, 1.1)), velocity_verlet, mass(0.3)}, y);
    check_scene("square lattice with diagonals, velocity_verlet",
                PhiStepper{y, spring_network<2>(net(r, 1e4, 1.5)), velocity_verlet, mass(0.3)}, y);
  }
  {
    const Mat2 r = triangles(15);
    const auto y = at_rest(r);
    const auto report = check_scene("triangular lattice, velocity_verlet",
                                    PhiStepper{y, spring_network<2>(net(r, 50, 1.1)), velocity_verlet, mass(2.0)}, y);
    CHECK(report.whole.frequency <= std::sqrt(6 * 25.0) * (1 + 1e-9));
  }
  {
    Mat3 r(3, 216);
    Vec m(216);
    std::mt19937 random(3);
    std::uniform_real_distribution<double> exponent(-1, 1);
    for (int i = 0; i < 216; ++i) r.col(i) << i % 6, i / 6 % 6, i / 36;
    for (double& one : m) one = std::pow(10.0, exponent(random));
    const auto y = at_rest(r);
    check_scene("3-D lattice, masses 0.1 … 10, velocity_verlet",
                PhiStepper{y, spring_network<3>(net(r, 700, 1.5)), velocity_verlet, mass(m)}, y);
  }
  for (const unsigned seed : {11u, 12u, 13u}) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> place(0, 12), exponent(-1, 1);
    Mat2 r(2, 150);
    Vec m(150);
    for (int i = 0; i < 150; ++i) r.col(i) << place(random), place(random);
    for (double& one : m) one = std::pow(10.0, exponent(random));
    auto springs = net(r, 1, 1.7);
    for (Spring& s : springs) s.stiffness = std::pow(10.0, 2 * exponent(random));
    const auto y = at_rest(r);
    check_scene(("random net, seed " + std::to_string(seed) + ", velocity_verlet").c_str(),
                PhiStepper{y, spring_network<2>(springs), velocity_verlet, mass(m)}, y);
  }
}

TEST_CASE("stable at preflight's dt, not at 1.5 times it: motion, other schemes and damping") {
  const auto y = chain_state(300);
  const auto springs = spring_network<1>(chain(300, 300));
  check_scene("chain and drag, velocity_verlet", PhiStepper{y, springs + LinearDrag{3.0}, velocity_verlet, mass(2.0)},
              y);
  check_scene("chain and drag, symplectic_euler",
              PhiStepper{y, springs + LinearDrag{20.0}, symplectic_euler, mass(2.0)}, y);
  check_scene("chain and drag, symplectic_euler_adjoint",
              PhiStepper{y, springs + LinearDrag{20.0}, symplectic_euler_adjoint, mass(2.0)}, y);
  check_scene("chain with dashpots, symplectic_euler",
              PhiStepper{y, spring_network<1>(chain(300, 300), SpringDamping{10}), symplectic_euler, mass(2.0)}, y);
  check_scene("chain, phi(0.2, 0.9)", PhiStepper{y, springs, phi(0.2, 0.9), mass(2.0)}, y);
  check_scene("chain and drag, phi(0.25)", PhiStepper{y, springs + LinearDrag{20.0}, phi(0.25), mass(2.0)}, y);
  const auto few = chain_state(20);
  check_scene("20 particles with dashpots, symplectic_euler",
              PhiStepper{few, spring_network<1>(chain(20, 300), SpringDamping{10}), symplectic_euler, mass(2.0)}, few);
  const Motion oscillator{Eigen::Vector2d{0, 0}, Eigen::Vector2d{0, 0}};
  const auto report =
      check_scene("damped oscillator, forward_euler",
                  PhiStepper{oscillator, linear(Eigen::Matrix2d(-4 * Eigen::Matrix2d::Identity())) + LinearDrag{0.8},
                             forward_euler},
                  oscillator);
  CHECK(report.stable_dt == Approx(0.999 * 0.8 / 4).epsilon(1e-9));  // 2ζ/ω = c/ω²
  check_scene("chain, half of it as kicks, trapezoidal",
              PhiStepper{y, springs + at(forward_euler, spring_network<1>(chain(300, 20))), trapezoidal, mass(2.0)}, y);
}

TEST_CASE("stable at preflight's dt, not at 1.5 times it: first order") {
  {
    const Vec u = Vec::Zero(500);
    const auto report = check_scene("heat in 1-D, forward_euler",
                                    PhiStepper{u, problems::Heat<Eigen::SparseMatrix<double>>(500), forward_euler}, u);
    const double dx = 1.0 / 501;
    CHECK(report.stable_dt == Approx(0.999 * dx * dx / 2).epsilon(1e-6));
    CHECK(report.monotone_dt == Approx(dx * dx / 2).epsilon(1e-9));   // ρcΔx²/(2dk(1−φ))
    CHECK(report.unringing_dt == Approx(dx * dx / 4).epsilon(1e-6));  // 4dk in place of 2dk
  }
  {
    const Vec u = Vec::Zero(400);
    const auto report = check_scene("heat in 2-D, phi(0.25)", PhiStepper{u, linear(laplacian_2d(20)), phi(0.25)}, u);
    CHECK(report.stable_dt == Approx(0.999 * 2 / (0.5 * 8)).epsilon(0.02));  // a finite grid's ρ is a little below 8
  }
  {
    // u_t = −u_x + 0.01 u_xx, upwind: nonsymmetric, discs left of 0.
    std::vector<Eigen::Triplet<double>> entries;
    const double flow = 250, diffusion = 0.01 * 250 * 250;
    for (int i = 0; i < 250; ++i) {
      entries.emplace_back(i, i, -flow - 2 * diffusion);
      if (i > 0) entries.emplace_back(i, i - 1, flow + diffusion);
      if (i < 249) entries.emplace_back(i, i + 1, diffusion);
    }
    Eigen::SparseMatrix<double> A(250, 250);
    A.setFromTriplets(entries.begin(), entries.end());
    const Vec u = Vec::Zero(250);
    check_scene("advection and diffusion, forward_euler", PhiStepper{u, linear(A), forward_euler}, u);
  }
  {
    // Brusselator at rest, a = 1, b = 1.5: eigenvalues −¼ ± i√(15/16), limit 2·¼/1.
    const Eigen::Vector2d y{1, 1.5};
    const auto f = [](const Eigen::Vector2d& u) -> Eigen::Vector2d {
      return {1 + u[0] * u[0] * u[1] - 2.5 * u[0], 1.5 * u[0] - u[0] * u[0] * u[1]};
    };
    const auto report = check_scene("Brusselator, forward_euler", PhiStepper{y, f, forward_euler}, y);
    CHECK(report.stable_dt == Approx(0.999 * 0.5).epsilon(1e-6));
  }
  {
    const Vec u = Vec::Zero(40);
    const Eigen::MatrixXd M = Eigen::MatrixXd(laplacian_2d(1).coeff(0, 0) * -0.25 * Eigen::MatrixXd::Identity(40, 40)) +
                              0.25 * (Eigen::MatrixXd(Eigen::MatrixXd::Identity(40, 40)).rowwise().reverse());
    Eigen::MatrixXd A = Eigen::MatrixXd::Zero(40, 40);
    for (int i = 0; i < 40; ++i) {
      A(i, i) = -2;
      if (i > 0) A(i, i - 1) = A(i - 1, i) = 1;
    }
    check_scene("heat with a full capacity matrix, forward_euler", PhiStepper{u, linear(A), forward_euler, capacity(M)},
                u);
  }
}

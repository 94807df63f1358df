// What preflight says: of terms, of every structure the library knows, of accuracy, of contacts, and of nonsense.
#include <phistep/preflight.hpp>
#include <phistep/sparse.hpp>

#include <cmath>
#include <limits>
#include <numbers>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "support/catch.hpp"

using namespace phistep;
using Vec = Eigen::VectorXd;
using Sparse = Eigen::SparseMatrix<double>;

namespace {

constexpr double infinite = std::numeric_limits<double>::infinity(),
                 nan_value = std::numeric_limits<double>::quiet_NaN();

std::vector<Spring> chain(int n, double k) {
  std::vector<Spring> springs;
  for (int i = 0; i + 1 < n; ++i) springs.push_back({i, i + 1, k, 1.0});
  return springs;
}
Motion<Vec> chain_state(int n) { return {Vec::LinSpaced(n, 0, n - 1), Vec::Zero(n)}; }
/// −k × (the chain's differences), all of it linear.
Sparse chain_matrix(int n, double k) {
  std::vector<Eigen::Triplet<double>> entries;
  for (int i = 0; i + 1 < n; ++i)
    for (const auto& [a, b, x] : {std::tuple{i, i, -k}, {i + 1, i + 1, -k}, {i, i + 1, k}, {i + 1, i, k}})
      entries.emplace_back(a, b, x);
  Sparse K(n, n);
  K.setFromTriplets(entries.begin(), entries.end());
  return K;
}
struct ChainForce {
  double k;
  Vec operator()(const Vec& r) const {
    Vec f = Vec::Zero(r.size());
    for (Eigen::Index i = 0; i + 1 < r.size(); ++i) {
      const double pull = k * (r[i + 1] - r[i] - 1);
      f[i] += pull, f[i + 1] -= pull;
    }
    return f;
  }
};
bool mentions(const PreflightReport& report, const std::string& what) {
  return report.text().find(what) != std::string::npos;
}

}  // namespace

TEST_CASE("every structure gives the same bound") {
  for (const int n : {50, 300}) {
    const auto y = chain_state(n);
    const double k = 8, m = 2, omega = 2 * std::sqrt(k / m) * std::cos(std::numbers::pi / (2 * n));
    const auto check = [&](const char* name, auto force, double rounding) {
      PhiStepper stepper{y, force, velocity_verlet, mass(m)};
      const auto report = preflight(stepper, y, 0.01);
      INFO(name << ", " << n << " particles");
      CHECK(report.whole.exact == (2 * n <= 200));
      CHECK(report.whole.frequency >= omega * (1 - rounding));
      CHECK(report.whole.frequency <= 2 * std::sqrt(k / m) * (1 + rounding));
      if (report.whole.exact) CHECK(report.whole.frequency == Approx(omega).epsilon(rounding));
      CHECK(report.whole.damping == 0);
    };
    check("network", spring_network<1>(chain(n, k)), 1e-12);
    check("linear, sparse", linear(chain_matrix(n, k)), 1e-12);
    check("linear, dense", linear(Eigen::MatrixXd(chain_matrix(n, k))), 1e-12);
    // Differences: increments √u × position/16 … position.
    check("differences", ChainForce{k}, 1e-5);
    check("affine", affine(ChainForce{k}), 1e-10);
    check("symmetric", symmetric(ChainForce{k}), 1e-5);
    check("banded", banded(ChainForce{k}, 1, 1), 1e-5);
    check("block tridiagonal", block_tridiagonal<2>(ChainForce{k}), 1e-5);
    check("sparsity", sparsity(ChainForce{k}, chain_matrix(n, 1)), 1e-5);
    check("a sum", term(ChainForce{k}) + UniformForce{Eigen::Matrix<double, 1, 1>{1}}, 1e-5);
    check("by reference", std::ref(*new ChainForce{k}), 1e-5);
  }
}

TEST_CASE("each term's rates, and which is stiffest where") {
  for (const int n : {30, 200}) {  // exact, bounds
    Eigen::Matrix3Xd r(3, n);
    for (int i = 0; i < n; ++i) r.col(i) << i, 0, 0;
    const Motion y{r, Eigen::Matrix3Xd::Zero(3, n)};
    std::vector<Spring> one{{17, 18, 5e4, 1.0}};
    const auto force = spring_network<3>(chain(n, 100)) + LinearDrag{0.6} + spring_network<3>(one) +
                       Gravity{Eigen::Vector3d{0, 0, -9.81}} +
                       local<3>([](const Eigen::Vector3d& x) -> Eigen::Vector3d { return -3 * x; });
    PhiStepper stepper{y, force, velocity_verlet, mass(2.0)};
    const auto report = preflight(stepper, y, 1e-3);
    REQUIRE(report.terms.size() == 5);
    CHECK(report.terms[0].frequency == Approx(std::sqrt(4 * 100 / 2.0)).epsilon(0.01));
    CHECK(report.terms[1].frequency == 0);
    CHECK(report.terms[1].damping == Approx(0.3).epsilon(1e-12));
    CHECK(report.terms[2].frequency == Approx(std::sqrt(2 * 5e4 / 2.0)).epsilon(1e-9));
    CHECK((report.terms[2].particle == 17 || report.terms[2].particle == 18));
    CHECK(report.terms[3].rate == 0);
    CHECK(report.terms[4].frequency == Approx(std::sqrt(1.5)).epsilon(1e-6));
    CHECK(report.stiffest == 2);
    CHECK((report.whole.particle == 17 || report.whole.particle == 18));
    CHECK(report.whole.frequency >= report.terms[2].frequency * (1 - 1e-12));
    CHECK(report.whole.exact == (6 * n <= 200));
    CHECK(mentions(report, "<- stiffest"));
  }
}

TEST_CASE("verdicts") {
  const auto y = chain_state(20);
  const auto springs = spring_network<1>(chain(20, 400));  // ω ≈ 40
  const auto ask = [&](auto scheme, double dt, PreflightOptions options = {}) {
    PhiStepper stepper{y, springs, scheme};
    return preflight(stepper, y, dt, options);
  };
  CHECK(ask(velocity_verlet, 0.01).verdict == Verdict::fine);
  CHECK(ask(velocity_verlet, 0.01));
  CHECK(ask(velocity_verlet, 0.03).verdict == Verdict::coarse);
  CHECK(ask(velocity_verlet, 0.0502).verdict == Verdict::unstable);  // 2/39.88 = 0.05015
  CHECK(ask(velocity_verlet, 0.0500).verdict == Verdict::coarse);
  CHECK(ask(forward_euler, 1e-6).verdict == Verdict::unstable);
  CHECK(ask(forward_euler, 1e-6).stable_dt == 0);
  CHECK(mentions(ask(forward_euler, 1e-6), "Never stable"));
  CHECK(ask(phi(0.3), 1e-6).stable_dt == 0);
  CHECK(ask(phi(0.3, 0.6), 1e-6).stable_dt == 0);
  CHECK(ask(trapezoidal, 1.0).stable_dt == infinite);
  CHECK(ask(trapezoidal, 1.0).verdict == Verdict::coarse);
  CHECK(mentions(ask(trapezoidal, 1.0), "ring on by a factor 1 a step"));
  CHECK(mentions(ask(backward_euler, 1.0), "damps them by a factor 0.025"));  // 1/√(1 + 39.88²)
  CHECK(ask(backward_euler, 1.0).fastest_factor == Approx(1 / std::hypot(1, 39.877)).epsilon(1e-4));
  CHECK(ask(tr_bdf2, 0.02).verdict == Verdict::coarse);
  CHECK(ask(rannacher, 0.005).verdict == Verdict::fine);
  CHECK(ask(midpoint, 0.005).recommended.scheme == "midpoint");
  // What he wants to see is slow: then a step that does not resolve the rest is fine, and said to ring.
  const auto slow = ask(trapezoidal, 0.2, {.period = 10});
  CHECK(slow.verdict == Verdict::fine);
  CHECK(mentions(slow, "tr_bdf2 would damp"));
  CHECK(ask(velocity_verlet, 0.2, {.period = 100}).recommended.scheme == "velocity_verlet");
  CHECK(ask(velocity_verlet, 1.0, {.period = 100}).recommended.scheme == "tr_bdf2");
  CHECK(ask(velocity_verlet, 1.0, {.period = 100}).recommended.dt == 1.0);
  // Contacts: ten steps.
  CHECK(ask(velocity_verlet, 0.01, {.contact_time = 0.2}).verdict == Verdict::fine);
  CHECK(ask(velocity_verlet, 0.01, {.contact_time = 0.2}).steps_per_contact == Approx(20));
  CHECK(ask(velocity_verlet, 0.01, {.contact_time = 0.05}).verdict == Verdict::coarse);
  CHECK(mentions(ask(velocity_verlet, 0.01, {.contact_time = 0.05}), "ten steps a contact"));
  CHECK(ask(velocity_verlet, 0.01, {.contact_time = 0.05}).recommended.dt == Approx(0.005));
}

TEST_CASE("accuracy: what is foretold is what happens") {
  // One oscillator, ω = 2, a = 0.2: energy after a period, and the period by the phase reached.
  const auto run = [](auto scheme, double dt) {
    Motion y{Eigen::Matrix<double, 1, 1>{1}, Eigen::Matrix<double, 1, 1>{0}};
    PhiStepper stepper{y, linear(Eigen::Matrix<double, 1, 1>{-4}), scheme};
    const auto report = preflight(stepper, y, dt);
    const int steps = 2000;
    double angle = 0, last = 0, energy = 0;
    for (int n = 0; n < steps; ++n) {
      REQUIRE(stepper.step(y, n * dt, dt));
      const double now = std::atan2(-y.v[0] / 2, y.r[0]);
      angle += std::remainder(now - last, 2 * std::numbers::pi);
      last = now;
      energy = y.r[0] * y.r[0] + y.v[0] * y.v[0] / 4;
    }
    const double exact = 2 * dt * steps;
    // (r, v/ω) turns on an ellipse that is off a circle by at most a/2 (the pairs): so are its angle and log energy/2.
    const double a = 2 * dt;
    CHECK(report.phase_error == Approx(angle / exact - 1).epsilon(0.02).margin(a / 2 / exact));
    CHECK(std::log(report.energy_per_period) == Approx(std::log(energy) * std::numbers::pi / dt / steps)
                                                    .epsilon(1e-3)
                                                    .margin(a * std::numbers::pi / dt / steps));
    CHECK(report.steps_per_period == Approx(std::numbers::pi / dt));
    CHECK(report.period == Approx(std::numbers::pi));
    return report;
  };
  CHECK(run(trapezoidal, 0.1).phase_error == Approx(-0.04 / 12).epsilon(0.01));
  CHECK(run(velocity_verlet, 0.1).phase_error == Approx(0.04 / 24).epsilon(0.01));
  CHECK(run(phi(0.6), 0.1).added_damping == Approx(0.1 * 0.2).epsilon(0.02));
  CHECK(run(backward_euler, 0.01).added_damping == Approx(0.5 * 0.02).epsilon(0.01));
  run(tr_bdf2, 0.1);
  run(phi(0.3, 0.9), 0.1);
  run(symplectic_euler, 0.1);
}

TEST_CASE("first order: ringing, growth that a step would hide, consistent capacities") {
  const Eigen::Vector2d y{0, 0};
  const auto decay = [&](auto scheme, double dt) {
    PhiStepper stepper{y, linear(Eigen::Matrix2d(Eigen::Vector2d{-1, -1000}.asDiagonal())), scheme};
    return preflight(stepper, y, dt);
  };
  CHECK(decay(forward_euler, 1e-3).stable_dt == Approx(0.999 * 2e-3));
  CHECK(decay(forward_euler, 1.5e-3).rings);
  CHECK_FALSE(decay(forward_euler, 0.9e-3).rings);
  CHECK(decay(trapezoidal, 0.1).rings);
  CHECK(decay(trapezoidal, 0.1).fastest_factor == Approx(49.0 / 51));
  CHECK(decay(trapezoidal, 0.1).unringing_dt == Approx(2e-3));
  CHECK(mentions(decay(trapezoidal, 0.1), "ring on by a factor 0.961 a step"));
  CHECK(decay(backward_euler, 0.1).unringing_dt == infinite);
  CHECK(mentions(decay(backward_euler, 0.1), "damps them by a factor 0.0099"));
  CHECK(decay(tr_bdf2, 1e-4).unringing_dt == Approx((1 + std::sqrt(2)) * 1e-3));

  PhiStepper grows{y, linear(Eigen::Matrix2d(Eigen::Vector2d{-1, 30}.asDiagonal())), backward_euler};
  CHECK(preflight(grows, y, 1.0).growth == Approx(30));
  CHECK(mentions(preflight(grows, y, 1.0), "would hide it"));

  // Linear finite elements, M = Δx/6 (1 4 1), K = (1 −2 1)/Δx: the largest λ is 12/Δx².
  const int n = 300;
  std::vector<Eigen::Triplet<double>> stiffness, capacities;
  for (int i = 0; i < n; ++i)
    for (int j = std::max(0, i - 1); j < std::min(n, i + 2); ++j) {
      stiffness.emplace_back(i, j, i == j ? -2 : 1);
      capacities.emplace_back(i, j, i == j ? 4. / 6 : 1. / 6);
    }
  Sparse K(n, n), M(n, n);
  K.setFromTriplets(stiffness.begin(), stiffness.end());
  M.setFromTriplets(capacities.begin(), capacities.end());
  const Vec u = Vec::Zero(n);
  PhiStepper heat{u, linear(K), forward_euler, capacity(M)};
  CHECK(preflight(heat, u, 0.1).whole.rate == Approx(12).epsilon(1e-3));
  CHECK(preflight(heat, u, 0.1).whole.rate >= 12 * (1 - 1e-4));
  CHECK(preflight(heat, u, 0.1).stable_dt == Approx(0.999 / 6).epsilon(1e-3));
}

TEST_CASE("nonsense gets a verdict and a sentence, never an exception") {
  auto y = chain_state(5);
  PhiStepper stepper{y, spring_network<1>(chain(5, 1)), velocity_verlet};
  for (const double dt : {0.0, -1.0, nan_value, infinite}) {
    const auto report = preflight(stepper, y, dt);
    CHECK(report.verdict == Verdict::invalid);
    CHECK(mentions(report, "dt is not positive and finite"));
    CHECK(report.stable_dt > 1);  // known all the same
    CHECK(std::isfinite(report.recommended.dt));
  }
  y.v[3] = nan_value;
  CHECK(preflight(stepper, y, 0.1).verdict == Verdict::unknown);
  CHECK(mentions(preflight(stepper, y, 0.1), "state is not finite"));
  y = chain_state(5);
  y.r[2] = infinite;
  CHECK(preflight(stepper, y, 0.1).verdict == Verdict::unknown);

  const Eigen::Vector2d u{1, 2};
  PhiStepper broken{u, [](const Eigen::Vector2d& x) -> Eigen::Vector2d { return x * nan_value; }, forward_euler};
  CHECK(preflight(broken, u, 0.1).verdict == Verdict::unknown);
  CHECK(mentions(preflight(broken, u, 0.1), "not finite"));
  PhiStepper sums{u, term([](const Eigen::Vector2d& x) -> Eigen::Vector2d {
                       return -x;
                     }) + term([](const Eigen::Vector2d& x) -> Eigen::Vector2d { return x / 0.0; }),
                  backward_euler};
  CHECK(preflight(sums, u, 0.1).verdict == Verdict::unknown);
  CHECK(preflight(sums, u, 0.1).terms[0].finite);
  CHECK_FALSE(preflight(sums, u, 0.1).terms[1].finite);
  PhiStepper throws{u,
                    [](const Eigen::Vector2d& x) -> Eigen::Vector2d {
                      return x[0] > 0 ? throw std::runtime_error("out of range") : x;
                    },
                    forward_euler};
  CHECK(preflight(throws, u, 0.1).verdict == Verdict::unknown);
  CHECK(mentions(preflight(throws, u, 0.1), "out of range"));

  const Motion none{Vec(0), Vec(0)};
  PhiStepper empty{none, [](const Vec& r) -> Vec { return r; }, velocity_verlet};
  CHECK(preflight(empty, none, 0.1).verdict == Verdict::fine);

  const auto many = chain_state(1001);
  PhiStepper opaque{many, ChainForce{1}, velocity_verlet};
  CHECK(preflight(opaque, many, 0.1).verdict == Verdict::unknown);
  CHECK(mentions(preflight(opaque, many, 0.1), "has no Jacobian"));

  // Another size than the masses fit.
  PhiStepper heavy{chain_state(5), spring_network<1>(chain(5, 1)), velocity_verlet, mass(Vec(Vec::Ones(5)))};
  CHECK(preflight(heavy, chain_state(7), 0.1).verdict == Verdict::unknown);
  CHECK(mentions(preflight(heavy, chain_state(7), 0.1), "5 masses"));
  // A force that is constant: any step will do.
  PhiStepper falls{chain_state(5), UniformForce{Eigen::Matrix<double, 1, 1>{1}}, forward_euler};
  CHECK(preflight(falls, chain_state(5), 1e6).verdict == Verdict::fine);
}

TEST_CASE("nothing is stepped and no count changes") {
  auto y = chain_state(12);
  const auto before = y;
  PhiStepper stepper{y, ChainForce{3}, trapezoidal};
  REQUIRE(stepper.step(y, 0, 0.1));
  const Statistics counts = stepper.statistics();
  auto twin = stepper;
  auto other = y;
  static_cast<void>(preflight(stepper, y, 0.1));
  CHECK(stepper.statistics() == counts);
  REQUIRE(stepper.step(y, 0.1, 0.1));
  REQUIRE(twin.step(other, 0.1, 0.1));
  CHECK(equal_blocks<Motion<Vec>>(y, other));
  CHECK(stepper.statistics() == twin.statistics());
  Halving halving{PhiStepper{before, ChainForce{3}, velocity_verlet}, 3};
  CHECK(preflight(halving, before, 0.1).whole.frequency ==
        Approx(2 * std::sqrt(3) * std::cos(std::numbers::pi / 24)).epsilon(1e-6));
}

TEST_CASE("units: scaling length, mass and time by powers of two changes no bit") {
  const auto ask = [](int n, double length, double m, double time, auto scheme) {
    Eigen::Matrix2Xd r(2, n);
    Vec masses(n);
    std::vector<Spring> springs;
    for (int i = 0; i < n; ++i) {
      r.col(i) << (i % 11 + 0.1 * std::sin(i)) * length, (i / 11 + 0.1 * std::cos(i)) * length;
      masses[i] = (1 + i % 5) * m;
      if (i > 0 && i % 11 > 0) springs.push_back({i - 1, i, (3 + i % 7) * m / (time * time), length});
      if (i >= 11) springs.push_back({i - 11, i, (2 + i % 3) * m / (time * time), length});
    }
    const Motion y{r, Eigen::Matrix2Xd(0.1 / time * r)};
    PhiStepper stepper{y, spring_network<2>(springs) + LinearDrag{0.3 * m / time}, scheme, mass(masses)};
    return preflight(stepper, y, 0.3 * time);
  };
  const auto compare = [&](int n, auto scheme) {
    const auto one = ask(n, 1, 1, 1, scheme), two = ask(n, 0x1p-30, 0x1p-81, 0x1p-41, scheme);
    CHECK(two.stable_dt == one.stable_dt * 0x1p-41);
    CHECK(two.accurate_dt == one.accurate_dt * 0x1p-41);
    CHECK(two.whole.frequency == one.whole.frequency * 0x1p41);
    CHECK(two.whole.damping == one.whole.damping * 0x1p41);
    CHECK(two.phase_error == one.phase_error);
    CHECK(two.verdict == one.verdict);
    CHECK(two.whole.particle == one.whole.particle);
  };
  compare(20, velocity_verlet);  // by the step's matrix
  compare(20, symplectic_euler);
  compare(121, velocity_verlet);  // by bounds
  compare(121, forward_euler);
}

TEST_CASE("float, long double, maps, several blocks, memory") {
  Motion<Eigen::Vector2f> f{{1, 0}, {0, 0}};
  PhiStepper single{f, [](const Eigen::Vector2f& r) -> Eigen::Vector2f { return -4 * r; }, velocity_verlet};
  CHECK(preflight(single, f, 0.1).stable_dt == Approx(0.999).epsilon(1e-3));
  using Long = Eigen::Matrix<long double, 2, 1>;
  Motion<Long> l{Long{1, 0}, Long{0, 0}};
  PhiStepper extended{l, [](const Long& r) -> Long { return -4 * r; }, velocity_verlet};
  CHECK(preflight(extended, l, 0.1).stable_dt == Approx(0.999).epsilon(1e-8));
  double memory[] = {1, 0, 0, 0};
  using Mapped = Eigen::Map<Eigen::Vector2d>;
  Motion<Mapped> map{Mapped(memory), Mapped(memory + 2)};
  PhiStepper mapped{map, [](const Eigen::Vector2d& r) -> Eigen::Vector2d { return -4 * r; }, velocity_verlet};
  CHECK(preflight(mapped, map, 0.1).stable_dt == Approx(0.999).epsilon(1e-8));
}

namespace {

/// r, v and a temperature that decays and drags.
struct Warm {
  Eigen::Vector2d r, v;
  Eigen::Matrix<double, 1, 1> T;
  static constexpr bool drifts = true;
  static auto blocks(auto& y) { return std::tie(y.r, y.v, y.T); }
  struct Rate {
    Eigen::Vector2d force;
    Eigen::Matrix<double, 1, 1> heat;
    static auto blocks(auto& rate) { return std::tie(rate.force, rate.heat); }
  };
};
struct WarmForce {
  void add(double, const auto& y, auto& out) const {
    out.force += -4 * y.r - 0.1 * y.v;
    out.heat -= 50 * y.T;
  }
};
/// A spring whose rest position is remembered.
struct Remembers {
  struct Memory {
    double stiffness = 9;
  };
  void begin(double, double, const auto&, Memory&) const {}
  void add(double, const auto& y, const Memory& memory, auto& out) const { out.force -= memory.stiffness * y.r; }
  void commit(double, const auto&, Memory&) const {}
};

}  // namespace

TEST_CASE("a state of three blocks, a force with memory") {
  const Warm y{{1, 0}, {0, 1}, Eigen::Matrix<double, 1, 1>{3}};
  PhiStepper stepper{y, WarmForce{}, forward_euler};
  const auto report = preflight(stepper, y, 1e-3);
  CHECK(report.whole.rate == Approx(50).epsilon(1e-6));
  CHECK(report.stable_dt == Approx(0.999 * 0.1 / 4).epsilon(1e-5));  // the oscillator's c/ω², below 2/50

  const Motion one{Eigen::Vector2d{1, 0}, Eigen::Vector2d{0, 0}};
  PhiStepper remembering{one, Remembers{}, velocity_verlet};
  CHECK(preflight(remembering, one, 0.1).whole.frequency == Approx(3).epsilon(1e-6));
  remembering.set_memory({25});
  CHECK(preflight(remembering, one, 0.1).whole.frequency == Approx(5).epsilon(1e-6));
}

TEST_CASE("the text holds the numbers") {
  const auto y = chain_state(20);
  PhiStepper stepper{y, spring_network<1>(chain(20, 400)) + LinearDrag{0.5}, velocity_verlet};
  std::ostringstream out;
  out << preflight(stepper, y, 0.06);
  for (const char* piece : {"preflight: unstable", "stable to 0.0501", "omega = 39.9", "damping = 0.5", "term 0",
                            "<- stiffest", "recommended", "velocity_verlet", "fixed("})
    CHECK_THAT(out.str(), contains(piece));
}

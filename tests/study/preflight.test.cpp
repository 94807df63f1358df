// Preflight's Δt is stable, one and a half times it is not: on scenes that are run, not on formulas alone. And what it
// says of terms, accuracy, contacts and nonsense.
// All of preflight is half a minute of compiling, so this one file is the quick half of assess and stable_step, too.
#include "study/preflight_cases.hpp"
#if PHISTEP_FULL
#include "study/assess_cases.hpp"
#include "support/shared_force.hpp"
#endif

#if PHISTEP_FULL

using namespace phistep;
using namespace assess_cases;
using preflight_cases::check_scene;
using Force = shared_force::OfState<Vec>;

namespace {

PreflightReport ask_function(const Motion<Vec>& y, const Force& force, double dt) {
  PhiStepper stepper{y, force, velocity_verlet};
  return preflight(stepper, y, dt);
}
PreflightReport ask_verlet(double dt, const PreflightOptions& options = {}) {
  const auto y = chain_state(20);
  PhiStepper stepper{y, spring_network<1>(chain(20, 400)), velocity_verlet, mass(1.0)};  // ω ≈ 40
  return preflight(stepper, y, dt, options);
}
/// Contacts that take a known time, and push nobody.
struct Impacts : ForceTerm {
  double time;
  explicit Impacts(double of) : time{of} {}
  void add(double, const auto&, auto&) const {}
  void add_jacobian(double, const auto&, auto&) const {}
  [[nodiscard]] double contact_time(const auto&) const { return time; }
};
/// r'' = K r + C r', without a stepper: each of those is compiled anew.
LinearizedProblem linearized(const SparseRows& K, const SparseRows& C) {
  LinearizedProblem problem;
  problem.whole = problem.rest = {K, C};
  problem.masses.lumped = Vec::Ones(K.rows());
  problem.tolerance = 1e-9;
  return problem;
}
/// The same chain in phi(phi).
PreflightReport ask_phi(double phi, double dt, const PreflightOptions& options = {}) {
  const auto problem = linearized(SparseRows(chain_matrix(20, 400)), SparseRows(20, 20));
  PreflightReport report;
  report.dt = dt;
  Assessment<>{problem, {Method::Kind::single, phi, phi}, "phi", options, report}.run();
  return report;
}
PreflightReport ask_decay(double dt, double growth = -1) {
  const Vec y = Vec::Zero(2);
  Sparse A(2, 2);
  A.insert(0, 0) = growth, A.insert(1, 1) = -1000;
  PhiStepper stepper{y, linear(A), forward_euler};
  return preflight(stepper, y, dt);
}

}  // namespace

TEST_CASE("stable at preflight's dt, not at 1.5 times it: motion, Verlet") {
  const auto y = chain_state(400);
  const auto report = check_scene("chain, velocity_verlet",
                                  PhiStepper{y, spring_network<1>(chain(400, 300)), velocity_verlet, mass(2.0)}, y);
  // ω = 2√(k/m) for an endless chain.
  CHECK(report.stable_dt == Approx(0.999 * 2 / (2 * std::sqrt(150.0))).epsilon(1e-6));
}

TEST_CASE("stable at preflight's dt, not at 1.5 times it: motion, other schemes and damping") {
  const auto y = chain_state(300);
  const auto springs = spring_network<1>(chain(300, 300));
  check_scene("chain and drag, symplectic_euler",
              PhiStepper{y, springs + LinearDrag{20.0}, symplectic_euler, mass(2.0)}, y);
}

TEST_CASE("stable at preflight's dt, not at 1.5 times it: first order") {
  const Vec u = Vec::Zero(300);
  const auto report =
      check_scene("diffusion in 1-D, forward_euler", PhiStepper{u, linear(chain_matrix(300, 50.0)), forward_euler}, u);
  CHECK(report.stable_dt == Approx(0.999 * 2 / 200).epsilon(1e-3));
  CHECK(report.unringing_dt == Approx(1.0 / 200).epsilon(1e-3));
}

TEST_CASE("schemes without a formula are known by their own steps") {
  // rodas4 is of order 4 and L-stable; rkn86's polynomial grows without bound.
  const Method stiff = method_of(rodas4);
  for (const std::complex<double> z : {std::complex{-0.1, 0.0}, std::complex{0.05, 0.08}})
    CHECK(std::abs(stiff.factor(z) - std::exp(z)) < 0.05 * std::pow(std::abs(z), 5));
  CHECK(std::abs(stiff.factor(-1e6)) < 1e-4);
  CHECK(stiff.is_a_stable());
  // A window of growth, from 3.14146 to 3.14234: docs/stability.md, section 1.
  CHECK(method_of(srkn11b).oscillation_limit() == Approx(3.14146).epsilon(1e-5));
  const auto y = chain_state(20);
  const auto report =
      check_scene("chain, rkn86", PhiStepper{y, spring_network<1>(chain(20, 300)), rkn86, mass(2.0)}, y);
  CHECK(report.stable_dt > 0);
  Vec u = Vec::LinSpaced(3, 0.0, 1.0);
  const auto decay = [](const Vec& x) -> Vec { return -50 * x; };
  PhiStepper stepper{u, decay, rodas4};
  CHECK(std::isinf(preflight(stepper, u, 1.0).stable_dt));
}

TEST_CASE("every structure gives the same bound") {
  for (const int n : {50, 300}) {
    const auto y = chain_state(n);
    const double k = 8, m = 2;
    PhiStepper network{y, spring_network<1>(chain(n, k)), velocity_verlet, mass(m)};
    check_structure("network", n, preflight(network, y, 0.01), 1e-12);
    // Differences: increments √u × position/16 … position.
    check_structure("differences", n, ask_function(y, ChainForce{k / m}, 0.01), 1e-5);
  }
}

TEST_CASE("each term's rates, and which is stiffest where") {
  for (const int n : {30, 200}) {  // exact, bounds
    auto springs = chain(n, 100);
    springs.push_back({17, 18, 5e4, 1.0});
    const auto y = chain_state(n);
    PhiStepper stepper{y, spring_network<1>(springs) + LinearDrag{0.6}, symplectic_euler, mass(2.0)};
    const auto report = preflight(stepper, y, 1e-3);
    REQUIRE(report.terms.size() == 2);
    CHECK(report.terms[0].frequency == Approx(std::sqrt(2 * 5e4 / 2.0)).epsilon(0.01));
    CHECK((report.terms[0].component == 17 || report.terms[0].component == 18));
    CHECK(report.terms[1].frequency == 0);
    CHECK(report.terms[1].damping == Approx(0.3).epsilon(1e-12));
    CHECK(report.stiffest == 0);
    CHECK((report.whole.component == 17 || report.whole.component == 18));
    CHECK(report.whole.frequency >= report.terms[0].frequency * (1 - 1e-12));
    CHECK(report.whole.exact == (2 * n <= 200));
    CHECK(mentions(report, "<- stiffest"));
  }
}

TEST_CASE("verdicts") {
  CHECK(ask_verlet(0.01).verdict == Verdict::fine);
  CHECK(ask_verlet(0.01));
  CHECK(ask_verlet(0.03).verdict == Verdict::coarse);
  CHECK(ask_verlet(0.0502).verdict == Verdict::unstable);  // 2/39.88 = 0.05015
  CHECK(ask_verlet(0.0500).verdict == Verdict::coarse);
  CHECK(ask_phi(0.0, 1e-6).verdict == Verdict::unstable);
  CHECK(ask_phi(0.0, 1e-6).stable_dt == 0);
  CHECK(mentions(ask_phi(0.0, 1e-6), "Never stable"));
  CHECK(ask_phi(0.3, 1e-6).stable_dt == 0);
  CHECK(ask_phi(0.5, 1.0).stable_dt == infinite);
  CHECK(ask_phi(0.5, 1.0).verdict == Verdict::coarse);
  CHECK(mentions(ask_phi(0.5, 1.0), "ring on by a factor 1 a step"));
  CHECK(mentions(ask_phi(1.0, 1.0), "damps them by a factor 0.025"));  // 1/√(1 + 39.88²)
  CHECK(ask_phi(1.0, 1.0).fastest_factor == Approx(1 / std::hypot(1, 39.877)).epsilon(1e-4));
  // What he wants to see is slow: then a step that does not resolve the rest is fine, and said to ring.
  const auto slow = ask_phi(0.5, 0.2, {.period = 10});
  CHECK(slow.verdict == Verdict::fine);
  CHECK(mentions(slow, "tr_bdf2 would damp"));
  CHECK(ask_verlet(0.2, {.period = 100}).recommended.scheme == "velocity_verlet");
  CHECK(ask_verlet(1.0, {.period = 100}).recommended.scheme == "tr_bdf2");
  CHECK(ask_verlet(1.0, {.period = 100}).recommended.dt == 1.0);
  // Contacts: ten steps.
  CHECK(ask_verlet(0.01, {.contact_time = 0.2}).verdict == Verdict::fine);
  CHECK(ask_verlet(0.01, {.contact_time = 0.2}).steps_per_contact == Approx(20));
  CHECK(ask_verlet(0.01, {.contact_time = 0.05}).verdict == Verdict::coarse);
  CHECK(mentions(ask_verlet(0.01, {.contact_time = 0.05}), "ten steps a contact"));
  CHECK(ask_verlet(0.01, {.contact_time = 0.05}).recommended.dt == Approx(0.005));
}

TEST_CASE("of several terms with contacts the shortest impact counts, unless the user names one") {
  const auto y = chain_state(20);
  PhiStepper stepper{y, Impacts{0.2} + spring_network<1>(chain(20, 400)) + Impacts{0.05} + Impacts{0.1},
                     velocity_verlet};
  const auto report = preflight(stepper, y, 0.01);
  CHECK(report.steps_per_contact == Approx(5));
  CHECK(report.verdict == Verdict::coarse);
  CHECK(preflight(stepper, y, 0.01, {.contact_time = 0.4}).steps_per_contact == Approx(40));
}

TEST_CASE("accuracy: what is foretold is what happens") {
  // One oscillator, ω = 2, a = 0.2: the period by the phase reached.
  const double dt = 0.1;
  const int steps = 2000;
  Motion<Vec> y{Vec::Ones(1), Vec::Zero(1)};
  PhiStepper stepper{y, Force{[](const Vec& r) -> Vec { return -4 * r; }}, velocity_verlet};
  const auto report = preflight(stepper, y, dt);
  double angle = 0, last = 0;
  for (int n = 0; n < steps; ++n) {
    REQUIRE(stepper.step(y, n * dt, dt));
    const double now = std::atan2(-y.v[0] / 2, y.r[0]);
    angle += std::remainder(now - last, 2 * std::numbers::pi);
    last = now;
  }
  const double exact = 2 * dt * steps;
  CHECK(report.phase_error == Approx(angle / exact - 1).epsilon(0.02).margin(dt / exact));
  CHECK(report.phase_error == Approx(0.04 / 24).epsilon(0.01));
  CHECK(report.steps_per_period == Approx(std::numbers::pi / dt));
  CHECK(report.period == Approx(std::numbers::pi));
}

TEST_CASE("first order: ringing, growth that a step would hide, consistent capacities") {
  CHECK(ask_decay(1e-3).stable_dt == Approx(0.999 * 2e-3));
  CHECK(ask_decay(1.5e-3).rings);
  CHECK_FALSE(ask_decay(0.9e-3).rings);
  CHECK(ask_decay(0.1, 30).growth == Approx(30));
}

TEST_CASE("nonsense gets a verdict and a sentence, never an exception") {
  const auto y = chain_state(5);
  PhiStepper stepper{y, spring_network<1>(chain(5, 1)), velocity_verlet, mass(1.0)};
  check_nonsense([&](const Motion<Vec>& state, double dt) { return preflight(stepper, state, dt); });

  const auto few = chain_state(2);
  const auto broken = ask_function(
      few, [](const Vec& x) -> Vec { return x * nan_value; }, 0.1);
  CHECK(broken.verdict == Verdict::unknown);
  CHECK(mentions(broken, "not finite"));
  const auto throws = ask_function(
      few, [](const Vec&) -> Vec { throw std::runtime_error("out of range"); }, 0.1);
  CHECK(throws.verdict == Verdict::unknown);
  CHECK(mentions(throws, "out of range"));
  CHECK(ask_function(
            {Vec(0), Vec(0)}, [](const Vec& r) -> Vec { return r; }, 0.1)
            .verdict == Verdict::fine);
  const auto opaque = ask_function(chain_state(1001), ChainForce{1}, 0.1);
  CHECK(opaque.verdict == Verdict::unknown);
  CHECK(mentions(opaque, "has no Jacobian"));
}

TEST_CASE("nothing is stepped and no count changes") {
  auto y = chain_state(12);
  PhiStepper stepper{y, Force{ChainForce{3}}, velocity_verlet};
  check_nothing_stepped(stepper, y);
}

TEST_CASE("units: scaling length, mass and time by powers of two changes no bit") {
  const auto ask = [](int n, double length, double m, double time) {
    std::vector<Spring> springs;
    for (int i = 0; i + 1 < n; ++i) springs.push_back({i, i + 1, (3 + i % 7) * m / (time * time), length});
    Vec r = Vec::LinSpaced(n, 0, n - 1);
    for (int i = 0; i < n; ++i) r[i] = length * (r[i] + 0.1 * std::sin(i));
    const Motion<Vec> y{r, Vec(0.1 / time * r)};
    PhiStepper stepper{y, spring_network<1>(springs) + LinearDrag{0.3 * m / time}, symplectic_euler, mass(m)};
    return preflight(stepper, y, 0.3 * time);
  };
  for (const int n : {20, 121}) {  // by the step's matrix, by bounds
    const auto one = ask(n, 1, 1, 1), two = ask(n, 0x1p-30, 0x1p-81, 0x1p-41);
    check_units(one, two);
    CHECK(two.whole.component == one.whole.component);
  }
}

TEST_CASE("the text holds the numbers") {
  const auto y = chain_state(20);
  PhiStepper stepper{y, spring_network<1>(chain(20, 400)) + LinearDrag{0.5}, symplectic_euler, mass(1.0)};
  std::ostringstream out;
  out << preflight(stepper, y, 0.06);
  for (const char* piece : {"preflight: unstable", "omega = 39.9", "damping = 0.5", "term 0", "<- stiffest",
                            "recommended", "velocity_verlet", "fixed("})
    CHECK_THAT(out.str(), contains(piece));
}

TEST_CASE("where there is none, none is claimed") {
  const auto matrix = [](const std::vector<Eigen::Triplet<double>>& entries) {
    SparseRows A(2, 2);
    A.setFromTriplets(entries.begin(), entries.end());
    return A;
  };
  const SparseRows K = matrix({{0, 0, -2}, {1, 1, -5}}), drives = matrix({{0, 0, 2}, {1, 1, 5}}),
                   turns = matrix({{0, 1, 1}, {1, 0, -1}}), none(2, 2);
  const auto ask = [](const SparseRows& stiffness, const SparseRows& damping, Method method) {
    const auto problem = linearized(stiffness, damping);
    return stable_step(method, problem, bound_spectrum(problem.whole, problem.masses, 0, 1e-9));
  };
  using Kind = Method::Kind;
  CHECK(std::isnan(ask(turns, none, {Kind::verlet, 0.5, 0.5})));  // not a potential's
  CHECK(std::isnan(ask(K, drives, {Kind::verlet, 0.5, 0.5})));    // damping that drives
  CHECK(std::isnan(ask(K, turns, {Kind::pair, 0, 1})));           // gyroscopic
  CHECK(std::isnan(ask(K, turns, {Kind::pair, 1, 0})));
  CHECK(ask(K, none, {Kind::single, 0, 0}) == 0);
  CHECK(std::isinf(ask(turns, turns, {Kind::single, 0.5, 0.5})));  // A-stable
  CHECK(ask(K, K, {Kind::verlet, 0.5, 0.5}) == Approx(2 / std::sqrt(5.0)));
}

#elif PHISTEP_STRESS
// preflight, the full list of scenes.

using namespace preflight_cases;

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

TEST_CASE("stable at preflight's dt, not at 1.5 times it: first order") {
  {
    const Vec u = Vec::Zero(500);
    const auto report = check_scene("heat in 1-D, forward_euler",
                                    PhiStepper{u, problems::Heat<Eigen::SparseMatrix<double>>(500), forward_euler}, u);
    const double dx = 1.0 / 501;
    CHECK(report.stable_dt == Approx(0.999 * dx * dx / 2).epsilon(1e-6));
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

#endif

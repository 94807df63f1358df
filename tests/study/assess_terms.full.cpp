// assess, its dear cases: terms, nonsense, units. In short: tests/study/preflight.test.cpp.
#include "study/assess_cases.hpp"

using namespace assess_cases;

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

TEST_CASE("nonsense gets a verdict and a sentence, never an exception") {
  const auto y = chain_state(5);
  PhiStepper stepper{y, spring_network<1>(chain(5, 1)), velocity_verlet};
  check_nonsense([&](const Motion<Vec>& state, double dt) { return preflight(stepper, state, dt); });

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
    check_units(one, two);
    CHECK(two.whole.particle == one.whole.particle);
  };
  compare(20, velocity_verlet);  // by the step's matrix
  compare(20, symplectic_euler);
  compare(121, velocity_verlet);  // by bounds
  compare(121, forward_euler);
}

#include "particles/pairs/all_pairs_cases.hpp"

using namespace all_pairs_cases;

TEMPLATE_TEST_CASE("the force is the sum over all pairs", "", (Particles<double, 3>), (Particles<float, 3>)) {
  check_sums<TestType>();
}

TEST_CASE("Coulomb, user laws and their weights") {
  const auto y = cloud<double, 3>(70);
  AllPairs coulomb{Coulomb{3.0}};
  check_against_sum(
      y, force_on(coulomb, y), [](long double r2) { return 3 / (r2 * std::sqrt(r2)); }, y.charge());
}

TEST_CASE("it adds; particles held still act but get no force, and cost no pairs among themselves") {
  auto y = cloud<double, 3>(40);
  AllPairs gravity{SoftenedGravity{2.0, 0.1}};
  const Eigen::Matrix3Xd free = force_on(gravity, y);
  std::vector<std::uint8_t> still(40, 0);
  for (const std::size_t i : {0u, 3u, 4u, 17u, 39u}) still[i] = 1;
  y.set_still(still);
  auto out = make_rate<Particles<double, 3>>(y);
  out.force.setConstant(100);
  const auto masses = Particles<double, 3>::masses(y);
  add_force(gravity, 0.0, Blocks<Particles<double, 3>>::view(y, masses), NoMemory{}, out);
  for (Index i = 0; i < 40; ++i)
    CHECK((out.force.col(i).array() - 100 - (y.body().is_still(i) ? 0 : 1) * free.col(i).array()).abs().maxCoeff() <=
          1e-11);
  // Only pairs with somebody that moves have an energy here; as Σ over all pairs minus Σ over still ones.
  double sum = 0;
  for (Index i = 0; i < 40; ++i)
    for (Index j = 0; j < i; ++j)
      if (!y.body().is_still(i) || !y.body().is_still(j))
        sum -= 2 * y.mass()[i] * y.mass()[j] / std::sqrt((y.r.col(i) - y.r.col(j)).squaredNorm() + 0.01);
  CHECK(energy_of(gravity, y) == Approx(sum).epsilon(1e-13));
  y.set_still(std::vector<std::uint8_t>(40, 1));
  CHECK((force_on(gravity, y).norm() == 0 && energy_of(gravity, y) == 0));
  CHECK(check_jacobian(gravity, cloud<double, 3>(7).set_still({0, 1, 0, 0, 0, 0, 1})));
}

TEST_CASE("tangents: by differentiation of the law, like differences") {
  CHECK(check_jacobian(AllPairs{SoftenedGravity{2.0, 0.3}}, cloud<double, 3>(9)));
}

TEST_CASE("the force is minus the energy's gradient") {
  for (const Index n : {3, 30}) {
    const auto y = cloud<double, 3>(n);
    const auto check = [&](auto force) {
      const Eigen::Matrix3Xd f = force_on(force, y);
      for (Index k = 0; k < 9; ++k) {
        auto up = y, down = y;
        up.r.data()[k] += 1e-5, down.r.data()[k] -= 1e-5;
        // Central differences: h² V'''/6 with V''' ≲ 1e4 w²/ε⁴ …, rounding 1e-16 |V|/h ≈ 1e-8.
        CHECK(f.data()[k] ==
              Approx(-(energy_of(force, up) - energy_of(force, down)) / 2e-5).epsilon(1e-5).margin(1e-5));
      }
    };
    check(AllPairs{SoftenedGravity{2.0, 0.2}});
    check(AllPairs{Coulomb{3.0, 0.2}});
  }
}

TEST_CASE("scaling length and mass by powers of two changes no bit") {
  const auto y = cloud<double, 3>(300);
  AllPairs gravity{SoftenedGravity{1.0, 0.125}};
  const Eigen::Matrix3Xd f = force_on(gravity, y);
  const double V = energy_of(gravity, y);
  for (const int k : {-60, 7, 40}) {
    const double length = std::ldexp(1.0, k), mass = std::ldexp(1.0, 2 - k);
    auto z = y;
    z.r *= length;
    z.set_mass((mass * y.mass()).eval());
    AllPairs scaled{SoftenedGravity{1.0, 0.125 * length}};
    CHECK(same_bits((force_on(scaled, z) / (mass * mass) * length * length).eval(), f));
    CHECK(energy_of(scaled, z) / (mass * mass) * length == V);
  }
}

TEST_CASE("a second call, a copy and any number of threads give the same bits") {
  const auto y = cloud<double, 3>(1500);
  AllPairs gravity{SoftenedGravity{2.0, 0.1}};
  const Eigen::Matrix3Xd f = force_on(gravity, y);
  auto copy = gravity;
  CHECK((same_bits(force_on(gravity, y), f) && same_bits(force_on(copy, y), f)));
#ifdef _OPENMP
  const double V = energy_of(gravity, y);
  for (const int threads : {1, 2, 3}) {
    omp_set_num_threads(threads);
    CHECK((same_bits(force_on(gravity, y), f) && energy_of(gravity, y) == V));
  }
#endif
}

TEST_CASE("two at one place: named where the law has no limit, no force where it has") {
  for (const Index n : {4, 50}) {
    auto y = cloud<double, 3>(n);
    y.r.col(3) = y.r.col(1);
    AllPairs softened{SoftenedGravity{1, 0.1}}, points{SoftenedGravity{1, 0}};
    CHECK(force_on(softened, y).allFinite());
    const Eigen::Matrix3Xd f = force_on(points, y);
    for (Index i = 0; i < n; ++i) CHECK(f.col(i).allFinite() == (i != 1 && i != 3));
    PhiStepper stepper{y, points, velocity_verlet};
    const auto report = stepper.step(y, 0, 0.1);
    CHECK(!report);
    CHECK_THAT(report.message(), contains("1"));
  }
}

TEST_CASE("a particle at no finite place is named, whoever else there is") {
  AllPairs points{SoftenedGravity{1, 0}};
  for (const Index n : {4, 50})
    for (const double nowhere : {std::nan(""), HUGE_VAL})
      for (const Index first_or_later : {0, 2}) {
        auto y = cloud<double, 3>(n);
        y.r(1, first_or_later) = nowhere;
        const Eigen::Matrix3Xd f = force_on(points, y);
        for (Index i = 0; i < n; ++i) CHECK(f.col(i).allFinite() == (i != first_or_later));
        CHECK(std::isnan(energy_of(points, y)));
      }
}

TEST_CASE("what can't be summed is refused") {
  auto y = cloud<double, 3>(10);
  AllPairs gravity{SoftenedGravity{1, 0.1}};
  AllPairs charges{Coulomb{1}};
  y.set_charge(Eigen::VectorXd(0));
  CHECK_THROWS_AS(force_on(charges, y), std::invalid_argument);
  y.set_box(Box<double, 3>::periodic(-Eigen::Vector3d::Ones(), Eigen::Vector3d::Ones()));
  CHECK_THROWS_AS(force_on(gravity, y), std::invalid_argument);
  CHECK_THROWS_AS((AllPairs{SoftenedGravity{1, -0.1}}), std::invalid_argument);
  CHECK_THROWS_AS((AllPairs{SoftenedGravity{std::nan(""), 0.1}}), std::invalid_argument);
  CHECK_THROWS_AS((AllPairs{Coulomb{HUGE_VAL}}), std::invalid_argument);
  const Particles<double, 3> nobody;
  CHECK(force_on(gravity, nobody).size() == 0);
  CHECK(energy_of(gravity, nobody) == 0);
}

TEST_CASE("two bodies on a circle: back after a period") {
  // m = 1 and 3 at distance 2, G = 5: ω² = G (m₁ + m₂)/d³.
  Eigen::Matrix3Xd r = Eigen::Matrix3Xd::Zero(3, 2), v = r;
  const double omega = std::sqrt(5 * 4.0 / 8);
  r.row(0) << -1.5, 0.5;
  v.row(1) << -1.5 * omega, 0.5 * omega;
  Particles<double, 3> y{r, v};
  y.set_mass(Eigen::Vector2d(1, 3));
  PhiStepper stepper{y, AllPairs{SoftenedGravity{5, 0}}, velocity_verlet};
  const int n = 2000;
  const double dt = 2 * std::acos(-1.0) / omega / n;
  for (int k = 0; k < n; ++k) REQUIRE(stepper.step(y, k * dt, dt));
  // Verlet's circle of this radius turns by θ a step, 2 − 2 cos θ = (ωΔt)², and has the speed ωr (1 − θ²/8): ours starts too
  // fast, on an ellipse of a period longer by 3/8 θ², less the θ²/24 by which Verlet's angles run ahead. Lag: 2π θ²/3.
  const double theta = omega * dt;
  CHECK((y.r - r).norm() == Approx(r.norm() * 2 * std::acos(-1.0) * theta * theta / 3).epsilon(0.01));
}

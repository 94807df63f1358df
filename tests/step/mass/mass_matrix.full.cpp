// Mass matrices, masses of several blocks and masses that do not fit. In short: mass.test.cpp.
#include "step/mass/mass_cases.hpp"
//
#include <phistep/sparse.hpp>

namespace {
Eigen::SparseMatrix<double> sparse(const Eigen::MatrixXd& dense) { return dense.sparseView(); }
}  // namespace

using namespace mass_cases;

TEST_CASE("a mass that is no longer finite in the state's scalar throws") {
  const Eigen::Vector2f y(1, 2);
  const auto force = [](const Eigen::Vector2f& x) -> Eigen::Vector2f { return -x; };
  CHECK_THROWS_AS((PhiStepper{y, force, forward_euler, mass(1e300)}), std::invalid_argument);
  CHECK_THROWS_AS((PhiStepper{y, force, forward_euler, mass(1e-300)}), std::invalid_argument);
}

TEST_CASE("as many masses as the state has neither components nor particles throw") {
  const Dynamic y = Dynamic::Ones(6);
  const Motion<Columns> motion{Columns::Ones(3, 2), Columns::Ones(3, 2)};
  for (const Eigen::Index n : {0, 1, 3, 5, 7, 12}) {
    CAPTURE(n);
    const Eigen::VectorXd masses = Eigen::VectorXd::Ones(n);
    const Eigen::MatrixXd matrix = Eigen::MatrixXd::Identity(n, n);
    CHECK_THROWS_AS((PhiStepper{y, Pull{}, forward_euler, mass(masses)}), std::invalid_argument);
    CHECK_THROWS_AS((PhiStepper{motion, Pull{}, forward_euler, mass(masses)}), std::invalid_argument);
    if (n > 0) CHECK_THROWS_AS((PhiStepper{y, Pull{}, forward_euler, mass(matrix)}), std::invalid_argument);
    if (n > 0) CHECK_THROWS_AS((PhiStepper{y, Pull{}, forward_euler, mass(sparse(matrix))}), std::invalid_argument);
  }
}

TEST_CASE("a mass matrix that is not square or not finite throws") {
  Eigen::MatrixXd m = Eigen::MatrixXd::Identity(3, 3);
  for (const double bad : {NaN, inf}) {
    m(1, 1) = bad;
    CAPTURE(bad);
    CHECK_THROWS_AS(mass(m), std::invalid_argument);
    CHECK_THROWS_AS(mass(sparse(m)), std::invalid_argument);
  }
  CHECK_THROWS_AS(mass(Eigen::MatrixXd::Ones(2, 3)), std::invalid_argument);
  CHECK_THROWS_AS(mass(Eigen::SparseMatrix<double>(2, 3)), std::invalid_argument);
}

TEST_CASE("a mass matrix of motion is symmetric and positive definite, a capacity matrix need not be") {
  const auto with = [](double a, double b, double c, double d) { return Eigen::MatrixXd{{a, b}, {c, d}}; };
  const auto steps = [](const auto& m) {
    Motion<Dynamic> y{Dynamic::Ones(2), Dynamic::Ones(2)};
    PhiStepper stepper{y, DampedPull{}, trapezoidal, mass(m)};
    REQUIRE(stepper.step(y, 0, 0.1));
  };
  const auto flows = [](const auto& m) {
    Dynamic y = Dynamic::Ones(2);
    PhiStepper stepper{y, Pull{}, trapezoidal, capacity(m)};
    REQUIRE(stepper.step(y, 0, 0.1));
  };
  for (const Eigen::MatrixXd& bad : {with(1, 2, 2, 1), with(-1, 0, 0, -1), with(2, 1, 0, 2), with(1, 1e-12, 0, 1)}) {
    CAPTURE(bad);
    CHECK_THROWS_AS(steps(bad), std::invalid_argument);
    CHECK_THROWS_AS(steps(sparse(bad)), std::invalid_argument);
    flows(bad), flows(sparse(bad));
  }
  // Rounding of an assembly is no asymmetry, and units are no indefiniteness.
  for (const Eigen::MatrixXd& good : {with(2, 1, std::nextafter(1.0, 2.0), 2), with(1e-12, 0.9, 0.9, 1e12)}) {
    CAPTURE(good);
    steps(good), steps(sparse(good));
  }
}

TEST_CASE("a mass matrix that couples components is the same for explicit and implicit schemes") {
  // M y' = −K y has the same solution as y' = −M⁻¹K y.
  Eigen::MatrixXd M = Eigen::MatrixXd::Identity(6, 6) * 2;
  M(0, 4) = M(4, 0) = 0.7, M(1, 2) = -0.5, M(5, 3) = 0.3;
  const Eigen::MatrixXd inverse = M.inverse();
  const auto expected = [&](auto scheme) {
    FirstOrder<Dynamic> c;
    const auto force = [&](const Dynamic& y) -> Dynamic { return inverse * Pull{}(y); };
    PhiStepper stepper{c.state, force, scheme};
    for (int n = 0; n < 20; ++n) REQUIRE(stepper.step(c.state, 0, 0.05));
    return numbers(c.state);
  };
  const auto with = [&](auto scheme, const auto& m) {
    FirstOrder<Dynamic> c;
    PhiStepper stepper{c.state, Pull{}, scheme, m};
    for (int n = 0; n < 20; ++n) REQUIRE(stepper.step(c.state, 0, 0.05));
    return numbers(c.state);
  };
  const auto check = [&](auto scheme) {
    CHECK(distance(with(scheme, capacity(M)), expected(scheme)) <= 1e-12);
    CHECK(distance(with(scheme, capacity(sparse(M))), expected(scheme)) <= 1e-12);
  };
  check(forward_euler), check(phi(0.7));
}

TEST_CASE("a mass matrix numbers the components of a row-major state alike in explicit and implicit schemes") {
  Eigen::MatrixXd M = Eigen::MatrixXd::Identity(6, 6) * 2;
  M(0, 1) = 0.9, M(4, 2) = 0.4;
  const auto step = [&](auto scheme) {
    FirstOrder<RowMajor> c;
    PhiStepper stepper{c.state, Pull{}, scheme, mass(M)};
    REQUIRE(stepper.step(c.state, 0, 1e-7));
    return numbers(c.state);
  };
  CHECK(distance(step(forward_euler), step(backward_euler)) <= 1e-12);  // they differ by O(Δt²)
}

TEST_CASE("phi = 0 with a mass matrix needs neither Newton nor Jacobian") {
  FirstOrder<Dynamic> c;
  PhiStepper stepper{c.state, Pull{}, forward_euler, mass(Eigen::MatrixXd(Eigen::MatrixXd::Identity(6, 6) * 3))};
  for (int n = 0; n < 10; ++n) REQUIRE(stepper.step(c.state, 0, 0.01));
  CHECK(stepper.statistics() == Statistics{.steps = 10, .force_calls = 10});
}

TEST_CASE("one mass per solved block of a user's own state") {
  Coupled a, b;
  PhiStepper light{a.state, WarmPull{}, trapezoidal, mass(1.0, 1.0)};
  PhiStepper unit{b.state, WarmPull{}, trapezoidal};
  for (int n = 0; n < 10; ++n) {
    REQUIRE(light.step(a.state, 0, 0.1));
    REQUIRE(unit.step(b.state, 0, 0.1));
  }
  CHECK(distance(numbers(a.state), numbers(b.state)) <= 1e-14);
  Coupled c;
  PhiStepper heavy{c.state, WarmPull{}, forward_euler, mass(2.0, Eigen::Vector2d(4, 8))};
  const Coupled start;
  Warm::Rate rate = make_rate<Warm>(start.state);
  WarmPull{}.add(0, start.state, rate);
  REQUIRE(heavy.step(c.state, 0, 0.1));
  CHECK(distance(c.state.v, start.state.v + 0.1 * rate.force / 2) <= 1e-15);
  CHECK(c.state.T[1] == Approx(1.5 + 0.1 * rate.heat[1] / 8).epsilon(1e-15));
}

#include "step/mass/mass_cases.hpp"
#if PHISTEP_FULL
#include <phistep/particles/bodies/body.hpp>
#endif

#if PHISTEP_FULL

using namespace mass_cases;

TEST_CASE("a mass that is not finite and > 0 throws where it is written") {
  for (const double bad : {0.0, -1.0, NaN, inf, -inf}) {
    CAPTURE(bad);
    CHECK_THROWS_AS(mass(bad), std::invalid_argument);
    CHECK_THROWS_AS(capacity(bad), std::invalid_argument);
    if (bad != 0) CHECK_THROWS_AS(mass(Eigen::Vector3d(1, bad, 1)), std::invalid_argument);
    CHECK_THROWS_AS(mass(2.0, bad), std::invalid_argument);
  }
  CHECK_THROWS_AS(mass(0), std::invalid_argument);
}

TEST_CASE("a mass matrix that is not square or not finite throws") {
  Eigen::MatrixXd m = Eigen::MatrixXd::Identity(3, 3);
  for (const double bad : {NaN, inf}) {
    m(1, 1) = bad;
    CAPTURE(bad);
    CHECK_THROWS_AS(mass(m), std::invalid_argument);
  }
  CHECK_THROWS_AS(mass(Eigen::MatrixXd::Ones(2, 3)), std::invalid_argument);
}

TEST_CASE("as many masses as the state has neither components nor particles throw") {
  const Motion<Dynamic> y{Dynamic::Ones(6), Dynamic::Ones(6)};
  for (const Eigen::Index n : {0, 1, 3, 5, 7, 12}) {
    CAPTURE(n);
    const Eigen::VectorXd masses = Eigen::VectorXd::Ones(n);
    CHECK_THROWS_AS((PhiStepper{y, DampedPull{}, forward_euler, mass(masses)}), std::invalid_argument);
  }
}

TEST_CASE("one particle may have its mass as one of a list") {
  const phistep::Motion<Eigen::Matrix3Xd> y{Eigen::Matrix3Xd::Zero(3, 1), Eigen::Matrix3Xd::Ones(3, 1)};
  auto one = y, list = y;
  const auto fall = [](const Eigen::Matrix3Xd& r) -> Eigen::Matrix3Xd { return Eigen::Matrix3Xd::Ones(3, r.cols()); };
  phistep::PhiStepper a{one, fall, phistep::symplectic_euler, phistep::mass(4.0)};
  phistep::PhiStepper b{list, fall, phistep::symplectic_euler, phistep::mass(Eigen::VectorXd::Constant(1, 4.0))};
  REQUIRE(a.step(one, 0, 0.5));
  REQUIRE(b.step(list, 0, 0.5));
  CHECK(one.v == list.v);
}

TEST_CASE("all ways to write the same mass agree") {
  using Case = SecondOrder<Dynamic>;
  const Eigen::VectorXd each = Eigen::VectorXd::Constant(6, 2.0);
  const Eigen::VectorXd expected = run<Case>(forward_euler, mass(2.0));
  CHECK(distance(run<Case>(forward_euler, mass(each)), expected) <= 1e-13);
  CHECK(distance(run<Case>(forward_euler, mass(Eigen::MatrixXd(each.asDiagonal()))), expected) <= 1e-13);
  CHECK(distance(run<Case>(forward_euler, mass(1.0)), expected) > 0.01);
}

TEST_CASE("products with a mass are those with its entries, for every kind of mass") {
  const auto check = [](const auto& bound) {
    Eigen::Matrix<double, 6, 6> M = Eigen::Matrix<double, 6, 6>::Zero();
    bound.for_each_entry(6, [&](Eigen::Index i, Eigen::Index j, auto m) { M(i, j) += static_cast<double>(m); });
    const Eigen::VectorXd x{{1, -2, 3, -4, 5, -6}}, ones = Eigen::VectorXd::Ones(6);  // whole numbers: all is exact
    Eigen::VectorXd out = ones;
    bound.add_product([&x](Eigen::Index i) { return x[i]; }, out);
    CHECK(out == ones + M * x);
    bound.subtract_product(x, out);
    CHECK(out == ones);
    return M;
  };
  const Eigen::VectorXd block = Eigen::VectorXd::Zero(6), each{{1, 2, 3, 4, 5, 6}};
  const Eigen::MatrixXd pairs = Eigen::MatrixXd::Zero(2, 3);
  const auto first = [](const auto& list) { return std::get<0>(list.masses); };
  CHECK(check(UnitMass{}) == Eigen::MatrixXd::Identity(6, 6));
  CHECK(check(first(mass(3.0)).bind<double>(block)) == 3 * Eigen::MatrixXd::Identity(6, 6));
  CHECK(check(first(mass(each)).bind<double>(block)) == Eigen::MatrixXd(each.asDiagonal()));
  CHECK(check(first(mass(Eigen::Vector3d(1, 2, 5))).bind<double>(pairs)).diagonal() ==
        Eigen::Vector<double, 6>{{1, 1, 2, 2, 5, 5}});
  Eigen::MatrixXd full = Eigen::MatrixXd(each.asDiagonal());
  full(0, 3) = full(3, 0) = -1;
  full(5, 1) = 7;
  CHECK(check(first(mass(full)).bind<double>(block)) == full);
  CHECK(check(ParticleMasses<double, 2>{Eigen::VectorXd{{1, 2, 5}}, {}}).diagonal() ==
        Eigen::Vector<double, 6>{{1, 1, 2, 2, 5, 5}});
}

TEMPLATE_TEST_CASE("a mass per particle is its components' mass", "", SecondOrder<FixedColumns>) {
  const Eigen::Vector2d particles(2, 5);
  Eigen::VectorXd components(6);
  components << 2, 2, 2, 5, 5, 5;
  using Flat = std::conditional_t < requires(TestType c) { c.state.r; }
  , SecondOrder<Dynamic>, FirstOrder < Dynamic >> ;
  const auto check = [&](auto scheme) {
    CHECK(distance(run<TestType>(scheme, mass(particles)), run<Flat>(scheme, mass(components))) <= 1e-13);
  };
  check(forward_euler);
}

TEST_CASE("one mass per solved block of a user's own state") {
  Coupled c;
  PhiStepper heavy{c.state, WarmPull{}, forward_euler, mass(2.0, Eigen::Vector2d(4, 8))};
  const Coupled start;
  Warm::Rate rate = make_rate<Warm>(start.state);
  WarmPull{}.add(0, start.state, rate);
  REQUIRE(heavy.step(c.state, 0, 0.1));
  CHECK(distance(c.state.v, start.state.v + 0.1 * rate.force / 2) <= 1e-15);
  CHECK(c.state.T[1] == Approx(1.5 + 0.1 * rate.heat[1] / 8).epsilon(1e-15));
}

#elif PHISTEP_STRESS

//
#include <phistep/sparse.hpp>

namespace {
Eigen::SparseMatrix<double> sparse(const Eigen::MatrixXd& dense) { return dense.sparseView(); }
}  // namespace

using namespace mass_cases;

TEST_CASE("all ways to write the same mass agree") {
  const auto check = [](auto scheme) {
    using Case = SecondOrder<Dynamic>;
    const Eigen::VectorXd each = Eigen::VectorXd::Constant(6, 2.0);
    const Eigen::VectorXd expected = run<Case>(scheme, mass(2.0));
    CHECK(distance(run<Case>(scheme, mass(each)), expected) <= 1e-13);
    CHECK(distance(run<Case>(scheme, mass(Eigen::MatrixXd(each.asDiagonal()))), expected) <= 1e-13);
    CHECK(distance(run<Case>(scheme, mass(sparse(each.asDiagonal()))), expected) <= 1e-13);
    CHECK(distance(run<Case>(scheme, mass(1.0)), run<Case>(scheme)) <= 1e-13);
    CHECK(distance(run<Case>(scheme, mass(1.0)), expected) > 0.01);
  };
  check(forward_euler), check(trapezoidal), check(velocity_verlet);  // explicit, Newton, Verlet's local solve
}

#endif

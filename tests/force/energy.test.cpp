// Potential energies: each is the one whose differences give the force.
#include "force/energy_cases.hpp"

using namespace energy_cases;

TEMPLATE_TEST_CASE("the force of every term with an energy is minus its gradient", "", Columns) {
  const auto y = SecondOrder<TestType>{}.state;
  const auto n = y.r.size();
  const auto check = [&](auto term, const auto& m) { CHECK(gradient_error(term, y, m) <= 1e-8); };
  const auto masses = DiagonalMass<double>{Eigen::VectorXd::LinSpaced(n, 1, 2)};
  Eigen::MatrixXd full = Eigen::MatrixXd::Identity(n, n) * 3;
  full(0, 1) = full(1, 0) = 0.5;
  check(Gravity{Eigen::Vector3d(1, 2, -9.81)}, UnitMass{});
  check(Gravity{Eigen::Vector3d(1, 2, -9.81)}, masses);
  check(UniformForce{Eigen::Vector3d(1, 2, 3)}, UnitMass{});
  if constexpr (!TestType::IsRowMajor) {
    check(spring_network<3>(two_springs, SpringDamping{2.0}), UnitMass{});
    check(local<3>(with_energy([](const Eigen::Vector3d& r) -> Eigen::Vector3d { return -r.squaredNorm() * r; },
                               [](const Eigen::Vector3d& r) { return r.squaredNorm() * r.squaredNorm() / 4; })),
          UnitMass{});
  }
  const Eigen::MatrixXd K = -full;
  check(linear(K), UnitMass{});
  check(Gravity{Eigen::Vector3d(1, 2, -9.81)} + linear(K) + LinearDrag{0.3}, masses);
}

TEST_CASE("with_energy: V(r) and V(r, t), around lambdas, terms and annotations") {
  using Vec = Eigen::VectorXd;
  const auto y = SecondOrder<Vec>{}.state;
  const auto f = [](const Vec& r) -> Vec { return -r.array().sin(); };
  const auto V = [](const Vec& r) { return -r.array().cos().sum(); };
  CHECK(gradient_error(with_energy(f, V), y, UnitMass{}) <= 1e-8);
  const auto moving =
      with_energy([](const Vec& r, const Vec& v, double t) -> Vec { return -(r.array() - t).matrix() - v; },
                  [](const Vec& r, double t) { return (r.array() - t).square().sum() / 2; });
  CHECK(gradient_error(moving, y, UnitMass{}, 0.7) <= 1e-8);
  CHECK(energy_of(moving, y, UnitMass{}, 0.7) != energy_of(moving, y, UnitMass{}, 0.0));
  auto referred = with_energy(f, V);
  auto by_reference = std::ref(referred);
  CHECK(energy_of(by_reference, y, UnitMass{}) == energy_of(referred, y, UnitMass{}));
}

TEST_CASE("what has no energy has none") {
  using Y = Motion<Eigen::VectorXd>;
  using View = decltype(Blocks<Y>::view(std::declval<const Y&>(), std::declval<const std::tuple<UnitMass>&>()));
  STATIC_REQUIRE_FALSE(HasEnergy<LinearDrag, View>);
  const auto lambda = [](const Eigen::VectorXd& r) -> Eigen::VectorXd { return -r; };
  STATIC_REQUIRE_FALSE(HasEnergy<decltype(lambda), View>);
  STATIC_REQUIRE(HasEnergy<SpringNetwork<3>, View>);

  Eigen::MatrixXd K(2, 2);
  K << -2, 1, 1, -2;
  auto symmetric_one = linear(K);
  K(0, 1) *= 1 + 4e-16;  // rounding in its assembly
  auto rounded = linear(K);
  K(0, 1) = 1 + 1e-10;
  auto skew = linear(K);
  CHECK(has_energy<View>(symmetric_one));
  CHECK(has_energy<View>(rounded));
  CHECK_FALSE(has_energy<View>(skew));
  const Y y{Eigen::Vector2d(1, 2), Eigen::Vector2d(0, 0)};
  CHECK(energy_of(skew, y, UnitMass{}) == 0);
  CHECK(energy_of(symmetric_one, y, UnitMass{}) == Approx(3));
}

TEST_CASE("energies of hand-made states") {
  const Motion<Eigen::Vector3d> y{Eigen::Vector3d(1, 2, 3), Eigen::Vector3d(0, 0, 0)};
  Gravity down{Eigen::Vector3d(0, 0, -10)};
  CHECK(energy_of(down, y, ScalarMass<double>{2}) == 60);
  UniformForce push{Eigen::Vector3d(1, 0, 0)};
  CHECK(energy_of(push, y, UnitMass{}) == -1);
  Motion<Eigen::VectorXd> pair{Eigen::VectorXd::Zero(6), Eigen::VectorXd::Zero(6)};
  auto springs = spring_network<3>({{0, 1, 8.0, 0.5}});
  CHECK(energy_of(springs, pair, UnitMass{}) == 1);  // of no length, it stores what it is compressed by
  pair.r[3] = 2.5;
  CHECK(energy_of(springs, pair, UnitMass{}) == 16);
}

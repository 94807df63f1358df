// energy: the full product and what is dear to compile. The quick half is energy.test.cpp.
#include "force/energy_cases.hpp"
//
#include <phistep/sparse.hpp>

using namespace energy_cases;

TEMPLATE_TEST_CASE("the force of every term with an energy is minus its gradient", "", Fixed, Dynamic, Columns,
                   RowMajor) {
  const auto y = SecondOrder<TestType>{}.state;
  const auto n = y.r.size();
  const auto check = [&](auto term, const auto& m) { CHECK(gradient_error(term, y, m) <= 1e-8); };
  const auto masses = DiagonalMass<double>{Eigen::VectorXd::LinSpaced(n, 1, 2)};
  Eigen::MatrixXd full = Eigen::MatrixXd::Identity(n, n) * 3;
  full(0, 1) = full(1, 0) = 0.5;
  check(Gravity{Eigen::Vector3d(1, 2, -9.81)}, UnitMass{});
  check(Gravity{Eigen::Vector3d(1, 2, -9.81)}, masses);
  check(Gravity{Eigen::Vector3d(1, 2, -9.81)}, DenseMass<double>{full});
  check(UniformForce{Eigen::Vector3d(1, 2, 3)}, UnitMass{});
  if constexpr (!TestType::IsRowMajor) {
    check(spring_network<3>(two_springs), UnitMass{});
    check(spring_network<3>(two_springs, SpringDamping{2.0}), UnitMass{});
    check(local<3>(with_energy([](const Eigen::Vector3d& r) -> Eigen::Vector3d { return -r.squaredNorm() * r; },
                               [](const Eigen::Vector3d& r) { return r.squaredNorm() * r.squaredNorm() / 4; })),
          UnitMass{});
  }
  const Eigen::MatrixXd K = -full;
  check(linear(K), UnitMass{});
  check(linear(K, Eigen::MatrixXd(0.3 * K)), UnitMass{});
  check(linear(Eigen::SparseMatrix<double>(K.sparseView())), UnitMass{});
  check(symmetric(linear(K)), UnitMass{});
  check(Gravity{Eigen::Vector3d(1, 2, -9.81)} + linear(K) + LinearDrag{0.3}, masses);
}

TEST_CASE("with_energy: V(r) and V(r, t), around lambdas, terms and annotations") {
  using Vec = Eigen::VectorXd;
  const auto y = SecondOrder<Vec>{}.state;
  const auto f = [](const Vec& r) -> Vec { return -r.array().sin(); };
  const auto V = [](const Vec& r) { return -r.array().cos().sum(); };
  CHECK(gradient_error(with_energy(f, V), y, UnitMass{}) <= 1e-8);
  CHECK(gradient_error(term(with_energy(f, V)) + LinearDrag{1.0}, y, UnitMass{}) <= 1e-8);
  CHECK(gradient_error(with_energy(term(f), V) + LinearDrag{1.0}, y, UnitMass{}) <= 1e-8);
  CHECK(gradient_error(symmetric(with_energy(f, V)), y, UnitMass{}) <= 1e-8);
  const auto moving =
      with_energy([](const Vec& r, const Vec& v, double t) -> Vec { return -(r.array() - t).matrix() - v; },
                  [](const Vec& r, double t) { return (r.array() - t).square().sum() / 2; });
  CHECK(gradient_error(moving, y, UnitMass{}, 0.7) <= 1e-8);
  CHECK(energy_of(moving, y, UnitMass{}, 0.7) != energy_of(moving, y, UnitMass{}, 0.0));
  auto referred = with_energy(f, V);
  auto by_reference = std::ref(referred);
  CHECK(energy_of(by_reference, y, UnitMass{}) == energy_of(referred, y, UnitMass{}));
}

TEST_CASE("an energy does not change the force or what is known of it") {
  using Vec = Eigen::VectorXd;
  const auto f = [](const Vec& r) -> Vec { return -3 * r; };
  const auto V = [](const Vec& r) { return 1.5 * r.squaredNorm(); };
  Motion<Vec> a{Vec::Ones(2), Vec::Zero(2)}, b = a;
  PhiStepper plain{a, affine(f), trapezoidal};
  PhiStepper with{b, affine(with_energy(f, V)), trapezoidal};
  for (int n = 0; n < 5; ++n) {
    REQUIRE(plain.step(a, 0, 0.1));
    REQUIRE(with.step(b, 0, 0.1));
  }
  CHECK(a.r == b.r);
  CHECK(plain.statistics().force_calls == with.statistics().force_calls);
  CHECK(plain.statistics().factorizations == with.statistics().factorizations);
}

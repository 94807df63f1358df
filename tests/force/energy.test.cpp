// Potential energies: each is the one whose differences give the force.
#include <phistep/phistep.hpp>

#include <algorithm>
#include <cmath>
#include <functional>
#include <tuple>
#include <utility>
#include <vector>

#include "contract/states.hpp"
#include "support/catch.hpp"

using namespace phistep;
using namespace states;

namespace energy_cases {

/// V and Ψ of a force at a motion's state, for one mass.
template <class S, class F, class M>
double energy_of(F& force, const S& y, const M& m, double t = 0) {
  return static_cast<double>(potential_energy(unwrap(force), t, Blocks<S>::view(y, std::tuple{m}), MemoryOf<F>{}));
}
template <class S, class F, class M>
auto force_of(F& force, const S& y, const M& m, double t = 0) {
  auto out = make_rate<S>(y);
  assign_force(unwrap(force), t, Blocks<S>::view(y, std::tuple{m}), NoMemory{}, out);
  return out.force;
}

/// Largest difference between −∂V/∂r, by central differences, and Ψ at v = 0, relative to Ψ. With δ = 1e-5 and lengths of
/// about 1, differences err by δ²/6 ≈ 2e-11 of the third derivative, and by uV/δ ≈ 2e-11 of V, up to 100 times the force.
template <class S, class F, class M>
double gradient_error(F force, S y, const M& m, double t = 0) {
  y.v.setZero();
  const auto psi = force_of(force, y, m, t);
  constexpr double delta = 1e-5;
  double worst = 0;
  for (Eigen::Index i = 0; i < y.r.size(); ++i) {
    double& x = y.r.data()[i];
    const double at = x;
    x = at + delta;
    const double above = energy_of(force, y, m, t);
    x = at - delta;
    const double below = energy_of(force, y, m, t);
    x = at;
    worst = std::max(worst, std::abs(-(above - below) / (2 * delta) - psi.data()[i]));
  }
  return worst / psi.cwiseAbs().maxCoeff();
}

inline const std::vector<Spring> two_springs{{0, 1, 80.0, 0.4}, {1, 0, 30.0, 0.0}};

}  // namespace energy_cases

#if PHISTEP_QUICK

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

#elif PHISTEP_FULL

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

#endif

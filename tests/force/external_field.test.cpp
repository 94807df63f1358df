#include <phistep/autodiff.hpp>
#include <phistep/force/local.hpp>
#include <phistep/particles/bodies/particles.hpp>
#include <phistep/phistep.hpp>

#include <cmath>
#include <stdexcept>

#include "support/catch.hpp"

using namespace phistep;
using Eigen::Vector2d;
using Eigen::Vector3d;

namespace external_field_cases {

inline Eigen::Matrix3Xd some_positions() {
  Eigen::Matrix3Xd r(3, 4);
  r << 0.3, -0.7, 0.2, 1.1, 0.4, -0.6, 0.5, 0.1, -0.4, 0.2, -0.3, 0.6;
  return r;
}
/// V = k (x⁴ + y² z) cos(ωt), F = −∇V
inline const auto quartic = [](const auto& r, auto t) {
  std::remove_cvref_t<decltype(r)> f = r;
  f[0] = -4 * r[0] * r[0] * r[0] * std::cos(2 * t);
  f[1] = -2 * r[1] * r[2] * std::cos(2 * t);
  f[2] = -1 * r[1] * r[1] * std::cos(2 * t);
  return f;
};
inline const auto potential = [](const auto& r, auto t) {
  return (r[0] * r[0] * r[0] * r[0] + r[1] * r[1] * r[2]) * std::cos(2 * t);
};

template <class S, class F>
auto force_on(F& force, const S& y, double t) {
  auto out = make_rate<S>(y);
  const UnitMass mass;
  add_force(force, t, Blocks<S>::view(y, std::tuple{mass}), NoMemory{}, out);
  return out.force;
}

struct Analytic {
  Vector3d operator()(const Vector3d& r, double t) const { return quartic(r, t); }
  Eigen::Matrix3d jacobian(const Vector3d& r, double t) const {
    Eigen::Matrix3d K;
    K << -12 * r[0] * r[0], 0, 0, 0, -2 * r[2], -2 * r[1], 0, -2 * r[1], 0;
    return K * std::cos(2 * t);
  }
};

}  // namespace external_field_cases

using namespace external_field_cases;

#if PHISTEP_QUICK

TEST_CASE("a field acts on each particle where it is, when it is") {
  const Motion<Eigen::Matrix3Xd> y{some_positions(), some_positions()};
  ExternalField field{quartic};
  const Eigen::Matrix3Xd f = force_on(field, y, 0.3);
  for (int i = 0; i < 4; ++i) CHECK((f.col(i) == quartic(Vector3d(y.r.col(i)), 0.3)));
  // A flat vector and the plane alike.
  const Motion<Eigen::VectorXd> flat{y.r.reshaped(), y.v.reshaped()};
  CHECK((force_on(field, flat, 0.3) == f.reshaped()));
  auto plane = external_field<2>([](const Vector2d& r) -> Vector2d { return {-r[1], r[0]}; });
  const Eigen::VectorXd turned = force_on(plane, flat, 0);
  for (int i = 0; i < 6; ++i) CHECK((turned[2 * i] == -flat.r[2 * i + 1] && turned[2 * i + 1] == flat.r[2 * i]));
}

TEST_CASE("a field's tangent is the user's, automatic, or of differences, and all steps agree") {
  const Motion<Eigen::Matrix3Xd> start{some_positions(), some_positions()};
  CHECK(check_jacobian(ExternalField{Analytic{}}, start, 0.2));
  CHECK(check_jacobian(ExternalField{autodiff(quartic)}, start, 0.2));
}

TEST_CASE("a field's energy is that of its potential, and its force the gradient") {
  const Motion<Eigen::Matrix3Xd> y{some_positions(), some_positions()};
  ExternalField field{with_energy(quartic, potential)};
  const UnitMass mass;
  const auto energy = [&](const auto& at) {
    return field.energy(0.3, Blocks<Motion<Eigen::Matrix3Xd>>::view(at, std::tuple{mass}));
  };
  double sum = 0;
  for (int i = 0; i < 4; ++i) sum += potential(Vector3d(y.r.col(i)), 0.3);
  CHECK(energy(y) == Approx(sum).epsilon(1e-15));
  const Eigen::Matrix3Xd f = force_on(field, y, 0.3);
  for (int k = 0; k < 12; ++k) {
    auto up = y, down = y;
    const double h = 1e-5;
    up.r.data()[k] += h, down.r.data()[k] -= h;
    // Central differences: h² V'''/6 ≈ 1e-9, rounding 1e-16/h.
    CHECK(f.data()[k] == Approx(-(energy(up) - energy(down)) / (2 * h)).margin(1e-8));
  }
  static_assert(!HasEnergy<ExternalField<decltype(quartic)>, MotionView<Eigen::Matrix3Xd, UnitMass>>);
}

TEST_CASE("a field leaves out particles held still, and refuses what isn't made of particles") {
  Particles<double, 3> grains{some_positions()};
  grains.set_still({0, 1, 0, 0});
  int calls = 0;
  ExternalField field{[&calls](const Vector3d& r) -> Vector3d { return ++calls, -r; }};
  auto out = make_rate<Particles<double, 3>>(grains);
  const auto masses = Particles<double, 3>::masses(grains);
  add_force(field, 0.0, Blocks<Particles<double, 3>>::view(grains, masses), NoMemory{}, out);
  CHECK(calls == 3);
  CHECK((out.force.col(1).norm() == 0 && out.force.col(0) == -grains.r.col(0)));

  const Motion<Eigen::VectorXd> flat{Eigen::VectorXd::Zero(8), Eigen::VectorXd::Zero(8)};
  CHECK_THROWS_AS(force_on(field, flat, 0), std::invalid_argument);
}

TEST_CASE("quadratic drag: against the velocity, with its square; its tangent") {
  const Motion<Eigen::Matrix3Xd> y{some_positions(), some_positions()};
  QuadraticDrag drag{0.7};
  const Eigen::Matrix3Xd f = force_on(drag, y, 0);
  for (int i = 0; i < 4; ++i) CHECK((f.col(i) + 0.7 * y.v.col(i).norm() * y.v.col(i)).norm() <= 1e-16);
  CHECK(check_jacobian(drag, y));
  const Motion<Eigen::VectorXd> plane{y.r.reshaped(), y.v.reshaped()};
  QuadraticDrag<2> in_plane{0.7};
  CHECK(force_on(in_plane, plane, 0)[0] == Approx(-0.7 * std::hypot(plane.v[0], plane.v[1]) * plane.v[0]));
  // At rest there is neither force nor tangent.
  const Motion<Eigen::Matrix3Xd> rest{some_positions(), Eigen::Matrix3Xd::Zero(3, 4)};
  CHECK(force_on(drag, rest, 0).norm() == 0);
  CHECK_THROWS_AS(QuadraticDrag{std::nan("")}, std::invalid_argument);
}

#elif PHISTEP_FULL

TEST_CASE("a field's tangent is the user's, automatic, or of differences, and all steps agree") {
  const Motion<Eigen::Matrix3Xd> start{some_positions(), some_positions()};
  CHECK(check_jacobian(ExternalField{autodiff(quartic)} + LinearDrag{0.3}, start, 0.2));
  const auto steps = [&](auto field) {
    auto y = start;
    PhiStepper stepper{y, field, trapezoidal, mass(2.0)};
    for (int n = 0; n < 10; ++n) REQUIRE(stepper.step(y, 0.1 * n, 0.1));
    return std::pair{y.r, stepper.statistics().force_calls};
  };
  const auto analytic = steps(ExternalField{Analytic{}}), differences = steps(ExternalField{quartic});
  CHECK((analytic.first - differences.first).norm() <= 1e-10);
  CHECK(analytic.second < differences.second);
}

TEST_CASE("quadratic drag: against the velocity, with its square; its tangent") {
  const Motion<Eigen::VectorXd> plane{some_positions().reshaped(), some_positions().reshaped()};
  CHECK(check_jacobian(QuadraticDrag<2>{0.7}, plane));
  // At rest there is neither force nor tangent.
  const Motion<Eigen::Matrix3Xd> rest{some_positions(), Eigen::Matrix3Xd::Zero(3, 4)};
  auto state = rest;
  PhiStepper stepper{state, QuadraticDrag{0.7}, trapezoidal, mass(2.0)};
  REQUIRE(stepper.step(state, 0, 0.1));
  CHECK((state.r == rest.r));
}

TEST_CASE("quadratic drag brakes as 1/(1 + c v t/m)") {
  Motion<Eigen::Matrix3Xd> y{Eigen::Matrix3Xd::Zero(3, 1), Vector3d(3, 0, 4)};
  PhiStepper stepper{y, QuadraticDrag{0.5}, trapezoidal, mass(2.0)};
  const int n = 1000;
  for (int k = 0; k < n; ++k) REQUIRE(stepper.step(y, k * 1e-3, 1e-3));
  // v' = −(c/m) v²; order 2: h² v'''/12 ≈ 1e-6 · 6 (c/m)³ v⁴/12.
  CHECK(y.v.norm() == Approx(5 / (1 + 0.25 * 5)).margin(5e-6));
}

#endif

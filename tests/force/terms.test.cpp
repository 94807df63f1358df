#include <phistep/force/drag.hpp>
#include <phistep/force/gravity.hpp>
#include <phistep/force/local.hpp>
#include <phistep/force/sum.hpp>
#include <phistep/particles/springs/springs.hpp>
#include <phistep/phistep.hpp>

#include <Eigen/Geometry>

#include <cmath>
#include <functional>
#include <stdexcept>
#include <tuple>

#include "contract/states.hpp"
#include "support/catch.hpp"

using namespace phistep;
using namespace states;

namespace terms_cases {

/// Ψ of a force at a motion's state, added to what `out` holds.
template <class S, class F>
auto added(F& force, const S& y, const auto& mass, double start = 0) {
  auto out = make_rate<S>(y);
  out.force.setConstant(start);
  add_force(unwrap(force), 0.0, Blocks<S>::view(y, std::tuple{mass}), NoMemory{}, out);
  return out.force;
}

template <class V>
Motion<V> grains() {
  return SecondOrder<V>{}.state;
}

inline void check_right(const JacobianCheck& result) {
  CAPTURE(result.message());
  CHECK(result);
}
/// What a term adds to nothing, to tens, and to a flat vector of nothing.
inline void check_added(const Eigen::VectorXd& alone, const Eigen::VectorXd& onto, const Eigen::VectorXd& flat) {
  CHECK(alone.norm() > 0.1);
  CHECK(distance(onto, alone.array() + 10) <= 1e-13);
  CHECK(distance(alone, flat) <= 1e-13);  // the same force, whatever the shape
}

inline const std::vector<Spring> one_spring{{0, 1, 80.0, 0.4}};

/// The contract of every term, in every shape of a state.
template <class V>
void check_terms() {
  const auto y = grains<V>();
  const auto check = [&](auto term) {
    check_added(numbers(typename V::PlainObject(added(term, y, UnitMass{}))),
                numbers(typename V::PlainObject(added(term, y, UnitMass{}, 10.0))),
                numbers(Dynamic(added(term, grains<Dynamic>(), UnitMass{}))));
  };
  check(Gravity{Eigen::Vector3d(1, 2, -9.81)});
  check(UniformForce{Eigen::Vector3d(1, 2, 3)});
  check(LinearDrag{0.7});
  if constexpr (!V::IsRowMajor) {  // which springs refuse, see tests/compile
    check(spring_network<3>(one_spring));
    check(spring_network<3>(one_spring, SpringDamping{2.0}));
    check(QuadraticDrag{0.7});
    check(ExternalField{[](const Eigen::Vector3d& r) -> Eigen::Vector3d { return r.squaredNorm() * r; }});
  }
  check(term([](const auto& r) { return typename std::remove_cvref_t<decltype(r)>::PlainObject(-r); }));
  check(LinearDrag{0.7} + Gravity{Eigen::Vector3d(0, 0, -1)} + UniformForce{Eigen::Vector3d(0, 1, 0)});
}

}  // namespace terms_cases

using namespace terms_cases;

#if PHISTEP_QUICK

TEMPLATE_TEST_CASE("a term adds to the force and does not overwrite it", "", Columns) { check_terms<TestType>(); }

TEST_CASE("every term's Jacobian equals differences") {
  const auto y = grains<Dynamic>();
  const auto check = [&](auto force) { check_right(check_jacobian(force, y)); };
  check(LinearDrag{0.3} + spring_network<3>(one_spring, SpringDamping{2.0}) + Gravity{Eigen::Vector3d(0, 0, -1)});
}

TEST_CASE("gravity is an acceleration, a uniform force is a force") {
  const auto y = grains<Dynamic>();
  auto gravity = Gravity{Eigen::Vector3d(0, 0, -9.81)};
  auto uniform = UniformForce{Eigen::Vector3d(0, 0, -9.81)};
  Eigen::VectorXd m(6);
  m << 2, 2, 2, 5, 5, 5;
  const DiagonalMass<double> masses{m};
  CHECK(added(gravity, y, masses)[5] == Approx(-5 * 9.81));
  CHECK(added(gravity, y, ScalarMass<double>{3})[2] == Approx(-3 * 9.81));
  CHECK(added(gravity, y, UnitMass{})[2] == -9.81);
  CHECK(added(uniform, y, masses)[5] == -9.81);
}

TEST_CASE(
    "a vector as long as the state has a number for each of its own, one of another length than a particle's is "
    "refused") {
  const Motion<Columns> y{Columns::Zero(3, 2), Columns::Zero(3, 2)};
  const Eigen::VectorXd all = Eigen::VectorXd::LinSpaced(6, 1, 6);
  auto uniform = UniformForce{all};
  auto gravity = Gravity{all};
  CHECK(added(uniform, y, UnitMass{}).reshaped() == all);
  CHECK(added(gravity, y, UnitMass{}).reshaped() == all);
  auto flat = Gravity{Eigen::Vector2d(0, -9.81)};  // two of three components, though two divide six
  CHECK_THROWS_AS(added(flat, y, UnitMass{}), std::invalid_argument);
}

TEST_CASE("spring forces sum to zero, and so do their moments") {
  std::srand(7);
  std::vector<Spring> springs;
  for (int i = 0; i < 20; ++i)
    for (int j = i + 1; j < 20; j += 3) springs.push_back({i, j, 50.0 + i, 0.1 * j});
  Motion<Columns> y{Columns::Random(3, 20), Columns::Random(3, 20)};
  auto network = spring_network<3>(springs, SpringDamping{1.5});
  const Columns f = added(network, y, UnitMass{});
  CHECK(f.rowwise().sum().cwiseAbs().maxCoeff() <= 1e-11 * f.cwiseAbs().maxCoeff());
  Eigen::Vector3d moment = Eigen::Vector3d::Zero();
  for (int i = 0; i < 20; ++i) moment += Eigen::Vector3d(y.r.col(i)).cross(Eigen::Vector3d(f.col(i)));
  CHECK(moment.cwiseAbs().maxCoeff() <= 1e-11 * f.cwiseAbs().maxCoeff());
}

TEST_CASE("a spring pulls when long, pushes when short, and is idle at its length") {
  auto spring = spring_network<1>({{0, 1, 10.0, 2.0}});
  const auto force = [&](double distance_) {
    return added(spring, Motion<Eigen::VectorXd>{Eigen::Vector2d(1, 1 + distance_), Eigen::Vector2d::Zero()},
                 UnitMass{})[0];
  };
  CHECK(force(3) == Approx(10));
  CHECK(force(1) == Approx(-10));
  CHECK(force(2) == 0);
  CHECK(std::isnan(force(0)));  // no direction: a step says so
}

TEST_CASE("a dashpot brakes motion along its spring alone") {
  auto damped = spring_network<2>({{0, 1, 0.0, 1.0}}, SpringDamping{3.0});
  Motion<Eigen::VectorXd> y{Eigen::Vector4d(0, 0, 1, 0), Eigen::Vector4d(0, 0, 2, 5)};
  CHECK(added(damped, y, UnitMass{}).isApprox(Eigen::Vector4d(6, 0, -6, 0)));
}

TEST_CASE("springs that can't be throw at construction") {
  const double NaN = std::nan("");
  for (const Spring bad :
       {Spring{0, 0, 1, 1}, Spring{-1, 0, 1, 1}, Spring{0, -2, 1, 1}, Spring{0, 1, -1, 1}, Spring{0, 1, 1, -1},
        Spring{0, 1, NaN, 1}, Spring{0, 1, 1, NaN}, Spring{0, 1, HUGE_VAL, 1}, Spring{0, 1, 1, HUGE_VAL}})
    CHECK_THROWS_AS(spring_network<3>({bad}), std::invalid_argument);
  CHECK_THROWS_AS(spring_network<3>(one_spring, SpringDamping{NaN}), std::invalid_argument);
}

TEST_CASE("a spring to a particle that isn't there throws and leaves the state") {
  SecondOrder<Dynamic> c;
  PhiStepper stepper{c.state, spring_network<3>({{0, 2, 1, 1}}), velocity_verlet};
  CHECK_THROWS_AS(stepper.step(c.state, 0, 0.1), std::invalid_argument);
  CHECK((numbers(c.state) == numbers(SecondOrder<Dynamic>{}.state)));
}

TEST_CASE("an acceleration or a force of the wrong dimension throws") {
  SecondOrder<Dynamic> c;  // six components: neither 4 nor 5 fit
  const auto step = [&](auto force) {
    PhiStepper stepper{c.state, force, forward_euler};
    static_cast<void>(stepper.step(c.state, 0, 0.1));
  };
  CHECK_THROWS_AS(step(UniformForce{Eigen::VectorXd::Ones(5)}), std::invalid_argument);
  CHECK_THROWS_AS(step(UniformForce{Eigen::VectorXd(0)}), std::invalid_argument);
}

TEST_CASE("a drag coefficient must be finite") {
  CHECK_THROWS_AS(LinearDrag{std::nan("")}, std::invalid_argument);
  CHECK_THROWS_AS(LinearDrag{HUGE_VAL}, std::invalid_argument);
}

TEST_CASE("a sum stays flat and needs what its terms need") {
  const auto sum = term(Pull{}) + (LinearDrag{0.1} + Gravity{Eigen::Vector3d(0, 0, -1)});
  static_assert(std::tuple_size_v<decltype(sum.terms)> == 3);
  using Y = Motion<Dynamic>;
  using View =
      std::remove_cvref_t<decltype(Blocks<Y>::view(std::declval<const Y&>(), std::declval<std::tuple<UnitMass>&>()))>;
  using Traits = ForceTraits<std::remove_cvref_t<decltype(sum)>, View, RateOf<Y>>;
  static_assert(Traits::uses_velocity && !Traits::uses_time && !Traits::has_jacobian && Traits::has_velocity_jacobian);
  static_assert(Traits::structure == Structure::dense && Traits::velocity_structure == Structure::diagonal);
  using Still = ForceTraits<decltype(term(Pull{}) + Gravity{Eigen::Vector3d(0, 0, -1)}), View, RateOf<Y>>;
  static_assert(!Still::uses_velocity);
  auto copy = sum;
  const Eigen::VectorXd f = added(copy, grains<Dynamic>(), UnitMass{});
  auto y = grains<Dynamic>();
  CHECK(f.isApprox(Pull{}(y.r) - 0.1 * y.v + Eigen::Vector3d(0, 0, -1).replicate(2, 1)));
}

#elif PHISTEP_FULL

TEMPLATE_TEST_CASE("a term adds to the force and does not overwrite it", "", Fixed, Dynamic, Columns, RowMajor) {
  check_terms<TestType>();
}

TEST_CASE("every term's Jacobian equals differences") {
  const auto y = grains<Dynamic>();
  const auto check = [&](auto force) { check_right(check_jacobian(force, y)); };
  check(Gravity{Eigen::Vector3d(1, 2, -9.81)});
  check(UniformForce{Eigen::Vector3d(1, 2, 3)});
  check(LinearDrag{0.7});
  check(spring_network<3>(one_spring));
  check(spring_network<3>(one_spring, SpringDamping{2.0}));
  check(spring_network<3>({{0, 1, 80.0, 5.0}}, SpringDamping{2.0}));  // compressed
  check(spring_network<2>({{0, 1, 3.0, 0.1}, {1, 2, 4.0, 0.9}, {2, 0, 5.0, 0.3}}, SpringDamping{0.4}));
  check(spring_network<1>({{0, 1, 3.0, 0.1}, {4, 2, 4.0, 0.9}}, SpringDamping{0.4}));
  check(LinearDrag{0.3} + spring_network<3>(one_spring, SpringDamping{2.0}) + Gravity{Eigen::Vector3d(0, 0, -1)});
}

TEST_CASE("gravity is an acceleration, a uniform force is a force") {
  const auto y = grains<Dynamic>();
  auto gravity = Gravity{Eigen::Vector3d(0, 0, -9.81)};
  Eigen::VectorXd m(6);
  m << 2, 2, 2, 5, 5, 5;
  CHECK(added(gravity, y, DenseMass<double>{m.asDiagonal()})[5] == Approx(-5 * 9.81));
}

TEST_CASE("gravity falls alike for all masses") {
  const auto fall = [](const auto&... masses) {
    SecondOrder<Columns> c;
    PhiStepper stepper{c.state, Gravity{Eigen::Vector3d(0, 0, -9.81)}, velocity_verlet, masses...};
    for (int n = 0; n < 10; ++n) REQUIRE(stepper.step(c.state, 0, 0.1));
    return numbers(c.state);
  };
  CHECK(distance(fall(mass(7.0)), fall()) <= 1e-13);
  CHECK(distance(fall(mass(Eigen::Vector2d(0.1, 50))), fall()) <= 1e-13);
}

TEST_CASE("an acceleration or a force of the wrong dimension throws") {
  SecondOrder<Dynamic> c;  // six components: 4 don't fit
  PhiStepper stepper{c.state, Gravity{Eigen::Vector4d::Ones()}, forward_euler};
  CHECK_THROWS_AS(stepper.step(c.state, 0, 0.1), std::invalid_argument);
}

namespace {
/// Says that it ignores time, and doesn't.
struct Hidden : ForceTerm {
  static constexpr bool uses_velocity = false, uses_time = false;
  static void add(double t, const auto& y, auto& out) { out.force += std::sin(t) * y.r; }
};
}  // namespace

TEST_CASE("a term that reads the time it says it ignores fails the step") {
  Motion<Eigen::Vector2d> y{{0, 1}, {0, 0}};
  PhiStepper stepper{y, Gravity{Eigen::Vector2d{0, -1}} + Hidden{}, velocity_verlet};
  const StepReport report = stepper.step(y, 1.0, 0.1);
  CHECK(report.outcome() == Outcome::non_finite_force);
  CHECK(report.failure().term == 1);
  CHECK(y.r == Eigen::Vector2d{0, 1});
}

TEST_CASE("a term by reference sees later changes") {
  double k = 1;
  auto pull = [&k](const Dynamic& r) -> Dynamic { return -k * r; };
  auto sum = term(std::ref(pull)) + LinearDrag{0.0};
  const auto y = grains<Dynamic>();
  CHECK((added(sum, y, UnitMass{}) == -y.r));
  k = 2;
  CHECK((added(sum, y, UnitMass{}) == -2 * y.r));
}

TEST_CASE("terms work in float, explicit and implicit") {
  Motion<Eigen::Vector3f> y{Eigen::Vector3f(1, 2, 3), Eigen::Vector3f(-1, 0, 1)};
  const auto force = LinearDrag{0.5} + Gravity{Eigen::Vector3d(0, 0, -1)} + UniformForce{Eigen::Vector3d(1, 0, 0)};
  PhiStepper verlet{y, force, velocity_verlet, mass(2.0)};
  PhiStepper implicit{y, force, trapezoidal, mass(2.0)};
  auto z = y;
  for (int n = 0; n < 20; ++n) {
    REQUIRE(verlet.step(y, 0, 0.01f));
    REQUIRE(implicit.step(z, 0, 0.01f));
  }
  CHECK((y.r - z.r).norm() < 1e-4f);
}

#endif

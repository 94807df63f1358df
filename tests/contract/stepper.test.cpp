// The contract of a stepper, for every scheme and several kinds of state. All products: stepper*.full.cpp, stepper*.stress.cpp.
#include <phistep/phistep.hpp>

#include <cmath>
#include <type_traits>
#include <utility>
#include <vector>

#include "contract/states.hpp"
#include "contract/stepper_battery.hpp"
#include "contract/stepper_cases.hpp"
#include "support/catch.hpp"

using namespace phistep;
using namespace states;

#if PHISTEP_QUICK

using Driven = shared_force::OfStateAndTime<Fixed>;

namespace {

// Each scheme is watched once: these on motions, the others on first-order states. They share their types with the other
// cases: one more scheme on the same state and force is cheap to compile, another state or force is not.
template <class Scheme>
constexpr bool on_motions = std::is_same_v<Scheme, std::remove_cv_t<decltype(trapezoidal)>> ||
                            std::is_same_v<Scheme, TrBdf2> || std::is_same_v<Scheme, VelocityVerlet>;

}  // namespace

TEST_CASE("every scheme on a dynamic motion") {
  for_each_motion_scheme([](const char* name, auto scheme) {
    check_contract<SecondOrder<Dynamic>, on_motions<decltype(scheme)>>(scheme, scheme.order(), name);
  });
}
TEST_CASE("every first-order scheme on a fixed vector") {
  const auto timed = [](Moody moody) -> Driven { return [moody](const Fixed& y, double) { return moody(y); }; };
  check_contract<FirstOrder<Fixed>, true>(forward_euler, 1, timed);
  check_contract<FirstOrder<Fixed>, true>(backward_euler, 1, timed);
  check_contract<FirstOrder<Fixed>, true>(phi(0.7), 1, timed);
}
TEST_CASE("Verlet on every kind of motion") {
  check_contract<SecondOrder<Fixed>>(velocity_verlet, 2);
  check_contract<SecondOrder<Structs>>(velocity_verlet, 2);
}
TEST_CASE("Rannacher's start, and TR-BDF2 on other states") { check_contract<SecondOrder<Dynamic>>(rannacher, 2); }
TEST_CASE("a split scene: trouble in the kicks, trouble in the rest") {
  using Case = SecondOrder<Columns>;
  const auto split = [](ForceOf<Case> rest, ForceOf<Case> kicks) {
    return term(std::move(rest)) + at(forward_euler, std::move(kicks));
  };
  check_contract<Case>(velocity_verlet, 2, [&](Moody moody) { return split(Pull{}, moody); });
  check_contract<Case>(velocity_verlet, 2, [&](Moody moody) { return split(moody, Pull{}); });
}
TEST_CASE("halving keeps the contract of what it halves") {
  check_contract<SecondOrder<Dynamic>, false, Halve>(trapezoidal, 2);
}
TEST_CASE("a matrix, a strided view, a reference") { check_contract<FirstOrder<RowMajor>>(forward_euler, 1); }

TEST_CASE("dt < 0 undoes a step with the adjoint scheme") { check_undone(dynamic_pull); }

TEST_CASE("forward and backward Euler undo each other, and so do the two symplectic ones") {
  SecondOrder<Dynamic> c;
  const Eigen::VectorXd before = numbers(c.state);
  const auto there_and_back = [&](auto one, auto other) {
    PhiStepper forth{c.state, dynamic_pull, one};
    PhiStepper back{c.state, dynamic_pull, other};
    REQUIRE(forth.step(c.state, 0, 0.1));
    REQUIRE(back.step(c.state, 0.1, -0.1));
    CHECK(distance(numbers(c.state), before) <= 1e-14);
  };
  there_and_back(forward_euler, backward_euler);
  there_and_back(symplectic_euler, symplectic_euler_adjoint);
}

TEST_CASE("named schemes are their formulas") {
  const auto one_step = [](auto scheme) {
    Motion<Dynamic> y{Dynamic::Constant(1, StepByHand::r), Dynamic::Constant(1, StepByHand::v)};
    PhiStepper stepper{y, ForceOf<SecondOrder<Dynamic>>([](const Dynamic& x) -> Dynamic { return -StepByHand::w * x; }),
                       scheme};
    return stepper.step(y, 0, StepByHand::h) ? Eigen::Vector2d(y.r[0], y.v[0]) : Eigen::Vector2d(NAN, NAN);
  };
  check_formulas(one_step);
}

TEST_CASE("forces are asked at the times of the formulas") {
  std::vector<double> times;
  const Driven force = [&times](const Fixed& y, double t) -> Fixed {
    if (times.empty() || times.back() != t) times.push_back(t);
    return -y;
  };
  const auto asked = [&](auto scheme) {
    FirstOrder<Fixed> c;
    PhiStepper stepper{c.state, force, scheme};
    times.clear();
    return stepper.step(c.state, 1.0, 0.5) ? times : std::vector<double>{};
  };
  using Times = std::vector<double>;
  CHECK(asked(forward_euler) == Times{1.0});
  CHECK(asked(phi(0.5)) == Times{1.0, 1.5});
  CHECK(asked(backward_euler) == Times{1.5});
  CHECK(asked(phi_stage(0.5)) == Times{1.25});
  CHECK(asked(phi_stage(0.7)) == Times{1.0 + 0.7 * 0.5});
  CHECK(asked(tr_bdf2) == Times{1.0, 1.0 + (2 - std::sqrt(2.0)) * 0.5, 1.5});
}

TEST_CASE("a watched step is the step, a rejected one is none: every scheme on motions") {
  for_each_motion_scheme([](const char* name, auto scheme) {
    if constexpr (on_motions<decltype(scheme)>) {
      check_watched<SecondOrder<Dynamic>>(scheme, dynamic_pull, name);
      check_watched_trouble<SecondOrder<Dynamic>>(scheme, name);
    }
  });
}
TEST_CASE("a watched step is the step, a rejected one is none: every scheme on first-order states") {
  const Driven force = DrivenPull{};
  check_watched<FirstOrder<Fixed>>(forward_euler, force);
  check_watched<FirstOrder<Fixed>>(backward_euler, force);
  check_watched<FirstOrder<Fixed>>(phi(0.7), force);
}

#elif PHISTEP_FULL
// The contract of a stepper, for every scheme and several kinds of state: all products.

namespace {

template <class Case>
void check_explicit_and_implicit() {
  check_contract<Case>(forward_euler, 1);
  check_contract<Case>(trapezoidal, 2);
}

}  // namespace

TEST_CASE("every scheme on a dynamic motion") {
  for_each_motion_scheme(
      [](const char* name, auto scheme) { check_contract<SecondOrder<Dynamic>>(scheme, scheme.order(), name); });
}
TEST_CASE("every first-order scheme on a fixed vector") {
  for_each_first_order_scheme(
      [](const char* name, auto scheme) { check_contract<FirstOrder<Fixed>>(scheme, scheme.order(), name); });
}
TEST_CASE("Verlet on every kind of motion") {
  check_contract<SecondOrder<Fixed>>(velocity_verlet, 2);
  check_contract<SecondOrder<Columns>>(velocity_verlet, 2);
  check_contract<SecondOrder<Strided>>(velocity_verlet, 2);
  check_contract<SecondOrder<Structs>>(velocity_verlet, 2);
}
TEST_CASE("Rannacher's start, and TR-BDF2 on other states") {
  check_contract<SecondOrder<Dynamic>>(rannacher, 2);
  check_contract<FirstOrder<Fixed>>(rannacher(2), 2);
  check_contract<SecondOrder<Strided>>(tr_bdf2, 2);
  check_contract<FirstOrder<RowMajor>>(tr_bdf2, 2);
}
TEST_CASE("halving keeps the contract of what it halves") {
  check_contract<SecondOrder<Dynamic>, false, Halve>(trapezoidal, 2);
  check_contract<SecondOrder<Fixed>, false, Halve>(velocity_verlet, 2);
  check_contract<FirstOrder<Strided>, false, Halve>(tr_bdf2, 2);
  check_contract<FirstOrder<Dynamic>, false, Halve>(rannacher, 2);
}
TEST_CASE("a matrix, a strided view, a reference") {
  check_explicit_and_implicit<FirstOrder<RowMajor>>();
  check_explicit_and_implicit<FirstOrder<Strided>>();
  check_contract<FirstOrder<Reference>>(phi(0.7), 1);
}

#endif

// Steps against their formulas, and undone: every scheme. In short: stepper.test.cpp.
#include <phistep/phistep.hpp>

#include <cmath>
#include <vector>

#include "contract/states.hpp"
#include "contract/stepper_battery.hpp"
#include "contract/stepper_cases.hpp"
#include "support/catch.hpp"

using namespace phistep;
using namespace states;

TEST_CASE("dt < 0 undoes a step with the adjoint scheme") { check_undone(damped_pull); }

TEST_CASE("named schemes are their formulas") {
  const auto one_step = [](auto scheme) {
    using V = Eigen::Matrix<double, 1, 1>;
    Motion<V> y{V(StepByHand::r), V(StepByHand::v)};
    constexpr double m = 2;
    PhiStepper stepper{y, [](const V& x) -> V { return -m * StepByHand::w * x; }, scheme, mass(m)};
    return stepper.step(y, 0, StepByHand::h) ? Eigen::Vector2d(y.r[0], y.v[0]) : Eigen::Vector2d(NAN, NAN);
  };
  check_formulas(one_step);
}

TEST_CASE("forces are asked at the times of the formulas") {
  std::vector<double> times;
  const shared_force::OfMotionAndTime<Dynamic> force = [&times](const Dynamic& r, const Dynamic& v,
                                                                double t) -> Dynamic {
    if (times.empty() || times.back() != t) times.push_back(t);
    return -r - v;
  };
  const auto asked = [&](auto scheme) {
    SecondOrder<Dynamic> c;
    PhiStepper stepper{c.state, force, scheme};
    times.clear();
    return stepper.step(c.state, 1.0, 0.5) ? times : std::vector<double>{};
  };
  using Times = std::vector<double>;
  CHECK(asked(forward_euler) == Times{1.0});
  CHECK(asked(symplectic_euler) == Times{1.0});
  CHECK(asked(symplectic_euler_adjoint) == Times{1.5});
  CHECK(asked(trapezoidal) == Times{1.0, 1.5});
  CHECK(asked(backward_euler) == Times{1.5});
  CHECK(asked(midpoint) == Times{1.25});
  CHECK(asked(phi_stage(0.7)) == Times{1.0 + 0.7 * 0.5});
  CHECK(asked(velocity_verlet) == Times{1.0, 1.5});
  CHECK(asked(tr_bdf2) == Times{1.0, 1.0 + (2 - std::sqrt(2.0)) * 0.5, 1.5});
  CHECK(asked(rannacher) == Times{1.25, 1.5});
  CHECK(asked(rannacher(0)) == Times{1.0, 1.5});
}

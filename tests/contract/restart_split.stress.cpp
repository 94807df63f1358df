// Motions, restarted anywhere: splits. In short: restart_motion.test.cpp.
#include <phistep/phistep.hpp>
#include <phistep/sparse.hpp>

#include "contract/restart.hpp"
#include "contract/restart_motion_cases.hpp"
#include "contract/states.hpp"
#include "problems/spring_net.hpp"
#include "support/catch.hpp"

using namespace phistep;
using namespace restart_motion;
using problems::SpringNet;

namespace {

auto masses() { return mass(SpringNet::masses()); }

}  // namespace

TEST_CASE("half kicks around an implicit step restart to the same bits") {
  const auto gravity = at(forward_euler, UniformForce{Eigen::Vector2d{0.1, -1}});
  const auto start = [] { return SpringNet::start(); };
  const Statistics constant = check(uneven, start, steps(SpringNet::elastic() + gravity, trapezoidal, masses()));
  CHECK(constant.kick_calls == 1);
  for (const Steps& s : {even, uneven}) {
    const Statistics pull = check(s, six, steps(Driven{} + at(forward_euler, Pull{}), tr_bdf2));
    CHECK(pull.kick_calls == 61);
    check(s, six, steps(Pull{} + at(forward_euler, Driven{}), phi(0.7)));
    check(s, six, steps(Pull{} + at(forward_euler, Wind{}), trapezoidal));
    check(s, six, steps(Pull{} + at(forward_euler, Driven{}), rannacher(3)));
  }
}

TEST_CASE("slow terms restart to the same bits: levels, schemes, histories among the fast terms") {
  for (const Steps& s : {even, uneven}) {
    const Statistics pull = check(s, six, steps(Driven{} + seldom(4, Pull{}), velocity_verlet));
    CHECK(pull.kick_calls == 61);
    CHECK(pull.force_calls == 241);
    check(s, six, steps(Pull{} + seldom(2, Pull{}) + seldom(6, Driven{}), velocity_verlet));
    check(s, six, steps(Wind{} + seldom(3, Driven{}), velocity_verlet));
    check(s, six, steps(Pull{} + seldom(3, Driven{}), symplectic_euler));
    check(s, six, steps(Pull{} + seldom(2, Driven{}), symplectic_euler_adjoint));
    check(s, six, steps(Slider{} + Pull{} + seldom(2, Driven{}), velocity_verlet));
  }
}

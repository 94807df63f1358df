// States in the arrays of a code: the layouts with the schemes that in_place.test leaves out.
#include <phistep/krylov.hpp>
#include <unsupported/Eigen/IterativeSolvers>

#include "embed/in_place_cases.hpp"

using namespace in_place_cases;

TEMPLATE_TEST_CASE("in place: a step gives the bits and the calls of a state that the library owns", "[embed]", Rows,
                   Components, Vectors) {
  same_as_owned<TestType>(phistep::forward_euler, phistep::newton());
  same_as_owned<TestType>(phistep::symplectic_euler, phistep::newton());
  same_as_owned<TestType>(phistep::srkn6b, phistep::newton());
  same_as_owned<TestType>(phistep::midpoint, phistep::fixed_point());
}

TEST_CASE("in place: a fault in any call of the routine leaves every bit", "[embed]") {
  faults_leave_nothing<Structs, false>(phistep::forward_euler, phistep::newton());
  faults_leave_nothing<Structs, true>(phistep::velocity_verlet, phistep::fixed_point());
  faults_leave_nothing<Components, false>(phistep::forward_euler, phistep::newton());
  faults_leave_nothing<Components, true>(phistep::symplectic_euler, phistep::newton());
  faults_leave_nothing<Components, true>(phistep::velocity_verlet, phistep::fixed_point());
  faults_leave_nothing<Components, true>(phistep::midpoint, phistep::fixed_point());
  // GMRES ends at a product that is not finite, and the next correction mends what that left.
  const auto gmres = phistep::newton<phistep::MatrixFree<Eigen::GMRES>>();
  faults_leave_nothing<Structs, true>(phistep::midpoint, gmres, false);
  faults_leave_nothing<Components, true>(phistep::midpoint, gmres, false);
}

TEST_CASE("in place: a field and its rates, float and long double", "[embed]") {
  same_heat<double>(phistep::trapezoidal, phistep::newton<phistep::MatrixFree<Eigen::GMRES>>());
}

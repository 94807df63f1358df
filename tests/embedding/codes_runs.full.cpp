// An existing code and a state of the library under the same force, by a scheme of order 8.
#include "embedding/codes_runs_cases.hpp"

using namespace codes_cases;

TEST_CASE("atoms under a tolerance, by a scheme of order 8") {
  after::MolecularDynamics code(64);
  before::MolecularDynamics other(64);
  check(code, other, phistep::rkn86, phistep::mass(1.0), [](auto& stepper, auto& state) {
    return phistep::integrate(stepper, state, {0, 0.1}, phistep::tolerance{.rtol = 1e-8, .atol = 1e-8});
  });
}

// Controlled runs, restarted anywhere: other controls, observers, edits. In short: restart_run.test.cpp.
#include <phistep/phistep.hpp>

#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "contract/restart_run.hpp"
#include "contract/restart_run_cases.hpp"
#include "contract/states.hpp"
#include "problems/hires.hpp"
#include "problems/van_der_pol.hpp"
#include "support/catch.hpp"

using namespace phistep;
using restart_run::check;
using namespace restart_run;

TEST_CASE("other controls restart to the same bits") {
  const auto solver = fixed_point({.depth = 0});
  const iteration_control iterations{.first_step = 0.01, .order = 1, .max_step = 0.1};
  check(positive, steps(decay, trapezoidal, solver), 1, iterations);
  check(positive, steps(decay, trapezoidal, solver), 1, smaller_of(tolerance{.rtol = 1e-3}, iterations));
  check(positive, steps(decay, tr_bdf2), 1, fixed(0.03));
  check(pol, steps(problems::VanDerPol{}, velocity_verlet), 1, fixed(0.03));
}

TEST_CASE("observers that wait for times, and events, go on as they would have") {
  check(pol, steps(problems::VanDerPol{}, tr_bdf2), 6, tolerance{.rtol = 1e-3}, watchers);
  check(pol, steps(problems::VanDerPol{}, velocity_verlet), 6, tolerance{.rtol = 1e-3}, watchers);
  check(pol, steps(problems::VanDerPol{}, trapezoidal), 6, fixed(0.05), watchers);
}

TEST_CASE("a state that is edited after a restart is noticed") { check_edit(positive, decay); }

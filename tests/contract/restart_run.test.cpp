// Controlled runs, restarted anywhere: the lengths of the steps go on as they would have, to the bit. All products:
// restart_run*.stress.cpp.
#include <phistep/phistep.hpp>

#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "contract/restart_run.hpp"
#include "contract/restart_run_cases.hpp"
#include "support/catch.hpp"
#if PHISTEP_STRESS
#include "contract/states.hpp"
#include "problems/hires.hpp"
#include "problems/van_der_pol.hpp"
#endif

using namespace phistep;
using restart_run::check;
using namespace restart_run;

#if PHISTEP_FULL

namespace {

/// Of fixed size: half the time to compile that a dynamic vector takes.
using Three = Eigen::Vector3d;
const shared_force::OfState<Three> brief = [](const Three& y) -> Three { return -2 * y - y.cwiseProduct(y); };
Three three() { return {0.5, 1.25, 2}; }

}  // namespace

TEST_CASE("runs controlled by their error restart to the same bits") {
  const tolerance control{.rtol = 1e-3, .atol = 1e-6};
  check(three, steps(brief, forward_euler), 1, control);
  check(three, steps(brief, tr_bdf2), 1, control);
  check(three, steps(brief, phi_stage(0.7)), 1, control);  // by doubling
  check(three, steps(brief, generalized_alpha(0.5)), 1, control);
}

TEST_CASE("other controls restart to the same bits") {
  const auto solver = fixed_point({.depth = 0});
  const iteration_control iterations{.first_step = 0.01, .order = 1, .max_step = 0.1};
  check(three, steps(brief, trapezoidal, solver), 1, smaller_of(tolerance{.rtol = 1e-3}, iterations));
  check(three, steps(brief, forward_euler), 1, fixed(0.03));
}

TEST_CASE("observers that wait for times, and events, go on as they would have") {
  // With a force that has a memory, as "other scalars, borrowed states, forces with memory, halving" has it in full.
  check(pair, steps(Slider{}, velocity_verlet), 6, tolerance{.rtol = 1e-3}, watchers);
}

TEST_CASE("a state that is edited after a restart is noticed") { check_edit(three, brief); }

#elif PHISTEP_STRESS
// Controlled runs, restarted anywhere: controlled by their error.

TEST_CASE("runs controlled by their error restart to the same bits") {
  const tolerance control{.rtol = 1e-3, .atol = 1e-6};
  CHECK(check(hires, steps(problems::Hires{}, tr_bdf2), 50, control) > 10);
  check(hires, steps(problems::Hires{}, trapezoidal), 50, control);
  check(hires, steps(problems::Hires{}, backward_euler), 5, control);
  check(pol, steps(problems::VanDerPol{}, velocity_verlet), 8, control);
  check(pol, steps(problems::VanDerPol{}, trapezoidal), 8, tolerance{.rtol = 1e-4});
  check(positive, steps(decay, forward_euler), 1, control);
  check(positive, steps(decay, phi_stage(0.7)), 1, control);  // by doubling
  check(positive, steps(decay, rannacher(2)), 1, control);
}

#endif

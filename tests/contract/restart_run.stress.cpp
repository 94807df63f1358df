// Controlled runs, restarted anywhere: controlled by their error. The quick half: restart_run.test.cpp.
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

// First-order problems in float and double, restarted anywhere. long double: restart_scalars_wide.stress.cpp. In short:
// restart.test.cpp.
#include <phistep/phistep.hpp>

#include "contract/restart.hpp"
#include "contract/restart_cases.hpp"
#include "contract/states.hpp"
#include "support/catch.hpp"

using namespace phistep;
using namespace restart_cases;

TEST_CASE("other scalars") {
  check_scalar<float>(1e-3);
  check_scalar<double>(1e-6);
}

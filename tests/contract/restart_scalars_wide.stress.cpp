// First-order problems in long double, restarted anywhere. In short: restart.test.cpp.
#include <phistep/phistep.hpp>

#include "contract/restart.hpp"
#include "contract/restart_cases.hpp"
#include "contract/states.hpp"
#include "support/catch.hpp"

using namespace phistep;
using namespace restart_cases;

TEST_CASE("other scalars") { check_scalar<long double>(1e-9); }

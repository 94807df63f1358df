// event_set, every scalar. The quick half is event_set.test.cpp.
#include "run/observers/event_set_cases.hpp"

using namespace event_set_cases;

TEMPLATE_TEST_CASE("events: a bouncing ball meets every bounce up to the Zeno time, whatever the step", "", float,
                   double, long double) {
  check_bounces<TestType>();
}

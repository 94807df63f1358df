// How long a check of the interpolant holds.
#include <phistep/run/inside/look_inside.hpp>
//
#include <phistep/base/archive/archive.hpp>

#include <cmath>
#include <optional>

#include "support/catch.hpp"

using namespace phistep;

namespace {
/// How many of the next steps of length dt need no check.
int free_steps(InterpolantTrust& trust, double dt) {
  for (int n = 0;; ++n) {
    trust.step();
    if (!trust.known(dt, 0)) return n;
  }
}
}  // namespace

TEST_CASE("a clear result holds for 1, 2, then 4 steps") {
  for (const double error : {0.0, 0.05, 5.1, 1e9, std::nan("")}) {
    InterpolantTrust trust;
    CHECK_FALSE(trust.known(1, 0));
    CAPTURE(error);
    for (const int steps : {1, 2, 4, 4, 4}) {
      trust.check(1, 0, error);
      CHECK((trust.known(1, 0) <= InterpolantTrust::for_states) == (error <= 0.5));
      CHECK((trust.known(1, 0) <= InterpolantTrust::for_events) == (error <= 20));
      CHECK(free_steps(trust, 1) == steps);
    }
  }
}

TEST_CASE("a result near the limit holds for its own step alone, and the next clear one begins anew") {
  InterpolantTrust trust;
  for (int n = 0; n < 4; ++n) trust.check(1, 0, 0);
  for (const double error : {0.3, 0.7}) {
    trust.check(1, 0, error);
    CHECK((trust.known(1, 0) <= InterpolantTrust::for_states) == (error <= 0.5));
    CHECK(free_steps(trust, 1) == 0);
  }
  trust.check(1, 0, 0);
  CHECK(free_steps(trust, 1) == 1);
}

TEST_CASE("it holds for steps of about the same length") {
  InterpolantTrust trust;
  trust.check(0.1, 0, 0);
  CHECK_FALSE(trust.known(0.106, 0));
  CHECK_FALSE(trust.known(0.049, 0));
  CHECK(trust.known(0.104, 0));
  CHECK(trust.known(0.051, 0));
  trust.forget();
  CHECK_FALSE(trust.known(0.1, 0));
}

TEST_CASE("a right one holds as long as the step bends no more") {
  InterpolantTrust trust;
  trust.check(1, 10, 0.2);
  for (int n = 0; n < 32; ++n) {
    trust.step();
    CHECK(trust.known(1, 10).has_value() == (n < 31));
  }
  trust.check(1, 10, 0.2);
  trust.step();
  CHECK(*trust.known(0.5, 5) == 0.2);
  CHECK(*trust.known(1.4, 11) > 0.28);
  CHECK_FALSE(trust.known(1, 12));   // 0.2 · 1.2⁴ is more than 0.4
  CHECK_FALSE(trust.known(1.6, 1));  // a longer step
  CHECK_FALSE(trust.known(1, 0));    // not known
  trust.check(1, 10, 0.6);
  trust.step();
  CHECK_FALSE(trust.known(1, 1));
}

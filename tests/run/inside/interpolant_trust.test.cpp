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
    if (!trust.known(dt)) return n;
  }
}
}  // namespace

TEST_CASE("a clear result holds for 1, 2, then 4 steps") {
  for (const double error : {0.0, 0.05, 5.1, 1e9, std::nan("")}) {
    InterpolantTrust trust;
    CHECK_FALSE(trust.known(1));
    CAPTURE(error);
    for (const int steps : {1, 2, 4, 4, 4}) {
      trust.check(1, error);
      CHECK((trust.known(1) <= InterpolantTrust::for_states) == (error <= 0.5));
      CHECK((trust.known(1) <= InterpolantTrust::for_events) == (error <= 20));
      CHECK(free_steps(trust, 1) == steps);
    }
  }
}

TEST_CASE("a result near the limit holds for its own step alone, and the next clear one begins anew") {
  InterpolantTrust trust;
  for (int n = 0; n < 4; ++n) trust.check(1, 0);
  for (const double error : {0.3, 0.7}) {
    trust.check(1, error);
    CHECK((trust.known(1) <= InterpolantTrust::for_states) == (error <= 0.5));
    CHECK(free_steps(trust, 1) == 0);
  }
  trust.check(1, 0);
  CHECK(free_steps(trust, 1) == 1);
}

TEST_CASE("it holds for steps of about the same length") {
  InterpolantTrust trust;
  trust.check(0.1, 0);
  CHECK_FALSE(trust.known(0.106));
  CHECK_FALSE(trust.known(0.049));
  CHECK(trust.known(0.104));
  CHECK(trust.known(0.051));
  trust.forget();
  CHECK_FALSE(trust.known(0.1));
}

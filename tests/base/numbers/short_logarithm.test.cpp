// Short logarithms: what they are off, everywhere that step lengths go.
#include "phistep/run/errors/step_filter.hpp"

#include <algorithm>
#include <cmath>

#include "support/catch.hpp"

using namespace phistep;

TEST_CASE("log2 and 2^x to 3e-7, exact at powers of two") {
  double of_log = 0, of_exp = 0;
  for (int k = -40; k <= 40; ++k)
    for (int n = 0; n < 1000; ++n) {
      const double x = std::ldexp(1 + n / 1000.0, k);
      of_log = std::max(of_log, std::abs(short_log2(x) - std::log2(x)));
      of_exp = std::max(of_exp, std::abs(short_exp2(k + n / 1000.0) / std::exp2(k + n / 1000.0) - 1));
    }
  CAPTURE(of_log, of_exp);
  CHECK(of_log <= 3e-7);
  CHECK(of_log >= 1e-8);  // a look at the right function
  CHECK(of_exp <= 3e-7);
  for (const int k : {-1000, -33, -1, 0, 1, 2, 500}) {
    CHECK(short_log2(std::ldexp(1.0, k)) == k);
    if (std::abs(k) < 1000) CHECK(short_exp2(k) == std::ldexp(1.0, k));
  }
}

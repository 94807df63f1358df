// banded_lu: the full product and what is dear to compile. The quick half is banded_lu.test.cpp.
#include "linear/banded_lu_cases.hpp"

using namespace banded_lu_cases;

TEMPLATE_TEST_CASE("solves A x = b for any band, where rows must change places too", "", float, double, long double) {
  for (const Index n : {1, 2, 3, 10, 57})
    for (const Index lower : {0, 1, 2, 5})
      for (const Index upper : {0, 1, 2, 7}) {
        if (lower >= n || upper >= n) continue;
        std::srand(static_cast<unsigned>(100 * lower + 10 * upper + n));
        BandedLu<TestType> lu;
        lu.resize(n, lower, upper);
        for (int again = 0; again < 3; ++again) {
          CAPTURE(n, lower, upper, again);
          Mat<TestType> A = random_band<TestType>(n, lower, upper);
          // A triangular random matrix may be as badly conditioned as it likes: not what is tested.
          if (lower == 0 || upper == 0) A.diagonal().array() += TestType{8};
          // A zero that pivoting must step around.
          else A(0, 0) = 0;
          fill(lu, A);
          if (n == 1 && A(0, 0) == 0) continue;
          REQUIRE(lu.factorize());
          check_solves(lu, A);
        }
      }
}

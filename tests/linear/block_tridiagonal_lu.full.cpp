// block_tridiagonal_lu: the full product and what is dear to compile. The quick half is block_tridiagonal_lu.test.cpp.
#include "linear/block_tridiagonal_lu_cases.hpp"

using namespace block_tridiagonal_lu_cases;

TEMPLATE_TEST_CASE("solves chains of blocks", "", Size<1>, Size<2>, Size<3>, Size<5>, Size<17>) {
  constexpr int b = TestType::value;
  for (const Index blocks : {1, 2, 3, 40}) {
    std::srand(static_cast<unsigned>(blocks));
    BlockTridiagonalLu<double, b> lu;
    lu.resize(blocks);
    for (int again = 0; again < 3; ++again) {
      const Mat A = fill(lu, 3.0 * b);
      CAPTURE(blocks, again);
      REQUIRE(lu.factorize());
      CHECK(backward_error(lu, A) <= 1e-15);  // dominant: no growth, a few units in the last place
    }
  }
}

TEMPLATE_TEST_CASE("what it accepts it solves to three quarters of the digits at least, dominant or not", "", Size<1>,
                   Size<2>, Size<3>) {
  constexpr int b = TestType::value;
  BlockTridiagonalLu<double, b> lu;
  lu.resize(60);
  int refused = 0;
  double worst = 0;
  for (unsigned seed = 1; seed <= 200; ++seed) {
    std::srand(seed);
    const Mat A = fill(lu, 0);
    if (!lu.factorize()) ++refused;
    else worst = std::max(worst, backward_error(lu, A));
  }
  CAPTURE(refused, worst);
  CHECK(refused > 0);
  CHECK(worst <= std::pow(2.3e-16, 0.75));
}

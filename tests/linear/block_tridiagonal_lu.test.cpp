#include "linear/block_tridiagonal_lu_cases.hpp"

using namespace block_tridiagonal_lu_cases;

TEMPLATE_TEST_CASE("solves chains of blocks", "", Size<2>) { check_chains<TestType::value>(); }

TEST_CASE("rows change places inside a block") {
  BlockTridiagonalLu<double, 2> lu;
  lu.resize(3);
  Mat A = fill(lu, 0);
  for (Index k = 0; k < 3; ++k) {
    lu.diagonal(k) << 0, 9, 9, 0;
    A.block<2, 2>(2 * k, 2 * k) = lu.diagonal(k);
  }
  REQUIRE(lu.factorize());
  CHECK(backward_error(lu, A) <= 1e-15);
}

TEMPLATE_TEST_CASE("what it accepts it solves to three quarters of the digits at least, dominant or not", "", Size<2>) {
  check_accepted<TestType::value>();
}

TEST_CASE("a singular or nearly singular diagonal block is refused, though the matrix is regular") {
  for (const double tiny : {0.0, 1e-300, 1e-14, -1e-10}) {
    BlockTridiagonalLu<double, 1> lu;
    lu.resize(2);
    const auto set = [&lu](double a) {
      lu.diagonal(0)(0) = a, lu.upper(0)(0) = 1;
      lu.lower(1)(0) = 1, lu.diagonal(1)(0) = 1;
    };
    set(tiny);
    CAPTURE(tiny);
    CHECK_FALSE(lu.factorize());
    set(2);  // and works again
    REQUIRE(lu.factorize());
    Vec x = Eigen::Vector2d(3, 2);
    lu.solve_in_place(x.data());
    CHECK(x == Eigen::Vector2d(1, 1));
  }
}

TEST_CASE("a singular matrix is refused") {
  for (Index hole = 0; hole < 4; ++hole) {
    BlockTridiagonalLu<double, 2> lu;
    lu.resize(4);
    for (Index k = 0; k < 4; ++k) lu.lower(k).setZero(), lu.upper(k).setZero(), lu.diagonal(k).setIdentity();
    lu.diagonal(hole).setOnes();
    CAPTURE(hole);
    CHECK_FALSE(lu.factorize());
  }
}

TEST_CASE("a chain with one bad entry is refused, or its solution tells") {
  constexpr Index blocks = 4;
  for (const double bad : {std::nan(""), HUGE_VAL, -HUGE_VAL})
    for (int which = 0; which < 3; ++which)
      for (Index k = 0; k < blocks; ++k)
        for (int entry = 0; entry < 4; ++entry) {
          if ((which == 0 && k == 0) || (which == 2 && k == blocks - 1)) continue;
          BlockTridiagonalLu<double, 2> lu;
          lu.resize(blocks);
          std::srand(7);
          static_cast<void>(fill(lu, 8));
          (which == 0 ? lu.lower(k) : which == 1 ? lu.diagonal(k) : lu.upper(k)).data()[entry] = bad;
          Vec x = Vec::Ones(2 * blocks);
          const bool accepted = lu.factorize();
          if (accepted) lu.solve_in_place(x.data());
          CAPTURE(which, k, entry, bad);
          CHECK_FALSE((accepted && x.allFinite()));
        }
}

TEST_CASE("the empty chain is regular") {
  BlockTridiagonalLu<double, 3> lu;
  lu.resize(0);
  CHECK(lu.factorize());
}

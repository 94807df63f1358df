// block_tridiagonal_system: all sizes against dense steps, and motions.
// The quick half is block_tridiagonal_system.test.cpp.
#include "matrix/block_tridiagonal_system_cases.hpp"

using namespace block_tridiagonal_cases;

TEST_CASE("blocks of two and three, by differences, equal the dense steps; a last block may be short") {
  const auto check = [](const Vec& from, auto force, auto annotated, int colors) {
    Vec dense = from, chain = from;
    const Statistics all = steps(dense, force, trapezoidal, 5, 0.05);
    const Statistics few = steps(chain, annotated, trapezoidal, 5, 0.05);
    CHECK(few.force_calls == few.iterations + colors * few.jacobians);
    CHECK(few.iterations == all.iterations);
    CHECK(few.fallbacks == 0);
    CHECK(few.analyses == 0);
    // To rounding in five steps: κ(W) ≤ 5, states of size 3.
    CHECK((dense - chain).cwiseAbs().maxCoeff() <= 5 * 5 * 3 * 8 * 2.3e-16);
  };
  check(start(40), brusselator, block_tridiagonal<2>(brusselator), 6);
  for (const Eigen::Index n : {3, 30, 31, 32}) check(wave(n), wide, block_tridiagonal<3>(wide), n == 3 ? 3 : 9);
}

TEST_CASE("a motion: K and C in blocks") {
  const auto force = [](const Vec& r, const Vec& v) -> Vec { return wide(r) + 0.2 * wide(v); };
  const Motion<Vec> from{wave(31), wave(31).reverse()};
  Motion<Vec> dense = from, chain = from;
  steps(dense, force, trapezoidal, 5, 0.05, mass(2.0));
  const Statistics s = steps(chain, block_tridiagonal<3>(force), trapezoidal, 5, 0.05, mass(2.0));
  CHECK(s.fallbacks == 0);
  CHECK((dense.r - chain.r).cwiseAbs().maxCoeff() <= 5 * 5 * 8 * 2.3e-16);
  CHECK((dense.v - chain.v).cwiseAbs().maxCoeff() <= 5 * 5 * 8 * 2.3e-16);
}

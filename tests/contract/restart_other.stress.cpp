// First-order problems, restarted anywhere: affine forces, no matrix, masses. In short: restart.test.cpp.
#include <phistep/krylov.hpp>
#include <phistep/sparse.hpp>

#include <Eigen/IterativeLinearSolvers>

#include "contract/restart.hpp"
#include "contract/restart_cases.hpp"
#include "contract/states.hpp"
#include "support/catch.hpp"

using namespace phistep;
using namespace restart_cases;

TEST_CASE("affine forces go on with their factors and their checks") {
  for (const Steps& s : {even, uneven}) {
    const Statistics dense = check(s, start, steps(linear(tangent(start())), trapezoidal));
    CHECK(dense.jacobians == 1);
    CHECK(dense.factorizations == (s.even ? 1 : 60));
    check(s, start, steps(linear(Sparse(tangent(start()).sparseView())), trapezoidal));
    check(s, start, steps(affine([](const Vec& y) -> Vec { return -2 * y; }), tr_bdf2));
  }
}

TEST_CASE("masses of all kinds") {
  const Vec one_each = Vec::LinSpaced(n, 1, 2);
  const Mat full = Mat::Identity(n, n) * 2 + Mat::Constant(n, n, 0.1);
  check(loosely(uneven), start, steps(chain, phi(0.7), capacity(one_each), tolerant()));
  check(loosely(uneven), start, steps(chain, phi(0.7), capacity(full), tolerant()));
  check(loosely(uneven), start, steps(WithSparseJacobian{}, tr_bdf2, capacity(one_each), tolerant()));
}

TEST_CASE("iterations without a matrix restart to the same bits") {
  check(uneven, start, steps(chain, tr_bdf2, fixed_point()));
  check(loosely(uneven), start, steps(chain, phi(0.8), fixed_point({.rtol = 1e-5, .atol = 1e-7})));
  check(uneven, start, steps(chain, tr_bdf2, newton<MatrixFree<>>()));
}

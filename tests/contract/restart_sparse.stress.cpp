// First-order problems, restarted anywhere: banded and sparse systems. In short: restart.test.cpp.
#include <phistep/sparse.hpp>

#include <Eigen/IterativeLinearSolvers>
#include <Eigen/SparseCholesky>

#include <utility>

#include "contract/restart.hpp"
#include "contract/restart_cases.hpp"
#include "contract/states.hpp"
#include "support/catch.hpp"

using namespace phistep;
using namespace restart_cases;

TEST_CASE("banded and sparse systems restart to the same bits") {
  for (const Steps& s : {even, uneven}) {
    check(loosely(s), start, steps(banded(chain, 1, 1), tr_bdf2, tolerant()));
    check(loosely(s), start, steps(sparsity(chain, tangent(start()).sparseView().eval()), tr_bdf2, tolerant()));
    const Statistics lu = check(loosely(s), start, steps(WithSparseJacobian{}, tr_bdf2, tolerant()));
    CHECK(lu.analyses == 1);
    CHECK(lu.factorizations < lu.steps);
  }
  CHECK(check(even, start, steps(Thinning{}, trapezoidal)).analyses > 1);
  check({1e-3}, start, steps(WithSparseJacobian{}, trapezoidal));
}

TEST_CASE("symmetric systems restart to the same bits, and so do the users' own solvers") {
  const Statistics ldlt = check(loosely(uneven), start, steps(symmetric(Even{}), tr_bdf2, tolerant()));
  CHECK(ldlt.fallbacks == 0);
  CHECK(ldlt.analyses == 1);
  // Growth at rates about 6, until the cubes catch it: W is indefinite at first, and definite later.
  const Statistics lu = check({0.3, false, 40}, start, steps(symmetric(Even{9}), backward_euler, linearly_implicit()));
  CHECK(lu.fallbacks > 0);
  CHECK(lu.fallbacks < lu.factorizations);
  CHECK(lu.analyses == 2);
  check(loosely(uneven), start, steps(symmetric(Even{}), tr_bdf2, tolerant<Eigen::SimplicialLDLT<Sparse>>()));
  check(loosely(uneven), start, steps(WithSparseJacobian{}, tr_bdf2, tolerant<Eigen::BiCGSTAB<Sparse>>()));
}

TEST_CASE("a stepper that is moved takes its factors along, whatever the solver") {
  check_moved(steps(WithSparseJacobian{}, tr_bdf2, tolerant()));
  check_moved(steps(WithSparseJacobian{}, tr_bdf2, tolerant<Eigen::BiCGSTAB<Sparse>>()));  // refers to the matrix
}

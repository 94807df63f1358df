// spring_rows: the full product and what is dear to compile. The quick half is spring_rows.test.cpp.
#include "force/springs/spring_rows_cases.hpp"

using namespace spring_rows_cases;

TEMPLATE_TEST_CASE_SIG("rows are the loop over springs, but for rounding", "", ((class Scalar, int dim), Scalar, dim),
                       (double, 3), (double, 2), (double, 1), (float, 3)) {
  for (const Mesh mesh : {Mesh::grid, Mesh::diagonals, Mesh::anyhow})
    for (const int side : {2, 5, 23}) {
      auto springs = springs_of(mesh, side);
      Points<Scalar, dim> y(side * side + 3);  // three without springs
      y.r.col(springs[1].i) = y.r.col(springs[1].j), springs[1].length = 0;
      CHECK(error<Scalar, dim, false>(springs, y, forces<Scalar, dim, false>(springs, y)) <= 1);
      CHECK(error<Scalar, dim, true>(springs, y, forces<Scalar, dim, true>(springs, y)) <= 1);
      springs = renumbered(springs, side * side);
      CHECK(error<Scalar, dim, true>(springs, y, forces<Scalar, dim, true>(springs, y)) <= 1);
    }
}

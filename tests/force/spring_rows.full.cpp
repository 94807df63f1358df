// spring_rows: the full product and what is dear to compile. The quick half is spring_rows.test.cpp.
#include "force/spring_rows_cases.hpp"

using namespace spring_rows_cases;

TEMPLATE_TEST_CASE_SIG("rows are the loop over springs, but for rounding", "", ((class Scalar, int dim), Scalar, dim),
                       (double, 3), (double, 2), (double, 1), (float, 3)) {
  for (const Mesh mesh : {Mesh::grid, Mesh::diagonals, Mesh::anyhow})
    for (const int side : {2, 5, 23}) {
      auto springs = springs_of(mesh, side);
      Points<Scalar, dim> y(side * side + 3);  // three without springs
      y.r.col(springs[1].i) = y.r.col(springs[1].j);
      CHECK(error<Scalar, dim, false>(springs, y, forces<Scalar, dim, false>(springs, y)) <= 1);
      CHECK(error<Scalar, dim, true>(springs, y, forces<Scalar, dim, true>(springs, y)) <= 1);
      std::shuffle(springs.begin(), springs.end(), std::mt19937(1));
      std::vector<std::ptrdiff_t> name(static_cast<std::size_t>(side * side));
      std::iota(name.begin(), name.end(), 0);
      std::shuffle(name.begin(), name.end(), std::mt19937(2));
      for (Spring& s : springs) s.i = name[static_cast<std::size_t>(s.i)], s.j = name[static_cast<std::size_t>(s.j)];
      CHECK(error<Scalar, dim, true>(springs, y, forces<Scalar, dim, true>(springs, y)) <= 1);
    }
}

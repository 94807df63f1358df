// The fill of sparse factors, counted without them.
#include <phistep/linear/sparse/factor_cost.hpp>

#include <Eigen/SparseCholesky>

#include <vector>

#include "problems/reaction_diffusion.hpp"
#include "support/catch.hpp"

using namespace phistep;
using Sparse = Eigen::SparseMatrix<double>;
using Mat = Eigen::MatrixXd;

TEST_CASE("chains have no fill, full matrices all, an arrow none where its head comes last") {
  Mat chain = Mat::Identity(50, 50), arrow = chain;
  chain.diagonal(1).setOnes(), chain.diagonal(-1).setOnes();
  arrow.row(0).setOnes(), arrow.col(0).setOnes();
  for (const Mat& A : {chain, arrow}) {
    const FactorCost cost = factor_cost<double>(A.sparseView());
    CHECK(cost.unknowns == 50);
    CHECK(cost.entries == 49);
    CHECK(cost.products == 49);
  }
  const FactorCost full = factor_cost<double>(Mat::Ones(5, 5).sparseView());
  CHECK(full.entries == 10);
  CHECK(full.products == 16 + 9 + 4 + 1);
  CHECK(factor_cost(Sparse(7, 7)).entries == 0);
}

TEST_CASE("values and the missing half don't matter") {
  const Sparse A = problems::ReactionDiffusion{.m = 9}.pattern();
  const FactorCost all = factor_cost(A), lower = factor_cost(Sparse(A.triangularView<Eigen::Lower>())),
                   zeros = factor_cost(Sparse(0 * A));
  CHECK(all.entries == lower.entries);
  CHECK(all.entries == zeros.entries);
  CHECK(all.products == lower.products);
}

TEST_CASE("a part is counted until it says enough: a bound from below, exact where that never comes") {
  const Sparse A = problems::ReactionDiffusion{.m = 64}.pattern();
  const FactorCost all = factor_cost(A), half = factor_cost(neighbourhood(A, 512)),
                   other = factor_cost(neighbourhood(A, 1024));
  CHECK(half.unknowns == 512);
  CHECK(0.4 * all.entries_an_unknown() < half.entries_an_unknown());
  CHECK(half.entries_an_unknown() < other.entries_an_unknown());
  CHECK(other.entries_an_unknown() < all.entries_an_unknown());
  const auto until = [&A](double entries) {
    return factor_cost(A, [entries](const FactorCost& part) { return part.entries_an_unknown() >= entries; });
  };
  CHECK(until(half.entries_an_unknown()).unknowns == 512);
  CHECK(until(half.entries_an_unknown() + 0.01).unknowns == 1024);
  CHECK(until(1e9).entries == all.entries);

  // Pieces that are not connected, and a pattern of the diagonal alone, are gone through to the end.
  Sparse twice(8192, 8192), diagonal(3000, 3000);
  diagonal.setIdentity();
  CHECK(neighbourhood(diagonal, 512).nonZeros() == 512);
  std::vector<Eigen::Triplet<double>> entries;
  for (Eigen::Index k = 0; k < A.cols(); ++k)
    for (Sparse::InnerIterator a(A, k); a; ++a)
      for (const Eigen::Index from : {Eigen::Index{0}, A.cols()}) entries.emplace_back(from + a.row(), from + k, 1.0);
  twice.setFromTriplets(entries.begin(), entries.end());
  CHECK(factor_cost(neighbourhood(twice, 8192)).entries == 2 * all.entries);
  CHECK(factor_cost(neighbourhood(twice, 6000)).unknowns == 6000);
}

TEST_CASE("grids: the count is that of the factors, and grows as nested dissection's bounds say") {
  const auto cost = [](Eigen::Index m, int dim) {
    const Sparse A = problems::ReactionDiffusion{.m = m, .dim = dim, .rate = 0}.pattern();
    const FactorCost counted = factor_cost(A);
    Eigen::SimplicialLDLT<Sparse> made(Sparse(-A));
    CHECK(counted.entries == made.matrixL().nestedExpression().nonZeros());
    return counted;
  };
  // Entries n log n in the plane, n^(4/3) in space; products n^(3/2) and n².
  const FactorCost small_plane = cost(20, 2), plane = cost(40, 2), small_cube = cost(8, 3), cube = cost(16, 3);
  CHECK(plane.entries_an_unknown() < 1.6 * small_plane.entries_an_unknown());
  CHECK(plane.products_an_unknown() > 1.5 * small_plane.products_an_unknown());
  CHECK(cube.entries_an_unknown() > 1.6 * small_cube.entries_an_unknown());
  CHECK(cube.products_an_unknown() > 4 * small_cube.products_an_unknown());
}

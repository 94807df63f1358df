#include <phistep/sparse.hpp>

#include "support/catch.hpp"

using namespace phistep;
using Mat = Eigen::MatrixXd;
using Vec = Eigen::VectorXd;

namespace {
/// The bound mass of a block of as many components as M has rows.
template <class M>
auto bound(const M& m) {
  return std::get<0>(capacity(m).masses).template bind<double>(Vec::Zero(m.rows()).eval());
}
Eigen::SparseMatrix<double> sparse(const Mat& m) { return m.sparseView(); }

void check_inverse(const auto& mass, const Mat& M) {
  for (Eigen::Index j = 0; j < M.cols(); ++j) {
    Vec b = M.col(j);
    mass.solve(b);
    CHECK((M * b - M.col(j)).norm() <= 1e-14 * M.norm());  // M G M = M
    Vec x = M.col(j);
    mass.keep_unexplained(x);
    CHECK(x.norm() == 0);  // rounding is taken out
    x = Vec::Unit(M.cols(), j);
    mass.keep_unseen(x);
    CHECK((M * x).cwiseQuotient(M.cwiseAbs().rowwise().maxCoeff()).norm() <= 1e-14);
  }
}
}  // namespace

TEST_CASE("a generalized inverse of singular masses") {
  Mat pairs = Mat::Zero(5, 5);
  pairs.block<2, 2>(0, 0) << -1e-6, 1e-6, 1e-6, -1e-6;
  pairs(2, 2) = 1e9;
  pairs.block<2, 2>(3, 3) << 3, -3, -3, 3;
  check_inverse(bound(pairs), pairs);
  check_inverse(bound(sparse(pairs)), pairs);
  CHECK(bound(pairs).algebraic() >= 0);
  CHECK(bound(sparse(pairs)).algebraic() >= 0);
  Vec e = Vec::Ones(5);
  bound(pairs).keep_unexplained(e);
  CHECK((e - Vec{{1, 1, 0, 1, 1}}).norm() <= 1e-14);  // sums of the pairs' rows are algebraic
  const Mat zero_row = Vec{{1, 0, 2}}.asDiagonal();
  CHECK(bound(zero_row).algebraic() == 1);
  CHECK(bound(sparse(zero_row)).algebraic() == 1);
  CHECK(bound(Vec(zero_row.diagonal())).algebraic() == 1);
}

TEST_CASE("a mass matrix is singular where rounding of its entries explains it, and not before") {
  const auto near = [](double by) { return Mat{{1, 1, 0}, {1, 1 + by, 0}, {0, 0, 1}}; };
  for (const double by : {1e-8, 1e-12, 1e-13}) {
    CAPTURE(by);
    CHECK(bound(near(by)).algebraic() == -1);
    CHECK(bound(sparse(near(by))).algebraic() == -1);
  }
  for (const double by : {0.0, 2e-16}) {
    CAPTURE(by);
    CHECK(bound(near(by)).algebraic() >= 0);
    CHECK(bound(sparse(near(by))).algebraic() >= 0);
  }
  // Units are no singularity.
  const Vec scales{{1e-12, 1, 1e14}};
  const Mat badly_scaled = scales.asDiagonal() * Mat{{2, 1, 0}, {1, 2, 1}, {0, 1, 2}} * scales.asDiagonal();
  CHECK(bound(badly_scaled).algebraic() == -1);
  CHECK(bound(sparse(badly_scaled)).algebraic() == -1);
}

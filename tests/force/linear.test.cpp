// Forces given as matrices, and what annotations say of a lambda.
#include "force/linear_cases.hpp"

using namespace linear_cases;

TEST_CASE("linear(K, C) is K r + C v, dense or sparse, and its Jacobian is K and C") {
  const auto [K, C, y] = Random{};
  CHECK((psi(y, linear(K, C)) - K * y.r - C * y.v).norm() <= rounding);
  CHECK(check_jacobian(linear(K, C), y));
}

TEST_CASE("linear(-S) keeps the matrix, not the expression, which refers to S") {
  const Sparse S = Mat(Mat::Identity(2, 2)).sparseView();
  static_assert(std::is_same_v<decltype(linear(-Mat(2, 2))), LinearForce<Mat>>);
  static_assert(std::is_same_v<decltype(linear(Mat(2, 2), -2 * Mat(2, 2))), LinearForce<Mat, Mat>>);
  CHECK(linear(-S).K.coeff(1, 1) == -1);
}

TEST_CASE("matrices that don't fit are refused, before anything is written") {
  CHECK_THROWS_AS(linear(Mat(2, 3)), std::invalid_argument);
  CHECK_THROWS_AS(linear(Mat(Mat::Identity(2, 2)), Mat(Mat::Identity(3, 3))), std::invalid_argument);
  Vec y = Vec::Ones(3);
  const Vec before = y;
  PhiStepper stepper{y, linear(Mat(Mat::Identity(2, 2))), forward_euler};
  CHECK_THROWS_AS(static_cast<void>(stepper.step(y, 0, 0.1)), std::invalid_argument);
  CHECK((y.array() == before.array()).all());
}

TEST_CASE("annotations are seen through each other, through term(…) and through sums; what they wrap keeps its form") {
  static_assert(!OfMotion<Hooke>::is_affine && OfMotion<Hooke>::arity == 1);
  using Affine1 = decltype(affine(hooke));
  static_assert(OfMotion<Affine1>::is_affine && OfMotion<Affine1>::arity == 1 && !OfMotion<Affine1>::uses_velocity);
  using Both = decltype(affine(symmetric(banded(hooke, 1, 1))));
  static_assert(OfVector<Both>::is_affine && OfVector<Both>::is_symmetric && OfVector<Both>::has_pattern);
  static_assert(OfVector<Both>::structure == Structure::banded);
  using Annotated = decltype(affine(term(hooke) + LinearDrag{1}));
  static_assert(OfMotion<Annotated>::is_affine && OfMotion<Annotated>::uses_velocity);
  static_assert(!OfMotion<decltype(term(hooke) + LinearDrag{1})>::is_affine);
  static_assert(OfMotion<decltype(linear(Mat{}))>::is_affine);
  CHECK(Callable<double (*)(double)>{&one}(0) == 1);  // functions, too
}

TEST_CASE("patterns: a band, blocks with a short last one, a sparse matrix") {
  const ColumnPattern band = band_pattern(4, 1, 0);
  CHECK(band.start == std::vector<Eigen::Index>{0, 2, 4, 6, 7});
  CHECK(band.row == std::vector<Eigen::Index>{0, 1, 1, 2, 2, 3, 3});
  const ColumnPattern chain = band_pattern(5, 1, 1, 2);
  CHECK(chain.columns() == 5);
  CHECK(chain.row.size() == 4 + 4 + 5 + 5 + 3);
  const ColumnPattern from = pattern_of(Sparse(Mat::Identity(3, 3).sparseView()));
  CHECK(from.row == std::vector<Eigen::Index>{0, 1, 2});
  CHECK_THROWS_AS(banded(hooke, -1, 0), std::invalid_argument);
}

// Forces given as matrices, and what annotations say of a lambda.
#include <phistep/sparse.hpp>

#include <functional>

#include "support/catch.hpp"

using namespace phistep;
using Vec = Eigen::VectorXd;
using Mat = Eigen::MatrixXd;
using Sparse = Eigen::SparseMatrix<double>;
using Y = Motion<Vec>;

namespace linear_cases {

template <class F>
using OfMotion = ForceTraits<F, MotionView<Vec, UnitMass>, Y::Rate>;
template <class F>
using OfVector = ForceTraits<F, FirstOrderView<Vec, UnitMass>, RateOf<Vec>>;

inline const auto hooke = [](const Vec& r) -> Vec { return -2 * r; };
using Hooke = decltype(hooke);
inline double one(double) { return 1; }

/// K and C at random, and a motion.
struct Random {
  Mat K = Mat::Random(6, 6), C = Mat::Random(6, 6);
  Y y{Vec::LinSpaced(6, -1, 1), Vec::LinSpaced(6, 2, 3)};
};
/// Ψ at y: what a step of 1 adds to v.
Vec psi(const Y& y, const auto& force) {
  PhiStepper stepper{y, force, forward_euler};
  Y next = y;
  REQUIRE(stepper.step(next, 0, 1));
  return next.v - y.v;
}
inline constexpr double rounding = 1e-14;

}  // namespace linear_cases

using namespace linear_cases;

#if PHISTEP_QUICK

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

#elif PHISTEP_FULL

TEST_CASE("linear(K, C) is K r + C v, dense or sparse, and its Jacobian is K and C") {
  const auto [K, C, y] = Random{};
  CHECK((psi(y, linear(K)) - K * y.r).norm() <= rounding);
  CHECK((psi(y, linear(Sparse(K.sparseView()), Sparse(C.sparseView()))) - K * y.r - C * y.v).norm() <= rounding);
  CHECK(check_jacobian(linear(Sparse(K.sparseView()), Sparse(C.sparseView())), y));
  CHECK(check_jacobian(linear(K), Vec(y.r)));
}

TEST_CASE("annotations are seen through each other, through term(…) and through sums; what they wrap keeps its form") {
  const auto f = [](const Vec& y) -> Vec { return -y; };
  Vec a = Vec::Ones(3), b = a, c = a;
  PhiStepper plain{a, f, trapezoidal};
  PhiStepper wrapped{b, affine(symmetric(f)), trapezoidal};
  PhiStepper outside{c, affine(std::ref(f)), trapezoidal};
  REQUIRE(plain.step(a, 0, 0.1));
  REQUIRE(wrapped.step(b, 0, 0.1));
  REQUIRE(outside.step(c, 0, 0.1));
  CHECK((a - b).norm() <= 1e-15);
  CHECK((b.array() == c.array()).all());
}

#endif

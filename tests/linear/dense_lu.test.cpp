#include <phistep/linear/dense_lu.hpp>

#include <cmath>
#include <type_traits>

#include "support/catch.hpp"

using phistep::DenseLu;

template <int n>
struct Size {
  static constexpr int value = n;
  static constexpr int rows = n == Eigen::Dynamic ? 23 : n;
};

// 3 takes the unrolled loops, 17 and Dynamic Eigen's.
TEMPLATE_TEST_CASE("solves A x = b", "", Size<1>, Size<3>, Size<16>, Size<17>, Size<Eigen::Dynamic>) {
  using Vector = Eigen::Matrix<double, TestType::value, 1>;
  DenseLu<double, TestType::value> lu;
  lu.resize(TestType::rows);
  for (unsigned seed = 1; seed <= 10; ++seed) {
    std::srand(seed);
    auto& A = lu.matrix();
    A.setRandom(TestType::rows, TestType::rows);
    A.diagonal().setZero();  // no solution without pivoting
    if (TestType::rows == 1) A(0, 0) = 3;
    const Eigen::MatrixXd kept = A;
    const Vector b = Vector::Random(TestType::rows);
    Vector x = b;
    REQUIRE(lu.factorize());
    lu.solve_in_place(x);
    CHECK((kept * x - b).norm() <= 1e-12 * (kept.norm() * x.norm() + b.norm()));
  }
}

TEMPLATE_TEST_CASE("a singular matrix is refused, not divided by zero", "", Size<1>, Size<3>, Size<17>,
                   Size<Eigen::Dynamic>) {
  DenseLu<double, TestType::value> lu;
  lu.resize(TestType::rows);
  lu.matrix().setZero(TestType::rows, TestType::rows);
  CHECK_FALSE(lu.factorize());
  lu.matrix().setOnes();
  if (TestType::rows > 1) CHECK_FALSE(lu.factorize());
  lu.matrix().setIdentity();
  lu.matrix()(TestType::rows - 1, TestType::rows - 1) = 0;
  CHECK_FALSE(lu.factorize());
}

TEMPLATE_TEST_CASE("a matrix with one bad entry is refused", "", Size<1>, Size<3>, Size<17>, Size<Eigen::Dynamic>) {
  DenseLu<double, TestType::value> lu;
  lu.resize(TestType::rows);
  for (const double bad : {std::nan(""), HUGE_VAL, -HUGE_VAL})
    for (int i = 0; i < TestType::rows; ++i)
      for (int j = 0; j < TestType::rows; ++j) {
        lu.matrix().setIdentity(TestType::rows, TestType::rows);
        lu.matrix()(i, j) = bad;
        Eigen::Matrix<double, TestType::value, 1> x(TestType::rows);
        x.setOnes();
        const bool accepted = lu.factorize();
        if (accepted) lu.solve_in_place(x);
        CAPTURE(i, j, bad);
        // An infinity off the diagonal may leave all pivots finite; the solution then gives it away.
        CHECK_FALSE((accepted && x.allFinite()));
      }
}

TEST_CASE("factorising again after a singular matrix works") {
  DenseLu<double, 2> lu;
  lu.matrix() << 1, 2, 2, 4;
  CHECK_FALSE(lu.factorize());
  lu.matrix() << 0, 2, 4, 0;
  REQUIRE(lu.factorize());
  Eigen::Vector2d x(2, 4);
  lu.solve_in_place(x);
  CHECK(x == Eigen::Vector2d(1, 1));
}

TEST_CASE("the empty matrix is regular") {
  DenseLu<double, Eigen::Dynamic> lu;
  lu.resize(0);
  CHECK(lu.factorize());
}

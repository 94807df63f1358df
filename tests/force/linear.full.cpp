// linear: the full product and what is dear to compile. The quick half is linear.test.cpp.
#include "force/linear_cases.hpp"

using namespace linear_cases;

TEST_CASE("linear(K, C) is K r + C v, dense or sparse, and its Jacobian is K and C") {
  Mat K = Mat::Random(6, 6), C = Mat::Random(6, 6);
  const Y y{Vec::LinSpaced(6, -1, 1), Vec::LinSpaced(6, 2, 3)};
  const auto psi = [&y](auto force) {
    PhiStepper stepper{y, force, forward_euler};
    Y next = y;
    REQUIRE(stepper.step(next, 0, 1));
    return Vec(next.v - y.v);
  };
  const double rounding = 1e-14;
  CHECK((psi(linear(K)) - K * y.r).norm() <= rounding);
  CHECK((psi(linear(K, C)) - K * y.r - C * y.v).norm() <= rounding);
  CHECK((psi(linear(Sparse(K.sparseView()), Sparse(C.sparseView()))) - K * y.r - C * y.v).norm() <= rounding);
  CHECK(check_jacobian(linear(K, C), y));
  CHECK(check_jacobian(linear(Sparse(K.sparseView()), Sparse(C.sparseView())), y));
  CHECK(check_jacobian(linear(K), Vec(y.r)));
}

TEST_CASE("annotations are seen through each other, through term(…) and through sums; what they wrap keeps its form") {
  static_assert(!OfMotion<Hooke>::is_affine && OfMotion<Hooke>::arity == 1);
  using Affine1 = decltype(affine(hooke));
  static_assert(OfMotion<Affine1>::is_affine && OfMotion<Affine1>::arity == 1 && !OfMotion<Affine1>::uses_velocity);
  using Both = decltype(affine(symmetric(banded(hooke, 1, 1))));
  static_assert(OfVector<Both>::is_affine && OfVector<Both>::is_symmetric && OfVector<Both>::has_pattern);
  static_assert(OfVector<Both>::structure == Structure::banded);
  using Chain = decltype(block_tridiagonal<2>(hooke));
  static_assert(OfVector<Chain>::structure == Structure::block_tridiagonal && OfVector<Chain>::block == 2);
  using Annotated = decltype(affine(term(hooke) + LinearDrag{1}));
  static_assert(OfMotion<Annotated>::is_affine && OfMotion<Annotated>::uses_velocity);
  static_assert(!OfMotion<decltype(term(hooke) + LinearDrag{1})>::is_affine);
  static_assert(OfMotion<decltype(linear(Mat{}))>::is_affine);
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
  CHECK(Callable<double (*)(double)>{&one}(0) == 1);  // functions, too
}

// linear: the full product and what is dear to compile. The quick half is linear.test.cpp.
#include "force/linear_cases.hpp"

using namespace linear_cases;

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

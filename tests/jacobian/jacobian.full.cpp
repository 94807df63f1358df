// jacobian: the full product and what is dear to compile. The quick half is jacobian.test.cpp.
#include "jacobian/jacobian_cases.hpp"

using namespace jacobian_cases;

TEST_CASE("check_jacobian works on views, matrices and at a time") {
  states::FirstOrder<states::Columns> columns;
  CHECK(check_jacobian(Timed{}, columns.state, 3.0));
  states::FirstOrder<states::Strided> strided;
  CHECK(check_jacobian(Timed{}, strided.state, 3.0));
}

TEST_CASE("automatic differentiation of a motion gives K and C at t") {
  auto force = autodiff([](const auto& r, const auto& v, double t) {
    std::remove_cvref_t<decltype(r)> f = r;
    for (Eigen::Index i = 0; i < r.size(); ++i) f[i] = -r[i] * r[i] * t - 0.5 * v[i];
    return f;
  });
  const Eigen::Vector2d r(1, 2), v(3, 4);
  const auto J = force.jacobian(r, v, 10.0);
  CHECK(J.K.isApprox(Eigen::Matrix2d(Eigen::Vector2d(-20, -40).asDiagonal())));
  CHECK(J.C.isApprox(Eigen::Matrix2d(-0.5 * Eigen::Matrix2d::Identity())));
  CHECK(check_jacobian(force, Motion<Eigen::Vector2d>{r, v}, 10.0));
}

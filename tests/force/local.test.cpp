// One particle's force for all particles: what it says of itself, its sums, its Jacobian.
#include <phistep/autodiff.hpp>
#include <phistep/phistep.hpp>

#include <cmath>

#include "support/catch.hpp"

using namespace phistep;
using Eigen::Matrix2d;
using Eigen::Matrix2Xd;
using Eigen::Vector2d;
using Vec = Eigen::VectorXd;
using Y = Motion<Vec>;

namespace {

template <class F>
using TraitsOf = ForceTraits<F, MotionView<Vec, UnitMass>, Y::Rate>;
template <class F>
using FirstOrderTraits = ForceTraits<F, FirstOrderView<Vec, UnitMass>, RateOf<Vec>>;

[[maybe_unused]] const auto of_r = local<2>([](const Vector2d& r) -> Vector2d { return -r; });
[[maybe_unused]] const auto of_v = local<2>([](const Vector2d& r, const Vector2d& v) -> Vector2d { return -r - v; });
[[maybe_unused]] const auto of_t =
    local<2>([](const Vector2d& r, const Vector2d& v, double t) -> Vector2d { return -r - t * v; });
[[maybe_unused]] const auto generic =
    local<2>([](const auto& r, const auto& v) { return typename std::decay_t<decltype(r)>(-r - v); });
[[maybe_unused]] const auto of_y = local<2>([](const Vector2d& y) -> Vector2d { return -y; });
[[maybe_unused]] const auto of_yt = local<2>([](const Vector2d& y, double t) -> Vector2d { return -t * y; });

/// A swirling well whose C depends on r.
struct Swirl {
  Vector2d operator()(const Vector2d& r, const Vector2d& v) const {
    return -r.squaredNorm() * r - std::sin(r[0]) * Vector2d(v[1], -v[0]);
  }
  [[nodiscard]] static MotionJacobian<Matrix2d> jacobian(const Vector2d& r, const Vector2d& v) {
    Matrix2d K = -r.squaredNorm() * Matrix2d::Identity() - 2 * r * r.transpose(), C;
    K.col(0) -= std::cos(r[0]) * Vector2d(v[1], -v[0]);
    C << 0, -std::sin(r[0]), std::sin(r[0]), 0;
    return {K, C};
  }
};

}  // namespace

TEST_CASE("the kind of state and f's arguments tell what a local force needs") {
  CHECK_FALSE(TraitsOf<std::remove_const_t<decltype(of_r)>>::uses_velocity);
  CHECK_FALSE(TraitsOf<std::remove_const_t<decltype(of_r)>>::uses_time);
  CHECK(TraitsOf<std::remove_const_t<decltype(of_v)>>::uses_velocity);
  CHECK_FALSE(TraitsOf<std::remove_const_t<decltype(of_v)>>::uses_time);
  CHECK(TraitsOf<std::remove_const_t<decltype(of_t)>>::uses_time);
  CHECK(TraitsOf<std::remove_const_t<decltype(generic)>>::uses_velocity);
  CHECK_FALSE(FirstOrderTraits<std::remove_const_t<decltype(of_y)>>::uses_time);
  CHECK(FirstOrderTraits<std::remove_const_t<decltype(of_yt)>>::uses_time);
  using Known = Local<2, Swirl>;
  STATIC_REQUIRE(TraitsOf<Known>::has_jacobian);
  STATIC_REQUIRE(TraitsOf<Known>::structure == Structure::local);
  STATIC_REQUIRE(TraitsOf<Known>::block == 2);
  using All = decltype(Known{Swirl{}} + LinearDrag{1.0} + Gravity{Vector2d(0, -1)});
  STATIC_REQUIRE(TraitsOf<All>::structure == Structure::local);
  STATIC_REQUIRE(is_particlewise<All, 2>);
  STATIC_REQUIRE_FALSE(is_particlewise<decltype(Known{Swirl{}} + Gravity{Vec(Vec::Ones(8))}), 2>);
}

TEST_CASE("its Jacobian agrees with differences, alone and in a sum") {
  Motion<Matrix2Xd> y{Matrix2Xd::Random(2, 5), Matrix2Xd::Random(2, 5)};
  CHECK(check_jacobian(local<2>(Swirl{}), y).agrees);
  CHECK(check_jacobian(local<2>(Swirl{}) + LinearDrag{0.5}, y).agrees);
  const auto automatic = autodiff([](const auto& r, const auto& v) {
    using std::sin;
    std::decay_t<decltype(r)> f = -r.squaredNorm() * r;
    f[0] -= sin(r[0]) * v[1];
    f[1] += sin(r[0]) * v[0];
    return f;
  });
  CHECK(check_jacobian(local<2>(automatic), y).agrees);
}

TEST_CASE("it adds to what is there") {
  const Y y{Vec::LinSpaced(6, 1, 6), Vec::Ones(6)};
  Y::Rate out{Vec::Constant(6, 10.0)};
  auto force = of_r;
  force.add(0.0, MotionView<Vec, UnitMass>{y.r, y.v, UnitMass{}}, out);
  CHECK((out.force - (Vec::Constant(6, 10.0) - y.r)).norm() == 0);
}

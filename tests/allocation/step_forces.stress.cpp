// No heap allocation of ours in `step` after construction: kinds of force and of state. In short: step.test.cpp.
#define EIGEN_RUNTIME_NO_MALLOC  // a second, independent witness: Eigen asserts where it allocates
#include "allocation/step_cases.hpp"

#include <phistep/autodiff.hpp>

TEST_CASE("each particle by itself, by differences or with a Jacobian: nothing") {
  struct Well {
    Eigen::Vector3d operator()(const Eigen::Vector3d& r, const Eigen::Vector3d& v) const {
      return -r - r.squaredNorm() * r - 0.1 * v;
    }
  };
  struct Known : Well {
    [[nodiscard]] static MotionJacobian<Eigen::Matrix3d> jacobian(const Eigen::Vector3d& r, const Eigen::Vector3d&) {
      const Eigen::Matrix3d I = Eigen::Matrix3d::Identity();
      return {-I - r.squaredNorm() * I - 2 * r * r.transpose(), -0.1 * I};
    }
  };
  check_none(motion(30), local<3>(Well{}), trapezoidal);
  check_none(motion(30), local<3>(Well{}), velocity_verlet, mass(Dynamic::LinSpaced(30, 1, 2)));
  check_none(motion(30), local<3>(Known{}) + LinearDrag{0.1} + Gravity{Eigen::Vector3d(0, 0, -1)}, phi(0.7));
  const auto harmonic = [](const Eigen::Vector3d& r) -> Eigen::Vector3d { return -4 * r; };
  check_none(motion(30), affine(local<3>(harmonic)), trapezoidal);
}
TEST_CASE("affine forces, one solve a step: nothing") {
  const Eigen::MatrixXd K = -4 * Eigen::MatrixXd::Identity(30, 30), C = 0.1 * K;
  check_none(motion(30), linear(K), trapezoidal);
  check_none(motion(30), linear(K, C), midpoint, mass(Dynamic::LinSpaced(30, 1, 2)));
  check_none(Dynamic(Dynamic::LinSpaced(30, 1, 2)), linear(K), backward_euler);
}
TEST_CASE("fixed-point iteration, plain and accelerated: nothing") {
  check_none(motion(30), Chain{}, trapezoidal, fixed_point({.depth = 0}));
  check_none(motion(30), Chain{}, trapezoidal, fixed_point({.depth = 5}));
  check_none(motion(30), DampedChain{}, velocity_verlet, fixed_point());
  check_none(motion(3000), DampedChain{}, velocity_verlet);
}
TEST_CASE("views, matrices, arrays of structs: nothing") {
  states::SecondOrder<states::Structs> structs;
  PhiStepper one{structs.state, Chain{}, trapezoidal};
  CHECK(allocations(structs.state, one) == 0);
  states::FirstOrder<states::Strided> strided;
  PhiStepper two{strided.state, Chain{}, forward_euler};
  CHECK(allocations(strided.state, two) == 0);
  states::SecondOrder<states::Columns> columns;
  PhiStepper three{columns.state, Chain{}, velocity_verlet};
  CHECK(allocations(columns.state, three) == 0);
}
TEST_CASE("a reference-returning force: nothing") {
  Dynamic kept(30);
  const auto force = [&kept](const Dynamic& r) -> const Dynamic& {
    kept = -r;
    return kept;
  };
  check_none(motion(30), force, forward_euler);
  check_none(motion(30), force, velocity_verlet);
}
TEST_CASE("automatic differentiation of a fixed state: nothing") {
  const auto force = autodiff([](const auto& y) {
    std::remove_cvref_t<decltype(y)> f = y;
    for (Eigen::Index i = 0; i < y.size(); ++i) f[i] = -y[i] * y[i] * y[i];
    return f;
  });
  check_none(states::Fixed(states::Fixed::LinSpaced(1, 2)), force, trapezoidal);
}
TEST_CASE("springs by Verlet: nothing") {
  check_none(motion(30), spring_network<3>({{0, 1, 5, 0.1}, {1, 2, 5, 0.1}}), velocity_verlet);
}
TEST_CASE("springs row by row: nothing once they are in order") {
  std::vector<Spring> chain;
  for (int i = 0; i < 12'000; ++i) chain.push_back({i, i + 1, 5, 0.1});
  auto y = motion(36'003);
  PhiStepper stepper{y, spring_network<3>(chain), velocity_verlet};
  CHECK(allocations(y, stepper, 1) == 0);
}

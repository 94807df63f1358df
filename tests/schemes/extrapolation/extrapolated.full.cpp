// Extrapolated steps of every column, with masses and as motions; the quick half is extrapolated.test.cpp.
#include "schemes/extrapolation/extrapolated_cases.hpp"

using namespace extrapolated_cases;

TEST_CASE("column k has order k, linearly implicit: a flow and a damped motion, in long double") {
  using T = long double;
  for (int k = 1; k <= 6; ++k) {
    CAPTURE(k);
    const auto exact = linear_flow(10, 200);
    using One = typename Pendulum<T>::One;
    const Motion<One> z{One{T(1)}, One{T(0.5)}};
    const auto motion = [&](int columns, int steps) {
      PhiStepper stepper{z, Pendulum<T>{}, extrapolated(backward_euler, columns)};
      return march(stepper, z, T(0), T(2), steps);
    };
    const auto moved = motion(10, 200);
    CHECK(std::abs(static_cast<double>(moved.r[0] - exact[0])) <= 1e-17);
    check_order([&](int steps) { return distance(motion(k, steps), moved); }, steps_for(k), k);
  }
}

// Jacobians by differences: 1e-8 of h² a step. What is above that shows the order.
TEST_CASE("non-autonomous, with masses: orders 2 to 4 as they are") {
  using Flow = problems::ForcedFlow<>;
  using Moved = problems::ForcedMotion<>;
  for (int k = 2; k <= 4; ++k) {
    CAPTURE(k);
    const auto flow = [&](auto scheme, int steps) {
      const auto y = Flow::exact(0);
      PhiStepper stepper{y, Flow{}, scheme, capacity(Flow::capacity)};
      return distance(march(stepper, y, 0.0, 2.0, steps), Flow::exact(2));
    };
    const auto motion = [&](auto scheme, int steps) {
      const auto y = Moved::exact(0);
      PhiStepper stepper{y, Moved{}, scheme, mass(Moved::mass)};
      return distance(march(stepper, y, 0.0, 2.0, steps), Moved::exact(2));
    };
    const int n = k == 4 ? 40 : 160;
    check_order([&](int steps) { return flow(extrapolated(backward_euler, k), steps); }, n, k);
    check_order([&](int steps) { return motion(extrapolated(backward_euler, k), steps); }, n, k);
    if (k == 4) continue;
    check_order([&](int steps) { return flow(extrapolated(forward_euler, k), steps); }, 40, 2 * k);
    check_order([&](int steps) { return motion(extrapolated(forward_euler, k), steps); }, 40, 2 * k);
  }
}

TEST_CASE("what a step of k columns costs, exactly") {
  check_costs(problems::Hires::start(), problems::Hires{});
  // … and not where Ψ uses time.
  auto z = problems::ForcedFlow<>::exact(0);
  PhiStepper timed{z, [](const Eigen::Vector2d& x, double t) -> Eigen::Vector2d { return -x * t; },
                   extrapolated(forward_euler, 3)};
  REQUIRE(timed.step(z, 0.0, 1e-3));
  CHECK(timed.statistics().force_calls == 1 + 1 + 3 + 5);  // 2, 4, 6
  const problems::Kepler kepler;
  auto r = kepler.start();
  PhiStepper verlet{r, kepler, extrapolated(velocity_verlet, 3)};
  REQUIRE(verlet.step(r, 0.0, 1e-3));
  CHECK(verlet.statistics().force_calls == 1 + 2 + 4 + 6);
  CHECK(verlet.statistics().factorizations == 0);
}

TEST_CASE("rows side by side are the rows one after the other; a motion is its first-order system") {
  // The inverse of W and its LU factors differ by rounding times the condition of M − hJ, some 1e3.
  problems::Hires::State y = problems::Hires::start();
  Vec z = y;
  PhiStepper lanes{y, problems::Hires{}, extrapolated(backward_euler, 6)};
  PhiStepper rows{z, DynamicHires{}, extrapolated(backward_euler, 6)};
  for (int k = 0; k < 20; ++k) {
    problems::step(lanes, y, 0.05 * k, 0.05);
    problems::step(rows, z, 0.05 * k, 0.05);
  }
  CHECK((y - z).lpNorm<Eigen::Infinity>() <= 1e-12);
  Statistics counts = rows.statistics();
  counts.checks = 0;  // the lanes' own factors are not checked
  CHECK(counts == lanes.statistics());
  using One = Eigen::Matrix<double, 1, 1>;
  Motion<One> motion{One{1.0}, One{0.5}};
  Eigen::Vector2d flow{1, 0.5};
  motion = march(PhiStepper{motion, Pendulum<double>{}, extrapolated(backward_euler, 5)}, motion, 0.0, 2.0, 20);
  flow = march(PhiStepper{flow, PendulumFlow<double>{}, extrapolated(backward_euler, 5)}, flow, 0.0, 2.0, 20);
  CHECK(std::abs(motion.r[0] - flow[0]) <= 1e-14);
  CHECK(std::abs(motion.v[0] - flow[1]) <= 1e-14);
}

TEST_CASE("a mass matrix is what multiplies y'") {
  const Eigen::Matrix2d M{{2.0, 0.3}, {0.1, 1.5}};
  const auto run = [&](auto scheme, auto force, auto... masses) {
    Eigen::Vector2d y{1, 0.5};
    return march(PhiStepper{y, force, scheme, masses...}, y, 0.0, 2.0, 10);
  };
  const auto premultiplied = [M](const Eigen::Vector2d& y) -> Eigen::Vector2d { return M * PendulumFlow<double>{}(y); };
  for (int k = 1; k <= 5; k += 2) {
    // The Jacobian by differences: 1e-8 of what a step changes by.
    const auto scheme = extrapolated(backward_euler, k);
    CHECK(distance(run(scheme, premultiplied, capacity(M)), run(scheme, PendulumFlow<double>{})) <= 1e-7);
    const auto gragg = extrapolated(forward_euler, k);
    CHECK(distance(run(gragg, premultiplied, capacity(M)), run(gragg, PendulumFlow<double>{})) <= 1e-14);
  }
}

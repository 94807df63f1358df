// TR-BDF2 for motions, states of several blocks and every scalar; the quick half is tr_bdf2.test.cpp.
#include "schemes/tr_bdf2_cases.hpp"

using namespace tr_bdf2_cases;

TEST_CASE("order 2: first order, motion with damping, both non-autonomous, nonlinear, with a mass") {
  using Flow = problems::ForcedFlow<>;
  check_order(errors(50,
                     [](int steps) {
                       const auto y = Flow::exact(0);
                       PhiStepper stepper{y, Flow{}, tr_bdf2, capacity(Flow::capacity)};
                       return distance(march(stepper, y, 0.0, 2.0, steps), Flow::exact(2));
                     }),
              2);
  using Moved = problems::ForcedMotion<>;
  check_order(errors(50,
                     [](int steps) {
                       const auto y = Moved::exact(0);
                       PhiStepper stepper{y, Moved{}, tr_bdf2, mass(Moved::mass)};
                       return distance(march(stepper, y, 0.0, 2.0, steps), Moved::exact(2));
                     }),
              2);
}

TEST_CASE("order 2: a motion whose force ignores v, against a run of 40 times the steps") {
  using problems::HardeningSpring;
  const auto run = [](int steps) {
    const auto y = HardeningSpring::start();
    return march(PhiStepper{y, HardeningSpring{}, tr_bdf2}, y, 0.0, 2.0, steps);
  };
  const auto reference = run(40 * 800);  // its own error is 1/1600 of the finest run's
  check_order(errors(100, [&](int steps) { return distance(run(steps), reference); }), 2);
}

TEST_CASE("order 2: a motion with a temperature, all blocks by the same row") {
  const auto run = [](int steps) {
    states::Coupled c;
    return states::numbers(march(PhiStepper{c.state, states::WarmPull{}, tr_bdf2}, c.state, 0.0, 1.0, steps));
  };
  const Vec reference = run(40 * 400);
  check_order(errors(50, [&](int steps) { return (run(steps) - reference).norm(); }), 2);
}

TEST_CASE("exact counts: one Jacobian, one factorization a run; the force at the end serves the next step") {
  const auto count = [](auto y, auto force) {
    PhiStepper stepper{y, force, tr_bdf2};
    for (int k = 0; k < n; ++k) problems::step(stepper, y, 0.01 * k, 0.01);
    const Statistics s = stepper.statistics();
    CHECK(s.steps == n);
    CHECK(s.jacobians == 1);
    CHECK(s.factorizations == 1);
    return s;
  };
  const Motion<Vec> motion{Vec::Ones(3), Vec::Zero(3)};
  const auto check = [](const Statistics& s, int known) {
    CHECK(s.force_calls == 1 + s.iterations - known);  // one at the start of the run, else only residuals
    CHECK(s.solves == s.iterations);
    CHECK(s.iterations <= 4 * n + 2);
  };
  check(count(Vec(Vec::Ones(3)), LinearPull{}), n);  // the first resolve starts from y, where Ψ is known
  check(count(motion, LinearPull{}), 0);             // … for a motion from (r + ½γΔt v, v)
  // A force with memory may have changed by the next step: it is asked again.
  // Affine: one solve for each resolve, and a residual to check it after solves 1, 2, 4, 8, 16 and 32.
  const Statistics affine_flow = count(Vec(Vec::Ones(3)), affine(LinearPull{}));
  const Statistics affine_motion = count(motion, affine(LinearPull{}));
  CHECK(affine_flow.solves == 2 * n);
  CHECK(affine_motion.solves == 2 * n);
  CHECK(affine_flow.iterations == 0);
  CHECK(affine_flow.force_calls == 1 + n + 6);
  CHECK(affine_motion.force_calls == 1 + 2 * n + 6);
  const Statistics s = count(motion, Remembering{});
  CHECK(s.force_calls > n + s.iterations);
}

TEST_CASE("the force carried over stays good: ten thousand steps, stiff and not, as with a fresh force") {
  struct Two {
    Eigen::Vector2d operator()(const Eigen::Vector2d& y) const { return {-1e6 * (y[0] - y[1]), -0.1 * y[1]}; }
    Eigen::Matrix2d jacobian(const Eigen::Vector2d&) const { return Eigen::Matrix2d{{-1e6, 1e6}, {0, -0.1}}; }
  };
  Eigen::Vector2d carried{2, 1}, fresh = carried;
  PhiStepper a{carried, Two{}, tr_bdf2}, b{fresh, Two{}, tr_bdf2};
  double worst = 0;
  for (int k = 0; k < 10000; ++k) {
    problems::step(a, carried, 0.0, 0.01);
    b.reset();
    problems::step(b, fresh, 0.0, 0.01);
    worst = std::max(worst, (carried - fresh).cwiseAbs().maxCoeff());
  }
  CHECK(a.statistics().force_calls < b.statistics().force_calls);
  // A random walk of 1e4 roundings of numbers ≤ 1 would end at 1e-14, a drift at 1e-12.
  CHECK(worst <= 1e-13);
}

TEMPLATE_TEST_CASE("every scalar: order 2 above the floor of its rounding", "", float, long double) {
  using T = TestType;
  using Flow = problems::ForcedFlow<T>;
  check_order(errors(8,
                     [](int steps) {
                       const auto y = Flow::exact(0);
                       PhiStepper stepper{y, Flow{}, tr_bdf2, capacity(T(Flow::capacity))};
                       return distance(march(stepper, y, T(0), T(2), steps), Flow::exact(2));
                     }),
              2);
}

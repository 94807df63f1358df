// Rannacher's start beside other schemes, for motions and dynamic states; the quick half is rannacher.test.cpp.
#include <phistep/sparse.hpp>

#include "schemes/rannacher_cases.hpp"

using namespace rannacher_cases;
using Heat = problems::Heat<Eigen::SparseMatrix<double>>;

namespace {

/// The differences' own exact solution: forty modes, the rest has decayed below 1e-300.
Vec exact(const Vec& start) {
  Vec u = Vec::Zero(points);
  for (int j = 1; j <= 40; ++j) {
    const Vec mode = Heat::mode(points, j);
    u += 2.0 / (points + 1) * start.dot(mode) * std::exp(Heat::eigenvalue(points, j) * end) * mode;
  }
  return u;
}
double error(const Vec& start, auto scheme, int steps) {
  PhiStepper stepper{start, Heat(points), scheme};
  const Vec u = march(stepper, start, 0.0, end, steps);
  CHECK(stepper.statistics().factorizations == 1);
  CHECK(stepper.statistics().jacobians == 1);
  return (u - exact(start)).cwiseAbs().maxCoeff();
}

}  // namespace

TEST_CASE("heat with a jump in the data: the figures, and order 2 kept") {
  // 40 steps to t = 0.1. The figures follow from the modes: c_j R_be(z/2)² R_tr(z)^(N−1) against c_j e^{Nz}.
  CHECK(error(step_data(), trapezoidal, 40) == Approx(0.412).epsilon(0.01));
  CHECK(error(step_data(), backward_euler, 40) == Approx(4.09e-3).epsilon(0.01));
  CHECK(error(step_data(), rannacher, 40) == Approx(4.48e-5).epsilon(0.01));
  CHECK(error(step_data(), rannacher(2), 40) == Approx(8.47e-5).epsilon(0.01));
  // Up to 160 steps: beyond, the grid ends before the modes that matter do.
  check_order(errors(20, [](int steps) { return error(step_data(), rannacher, steps); }), 2, 0.1);
}

TEST_CASE("a point source needs four half steps") {
  check_order(errors(20, [](int steps) { return error(point_source(), rannacher(2), steps); }), 2, 0.1);
  // With two, modes beyond |z| = N keep 4/z² of theirs, which sums up to an error of order 1.
  const auto two = errors(20, [](int steps) { return error(point_source(), rannacher, steps); });
  for (std::size_t k = 0; k < 3; ++k) CHECK(std::log2(two[k] / two[k + 1]) < 1.2);
  CHECK(two[3] > 100 * error(point_source(), rannacher(2), 160));
}

TEST_CASE("order 2 on smooth problems: first order and motion") {
  using Flow = problems::ForcedFlow<>;
  check_order(errors(100,
                     [](int n) {
                       const auto y = Flow::exact(0);
                       PhiStepper stepper{y, Flow{}, rannacher, capacity(Flow::capacity)};
                       return problems::distance(march(stepper, y, 0.0, 2.0, n), Flow::exact(2));
                     }),
              2, 0.1);
  using Moved = problems::ForcedMotion<>;
  check_order(errors(100,
                     [](int n) {
                       const auto y = Moved::exact(0);
                       PhiStepper stepper{y, Moved{}, rannacher(2), mass(Moved::mass)};
                       return problems::distance(march(stepper, y, 0.0, 2.0, n), Moved::exact(2));
                     }),
              2, 0.1);
}

TEST_CASE("rannacher(0) is the trapezoidal rule to the bit, and a negative number is refused") {
  states::SecondOrder<Vec> a, b;
  PhiStepper plain{a.state, states::DampedPull{}, trapezoidal};
  PhiStepper zero{b.state, states::DampedPull{}, rannacher(0)};
  for (int k = 0; k < 5; ++k) {
    problems::step(plain, a.state, 0.1 * k, 0.1);
    problems::step(zero, b.state, 0.1 * k, 0.1);
  }
  CHECK(states::same_bits(states::numbers(a.state), states::numbers(b.state)));
  CHECK(plain.statistics() == zero.statistics());
  CHECK_THROWS_AS(rannacher(-1), std::invalid_argument);
}

TEST_CASE("exact counts: the start asks for no force but the resolves' own") {
  int calls = 0;
  Vec y = Vec::Ones(3);
  PhiStepper stepper{y, [&calls](const Vec& x) -> Vec { return ++calls, -4 * x; }, rannacher};
  problems::step(stepper, y, 0.0, 0.1);
  const Statistics first = stepper.statistics();
  CHECK(first.force_calls == calls);
  CHECK(first.force_calls == first.iterations + 3);  // three for the difference Jacobian
  problems::step(stepper, y, 0.1, 0.1);
  const Statistics second = stepper.statistics() - first;
  CHECK(second.force_calls == second.iterations);  // the first of them starts from y, where Ψ is known by then
  CHECK(second.factorizations == 0);
}

// Rannacher's start: what the trapezoidal rule lets ring, two backward Euler half steps damp, with the same matrix.
#include <phistep/phistep.hpp>

#include <cmath>
#include <stdexcept>

#include "accuracy/observed_order.hpp"
#include "contract/states.hpp"
#include "problems/forced.hpp"
#include "problems/heat.hpp"
#include "problems/march.hpp"
#include "support/catch.hpp"
#if PHISTEP_QUICK
#include "support/shared_force.hpp"
#endif
#if PHISTEP_FULL
#include <phistep/sparse.hpp>
#endif

using namespace phistep;
using convergence::check_order;
using convergence::errors;
using problems::march;
using Vec = Eigen::VectorXd;

namespace rannacher_cases {

inline constexpr int points = 799;
inline constexpr double end = 0.1;

inline Vec step_data() {
  Vec u(points);
  for (int i = 0; i < points; ++i) u[i] = std::abs((i + 1.0) / (points + 1) - 0.5) < 0.25 ? 1 : 0;
  return u;
}
inline Vec point_source() {
  Vec u = Vec::Zero(points);
  u[points / 2] = points + 1;
  return u;
}
}  // namespace rannacher_cases

using namespace rannacher_cases;

#if PHISTEP_QUICK

namespace {

using V = Eigen::Matrix<double, 1, 1>;
using Modes = problems::Heat<Eigen::MatrixXd>;

/// The largest error at t = 0.1, mode by mode: each is one number, and no sparse LU has to be compiled.
double error_by_modes(const Vec& start, Rannacher scheme, int steps) {
  Vec off = Vec::Zero(points);
  for (int j = 1; j <= points; ++j) {
    const Vec mode = Modes::mode(points, j);
    const double c = 2.0 / (points + 1) * start.dot(mode), lambda = Modes::eigenvalue(points, j);
    if (std::abs(c) < 1e-15) continue;
    const shared_force::OfState<V> decay = [lambda](const V& y) -> V { return lambda * y; };
    V y(1.0);
    PhiStepper stepper{y, decay, scheme};
    // A mode near z = −2 is gone long before the end, and Newton cannot iterate to rounding among denormal numbers.
    for (int k = 0; k < steps && std::abs(y[0]) > 1e-200; ++k) problems::step(stepper, y, k * end / steps, end / steps);
    off += c * (y[0] - std::exp(lambda * end)) * mode;
  }
  return off.cwiseAbs().maxCoeff();
}

}  // namespace

TEST_CASE("heat with a jump in the data: the figures, and order 2 kept") {
  // 40 steps to t = 0.1. The figures follow from the modes: c_j R_be(z/2)² R_tr(z)^(N−1) against c_j e^{Nz}.
  CHECK(error_by_modes(step_data(), rannacher, 40) == Approx(4.48e-5).epsilon(0.01));
  CHECK(error_by_modes(step_data(), rannacher(2), 40) == Approx(8.47e-5).epsilon(0.01));
  // Up to 160 steps: beyond, the grid ends before the modes that matter do.
  check_order(errors(20, [](int steps) { return error_by_modes(step_data(), rannacher, steps); }), 2, 0.1);
}

TEST_CASE("a point source needs four half steps") {
  check_order(errors(20, [](int steps) { return error_by_modes(point_source(), rannacher(2), steps); }), 2, 0.1);
  // With two, modes beyond |z| = N keep 4/z² of theirs, which sums up to an error of order 1.
  const auto two = errors(20, [](int steps) { return error_by_modes(point_source(), rannacher, steps); });
  for (std::size_t k = 0; k < 3; ++k) CHECK(std::log2(two[k] / two[k + 1]) < 1.2);
  CHECK(two[3] > 100 * error_by_modes(point_source(), rannacher(2), 160));
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
}

TEST_CASE("first means since construction or reset; a failed step does not count") {
  bool poisoned = false;
  const shared_force::OfState<V> decay = [&poisoned](const V& y) -> V {
    return poisoned ? V(std::nan("")) : V(-4 * y);
  };
  const double start = 1 / (1.2 * 1.2), later = 0.8 / 1.2;  // Δt = 0.1: 1/(1+0.2)² at the start, (1−0.2)/(1+0.2) then
  V y(1.0);
  PhiStepper stepper{y, decay, rannacher(2)};
  const auto factor = [&] {
    const double before = y[0];
    problems::step(stepper, y, 0.0, 0.1);
    return y[0] / before;
  };
  const auto fail = [&] {
    poisoned = true;
    CHECK_FALSE(stepper.step(y, 0.0, 0.1));
    poisoned = false;
  };
  fail();
  CHECK(factor() == Approx(start).epsilon(1e-14));
  fail();
  fail();
  CHECK(factor() == Approx(start).epsilon(1e-14));
  CHECK(factor() == Approx(later).epsilon(1e-14));
  static_cast<void>(stepper.force());  // another force is no other start
  CHECK(factor() == Approx(later).epsilon(1e-14));
  stepper.reset();
  CHECK(factor() == Approx(start).epsilon(1e-14));
  const auto checkpoint = stepper.checkpoint();
  CHECK(factor() == Approx(start).epsilon(1e-14));
  stepper.restore(checkpoint);
  CHECK(factor() == Approx(start).epsilon(1e-14));
  CHECK(factor() == Approx(later).epsilon(1e-14));
}

TEST_CASE("rannacher(0) is the trapezoidal rule to the bit, and a negative number is refused") {
  using Flow = problems::ForcedFlow<>;
  auto a = Flow::exact(0), b = a;
  PhiStepper plain{a, Flow{}, trapezoidal, capacity(Flow::capacity)};
  PhiStepper zero{b, Flow{}, rannacher(0), capacity(Flow::capacity)};
  for (int k = 0; k < 5; ++k) {
    problems::step(plain, a, 0.1 * k, 0.1);
    problems::step(zero, b, 0.1 * k, 0.1);
  }
  CHECK(states::same_bits(a, b));
  CHECK(plain.statistics() == zero.statistics());
  CHECK_THROWS_AS(rannacher(-1), std::invalid_argument);
}

TEST_CASE("exact counts: the start asks for no force but the resolves' own") {
  int calls = 0;
  const shared_force::OfState<V> pull = [&calls](const V& x) -> V { return ++calls, -4 * x; };
  V y(1.0);
  PhiStepper stepper{y, pull, rannacher(2)};
  problems::step(stepper, y, 0.0, 0.1);
  const Statistics first = stepper.statistics();
  CHECK(first.force_calls == calls);
  CHECK(first.force_calls == first.iterations + 1);  // one for the difference Jacobian
  problems::step(stepper, y, 0.1, 0.1);
  const Statistics second = stepper.statistics() - first;
  CHECK(second.force_calls == second.iterations);  // the first of them starts from y, where Ψ is known by then
  CHECK(second.factorizations == 0);
}

#elif PHISTEP_FULL
// Rannacher's start beside other schemes, for motions and dynamic states.

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

#endif

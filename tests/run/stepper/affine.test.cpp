// Affine forces: one factorization a run, one solve a step, no iterations; and a promise that is checked.
#include <cmath>
#if PHISTEP_QUICK
#include "run/stepper/affine_cases.hpp"
#include "support/shared_force.hpp"
#endif
#if PHISTEP_FULL
#include <Eigen/SparseCholesky>

#include "run/stepper/affine_rod.hpp"
#endif

using namespace affine_cases;

#if PHISTEP_QUICK

using Three = Eigen::Vector3d;
using Square = Eigen::Matrix3d;
using Moved = Motion<Three>;
using OfState = shared_force::OfState<Three>;

namespace {

Statistics run(auto y, const auto& force, auto scheme) {
  PhiStepper stepper{y, force, scheme};
  for (int k = 0; k < steps; ++k) problems::step(stepper, y, 0.01 * k, 0.01);
  return stepper.statistics();
}
/// Heat on a rod of three points, cold ends.
Square rod() { return Square{{-32, 16, 0}, {16, -32, 16}, {0, 16, -32}}; }

}  // namespace

// Fixed sizes: LU of a dynamic or a sparse matrix costs seconds to compile.
TEST_CASE("an affine run factorizes once and solves once a step") {
  const Three theta(1, 1.5, 2);
  // φ = ½ needs Ψ(y) alone: it is Ψ at the start of the solve, too.
  check_exact(run(theta, linear(Square(-Square::Identity())), trapezoidal), steps + looks);
  const Moved motion{theta, -theta};
  check_exact(run(motion, linear(Square(-4 * Square::Identity())), midpoint), steps + looks);
  const OfState f = [](const Three& r) -> Three { return -4 * r; };
  check_exact(run(motion, affine(f), midpoint), steps + looks + 3);  // by a promise and differences
}

TEST_CASE("an affine step gives what Newton to rounding gives") {
  const Square A = rod();
  Square K = A, C = 0.01 * A;
  K(0, 2) += 40;  // neither symmetric …
  C(2, 1) -= 3;   // … nor the same
  check_as_newton(K, C, Moved{Three(1, 1.4, 2), Three(-1, 0.8, 3)});
}

TEST_CASE("a step of another length makes new factors, whatever the tolerance") {
  Three y(1, 1.5, 2);
  PhiStepper stepper{y, linear(rod()), trapezoidal};
  for (const double dt : {0.1, 0.11, 0.12, 0.1}) problems::step(stepper, y, 0.0, dt);
  CHECK(stepper.statistics().factorizations == 4);
  CHECK(stepper.statistics().jacobians == 1);
}

TEST_CASE("a promise of affinity that is broken is found out, and nothing is lost") {
  Moved y{Three::Ones(), Three::Zero()};
  const Moved start = y;
  SECTION("a nonlinear force") {
    const OfState f = [](const Three& r) -> Three { return -r.array().sin(); };
    PhiStepper stepper{y, affine(f), midpoint};
    const StepReport report = stepper.step(y, 0, 0.01);
    CHECK(report.outcome() == Outcome::not_affine);
    CHECK_THAT(report.message(), Catch::Matchers::Contains("affine"));
  }
  SECTION("a force that stops being what it was is found at the next look") {
    bool on = false;
    const OfState f = [&on](const Three& r) -> Three { return on ? Three(-r - r.cwiseProduct(r)) : Three(-r); };
    check_change_found(y, affine(f), on);
    return;
  }
  SECTION("a singular matrix, 1 = γ²k") {
    PhiStepper stepper{y, linear(Square(4 * Square::Identity())), midpoint};
    CHECK(stepper.step(y, 0, 1).outcome() == Outcome::singular_matrix);
  }
  CHECK((y.r.array() == start.r.array()).all());
  CHECK((y.v.array() == start.v.array()).all());
}

TEST_CASE("a promise that is broken late is found, at less than 1 % of a long run") {
  const auto found_after = [](int changes) {
    int calls = 0, n = 0;
    bool on = false;
    const OfState f = [&](const Three& r) -> Three {
      ++calls;
      return on ? Three(-r - r.cwiseProduct(r)) : Three(-r);
    };
    Moved y{Three::Ones(), Three::Zero()};
    PhiStepper stepper{y, affine(f), midpoint};
    for (; n < changes; ++n) problems::step(stepper, y, 0.1 * n, 0.1);
    if (changes >= 10000) CHECK(calls < 1.01 * n);
    on = true;
    while (stepper.step(y, 0.1 * n, 0.1)) ++n;
    return n - changes;
  };
  for (const int changes : {20, 100, 250}) CHECK(found_after(changes) <= changes / 2);
  for (const int changes : {1000, 10000}) CHECK(found_after(changes) <= 128);
}

TEST_CASE("a step that nearly annihilates the state is no broken promise") {
  // φ = ½ and λΔt ≈ −2: b = y + ½λΔt y and y⁺ are next to nothing, and what is left is the rounding of what they cancel.
  using One = Eigen::Matrix<double, 1, 1>;
  for (const double off : {0.0, 1e-12, 1e-9, 1e-6, -1e-9, -1e-4})
    for (const double start : {0.3, 0.7, 1.1}) {
      One z{start};
      const double lambda = -2 * (1 + off);
      PhiStepper decay{z, affine([lambda](const One& x) -> One { return lambda * x; }), trapezoidal};
      CAPTURE(off, start);
      REQUIRE(decay.step(z, 0, 1));
      CHECK(std::abs(z[0] + off / 2 * start) <= 1e-15 + off * off);
    }
}

#elif PHISTEP_FULL
// Affine forces as dense, sparse and local matrices, and long runs.

namespace {

Statistics run(auto y, const auto& force, auto scheme, const auto&... more) {
  PhiStepper stepper{y, force, scheme, more...};
  const RunReport report = integrate(stepper, y, {0, steps * 0.01}, fixed(0.01));
  CAPTURE(report.message());
  REQUIRE(report);
  REQUIRE(report.statistics.steps == steps);
  return report.statistics;
}

struct Driven {
  static constexpr bool is_affine = true;
  Vec operator()(const Vec& y, double t) const { return std::sin(t) - 3 * y.array(); }
  Mat jacobian(const Vec& y, double) const { return -3 * Mat::Identity(y.size(), y.size()); }
};

}  // namespace

TEST_CASE("an affine run factorizes once and solves once a step") {
  const Vec theta = Vec::LinSpaced(20, 1, 2);
  const Y motion{theta, -theta};
  const Mat dense = rod(20);
  const auto f = [dense](const Vec& x) -> Vec { return dense * x; };
  SECTION("first order, as matrices") {
    // φ = ½ needs Ψ(y) alone: it is Ψ at the start of the solve, too.
    check_exact(run(theta, linear(rod(20)), trapezoidal), steps + looks);
    check_exact(run(theta, linear(dense), trapezoidal), steps + looks);
    check_exact(run(theta, linear(rod(20)), backward_euler), steps + looks);
    check_exact(run(theta, linear(rod(20)), midpoint), steps + looks);
    CHECK(run(theta, linear(rod(20)), trapezoidal).analyses == 1);
  }
  SECTION("first order, by a promise and differences: 20 calls for the Jacobian") {
    check_exact(run(theta, affine(f), trapezoidal), steps + looks + 20);
  }
  SECTION("motion") {
    check_exact(run(motion, linear(Mat(-4 * Mat::Identity(20, 20))), trapezoidal), 2 * steps + looks);
    check_exact(run(motion, linear(Mat(-4 * Mat::Identity(20, 20))), midpoint), steps + looks);
    check_exact(run(motion, linear(rod(20), Eigen::SparseMatrix<double>(0.1 * rod(20))), backward_euler),
                steps + looks);
  }
  SECTION("stiff motion starts from its position: one call more where that is found out") {
    check_exact(run(motion, linear(Mat(1e4 * dense)), backward_euler), steps + looks + 1);
    check_exact(run(motion, linear(Mat(1e4 * dense)), phi_stage(0.6)), steps + looks + 1);
    check_exact(run(motion, linear(Mat(1e5 * dense)), midpoint), steps + looks + 1);
  }
  SECTION("a sum of affine terms is affine") {
    check_exact(run(motion, linear(rod(20)) + LinearDrag{0.1} + Gravity{Eigen::Matrix<double, 1, 1>(-9.81)}, midpoint),
                steps + looks);
  }
  SECTION("a load that changes in time leaves the matrix alone") {
    check_exact(run(theta, Driven{}, trapezoidal), 2 * steps + looks);
  }
  SECTION("a solver of one's own") {
    check_exact(
        run(theta, linear(rod(20)), backward_euler, newton<Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>>>()),
        steps + looks);
  }
  SECTION("fixed sizes") {
    const Eigen::Vector3d small(1, 2, 3);
    check_exact(run(small, linear(Eigen::Matrix3d(-Eigen::Matrix3d::Identity())), trapezoidal), steps + looks);
  }
}

#endif

#pragma once

// What the quick and the full tests of differential-algebraic equations of index 1 share.
#include <phistep/advise.hpp>
#include <phistep/io.hpp>
#include <phistep/phistep.hpp>
#include <phistep/sparse.hpp>

#include <sstream>

#include "problems/dae.hpp"
#include "support/catch.hpp"

namespace index_1_cases {

using namespace phistep;
using Three = Eigen::Vector3d;

/// y = e^{−t}, z = cos t, w = e^{−2t} solve
///
///     y' = −y + (z − cos t) y,   0 = z + y² − w − cos t,   0 = w (3 − z) − y² (3 − cos t).
inline Three psi(const Three& u, double t) {
  const double c = std::cos(t), y = u[0], z = u[1], w = u[2];
  return {-y + (z - c) * y, z + y * y - w - c, w * (3 - z) - y * y * (3 - c)};
}
inline Three exact(double t) { return {std::exp(-t), std::cos(t), std::exp(-2 * t)}; }
inline constexpr auto known = [](const Three& u, double t) -> Three { return psi(u, t); };
struct WithJacobian {
  Three operator()(const Three& u, double t) const { return psi(u, t); }
  Eigen::Matrix3d jacobian(const Three& u, double t) const {
    const double c = std::cos(t), y = u[0], z = u[1], w = u[2];
    return Eigen::Matrix3d{{z - c - 1, y, 0}, {2 * y, 1, -1}, {-2 * y * (3 - c), -w, 3 - z}};
  }
};
inline const Three one_of_three{1, 0, 0};

/// Errors of differential and algebraic components at t = 1, by n steps.
template <class Scheme, class Mass>
std::array<double, 2> errors(Scheme scheme, const Mass& mass, int n) {
  Three y = exact(0);
  PhiStepper stepper{y, WithJacobian{}, scheme, mass};
  REQUIRE(integrate(stepper, y, {0.0, 1.0}, fixed(1.0 / n)));
  const Three off = (y - exact(1)).cwiseAbs();
  return {off[0], std::max(off[1], off[2])};
}
inline void check_order(double coarse, double fine, double order) {
  const double measured = std::log2(coarse / fine);
  CAPTURE(coarse, fine, measured);
  CHECK(measured > order - 0.25);
  CHECK(measured < order + 0.45);
}
/// @param mass  M = diag(1, 0, 0) in one form or several
template <class Scheme, class... Mass>
void check_orders(Scheme scheme, double order, int n, const Mass&... mass) {
  const auto check = [&](const auto& M) {
    const auto coarse = errors(scheme, M, n), fine = errors(scheme, M, 2 * n);
    check_order(coarse[0], fine[0], order);
    check_order(coarse[1], fine[1], order);
  };
  (check(mass), ...);
}
inline const auto diagonal = capacity(one_of_three);
inline const auto dense = capacity(Eigen::Matrix3d(one_of_three.asDiagonal()));
inline const auto sparse =
    capacity(Eigen::SparseMatrix<double>(Eigen::Matrix3d(one_of_three.asDiagonal()).sparseView()));

/// The largest error of a run to the problem's end, relative above atol.
template <class Problem>
double error(Problem, auto force, auto scheme, double tol, double atol) {
  typename Problem::State y = Problem::start();
  PhiStepper stepper{y, force, scheme, capacity(Problem::mass())};
  REQUIRE(integrate(stepper, y, {0.0, Problem::t1}, tolerance{.rtol = tol, .atol = tol * atol}));
  const auto end = Problem::end();
  return ((y - end).cwiseAbs().array() / (end.cwiseAbs().array() + atol)).maxCoeff();
}
void check_tolerances(const auto& force, auto scheme, double tightest) {
  for (double tol = 1e-3; tol >= tightest; tol /= 10) {
    Three y = exact(0);
    PhiStepper stepper{y, force, scheme, capacity(one_of_three)};
    REQUIRE(integrate(stepper, y, {0.0, 2.0}, tolerance{.rtol = tol, .atol = tol}));
    const double off = (y - exact(2)).cwiseAbs().maxCoeff() / tol;
    CAPTURE(tol, off);
    CHECK(off <= 10);
    CHECK(off >= 1e-4);
  }
}
/// Samples and an event of an algebraic component, to the allowed error.
void check_samples(auto scheme, const auto& control, double allowed) {
  Three y = exact(0);
  PhiStepper stepper{y, WithJacobian{}, scheme, capacity(one_of_three)};
  double worst = 0, found = 0;
  const auto look = [&](double t, const Three& u) { worst = std::max(worst, (u - exact(t)).cwiseAbs().maxCoeff()); };
  auto crossing = event([](double, const Three& u) { return u[1] - 0.3; }, [&](double t, const Three&) { found = t; });
  REQUIRE(integrate(stepper, y, {0.0, 2.0}, control, sampled(0.01, look), crossing));
  CHECK(worst <= allowed);
  CHECK(std::abs(found - std::acos(0.3)) <= allowed);
}
/// A run that resumes a checkpoint, against the one that saved it.
void check_restart(auto scheme, const auto& control) {
  Three y = exact(0), z = exact(0);
  PhiStepper one{y, WithJacobian{}, scheme, capacity(one_of_three)},
      other{z, WithJacobian{}, scheme, capacity(one_of_three)};
  Run first{one, y, {0.0, 1.0}, control}, second{other, z, {0.0, 1.0}, control};
  for (int n = 0; n < 4; ++n) REQUIRE(first.advance());
  std::stringstream file;
  save_checkpoint(file, first);
  load_checkpoint(file, second);
  CHECK(first.finish().outcome == Outcome::success);
  CHECK(second.finish().outcome == Outcome::success);
  CHECK(y == z);
  CHECK(one.statistics().force_calls == other.statistics().force_calls);
}

}  // namespace index_1_cases

#include <phistep/base/state/motion.hpp>
#include <phistep/run/control/variable_step.hpp>
#include <phistep/run/errors/error_norm.hpp>

#include <cmath>
#include <limits>

#include "support/catch.hpp"

using namespace phistep;
using Vec = Eigen::VectorXd;

namespace {

template <class Plain>
double first(auto&& slope, const Plain& y, double t, double length, int order, double rtol,
             const AbsoluteTolerance& atol = {}) {
  ErrorNorm<Plain> norm;
  REQUIRE(norm.begin({.rtol = rtol, .atol = atol}, y));
  Plain weight = y;
  norm.weigh(y, weight);
  return first_step(slope, y, weight, t, length, order, std::pow(rtol, 1.0 / order));
}

}  // namespace

TEST_CASE("a decay: the step errs by a tenth of what is allowed") {
  // y' = λy: τ = 1/|λ|, ‖y'‖ = |λ|·‖y‖, and (1) reads ‖y‖ (|λ|h)^{p+1} = 0.1·rtol^{1/p}, with ‖y‖ = 1/rtol. The probe's
  // difference is exact for a linear slope.
  for (const double lambda : {-1.0, -1e6, 3.0, -1e-6})
    for (const int p : {1, 2, 4})
      for (const double rtol : {1e-2, 1e-6}) {
        CAPTURE(lambda, p, rtol);
        const auto slope = [lambda](double, const Vec& y, Vec& out) { return out = lambda * y, true; };
        const double h = first(slope, Vec(Vec::Constant(3, 2.5)), 0, 1e9, p, rtol);
        const double wanted = std::pow(0.1 * std::pow(rtol, 1.0 / p) * rtol, 1.0 / (p + 1)) / std::abs(lambda);
        CHECK(h == Approx(wanted).epsilon(1e-6));
      }
}

TEST_CASE("the unit of time scales the step, and no bit else") {
  for (const int k : {-900, -500, -30, -1, 1, 40, 500, 900}) {
    const double unit = std::ldexp(1.0, k);
    const auto slope = [](double t, const Vec& y, Vec& out) {
      out = (-3 * y.array().cube() + std::cos(2 * t)).matrix();
      return true;
    };
    const auto scaled = [&](double t, const Vec& y, Vec& out) {
      static_cast<void>(slope(t / unit, y, out));
      out /= unit;
      return true;
    };
    const Vec y = Eigen::Vector3d(1, -0.3, 2);
    for (const double length : {10.0, -10.0})
      for (const int p : {1, 2})
        CHECK(first(scaled, y, 0.5 * unit, length * unit, p, 1e-4) == unit * first(slope, y, 0.5, length, p, 1e-4));
    const Vec rest = Vec::Zero(3);
    CHECK(first(scaled, rest, 0, 10 * unit, 2, 1e-4) == unit * first(slope, rest, 0, 10, 2, 1e-4));
    CHECK(first(scaled, rest, 0, 10 * unit, 2, 1e-4, 1e-6) == unit * first(slope, rest, 0, 10, 2, 1e-4, 1e-6));
  }
}

TEST_CASE("where there is nothing to go by: a fraction of the run, never more than it") {
  const auto nothing = [](double, const Vec&, Vec& out) { return out.setZero(), true; };
  const auto constant = [](double, const Vec&, Vec& out) { return out.setConstant(7), true; };
  for (const double atol : {0.0, 1e-6})
    for (const double start : {0.0, 1.0})
      for (const double length : {1e-9, 5.0, -1e12}) {
        CAPTURE(atol, start, length);
        const Vec y = Vec::Constant(2, start);
        for (const double h :
             {first(nothing, y, 0, length, 2, 1e-4, atol), first(constant, y, 0, length, 2, 1e-4, atol)}) {
          CHECK(h > 0);
          CHECK(h <= std::abs(length));
        }
      }
}

TEST_CASE("a motion at rest under a force") {
  using M = Motion<Vec>;
  const auto spring = [](double, const M& y, M& out) { return out.r = y.v, out.v = -100 * y.r, true; };
  const double h = first(spring, M{Vec::Ones(2), Vec::Zero(2)}, 0, 100, 2, 1e-4);
  CHECK(h > 1e-6);
  CHECK(h < 0.1);  // ω = 10: a radian
}

TEST_CASE("a stiff start is seen") {
  // Fast component λ = −1e8 at 1: an error of order one within 1e-8.
  const auto slope = [](double, const Vec& y, Vec& out) { return out = Eigen::Vector2d(-1e8 * y[0], -y[1]), true; };
  CHECK(first(slope, Vec(Vec::Ones(2)), 0, 1, 2, 1e-4) < 1e-8);
  // At rest it doesn't rule.
  CHECK(first(slope, Vec(Eigen::Vector2d(0, 1)), 0, 1, 2, 1e-4) > 1e-4);
}

TEST_CASE("a probe outside of the force's domain comes nearer; a start outside of it is told") {
  int calls = 0;
  const auto root = [&](double, const Vec& y, Vec& out) {
    ++calls;
    out = -(y.array().sqrt()).matrix() * 1e9;  // towards the end of its domain, fast
    return y.minCoeff() >= 0;
  };
  const double h = first(root, Vec(Vec::Constant(1, 1e-3)), 0, 1, 1, 1e-2, 1.0);
  CHECK(h > 0);
  CHECK(h <= 1);
  CHECK(calls <= 41);
  const auto never = [&](double t, const Vec&, Vec& out) { return ++calls, out.setOnes(), t == 0; };
  calls = 0;
  // ‖y‖ = ‖y'‖, so that the first probe goes to 0.01; a sixteenth each time, 40 times; then a hundred times what is left.
  CHECK(first(never, Vec(Vec::Ones(1)), 0, 1, 1, 1e-2) == Approx(std::ldexp(1.0, -160)).epsilon(1e-14).margin(0));
  CHECK(calls == 41);
  CHECK(first([](double, const Vec&, Vec&) { return false; }, Vec(Vec::Ones(1)), 0, 1, 1, 1e-2) == 0);
}

TEST_CASE("two force calls") {
  int calls = 0;
  const auto slope = [&](double, const Vec& y, Vec& out) { return ++calls, out = -y, true; };
  static_cast<void>(first(slope, Vec(Vec::Ones(2)), 0, 1, 2, 1e-4));
  CHECK(calls == 2);
}

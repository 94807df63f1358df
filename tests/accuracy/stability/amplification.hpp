#pragma once

// The atlas of stability: what one step does to y' = λy, found by taking the step, beside what theory says, cell by cell.
//
// A cell agrees where |y⁺ − R(λΔt) y| ≤ u·e·|y|, e the running bound of the scheme's own operations (models.hpp). Where the
// step fails, or does something else, one of the rules in `explain` must say why; what none explains is counted, and none
// may be left.

#include <phistep/phistep.hpp>

#include <cmath>
#include <complex>
#include <cstdint>
#include <cstring>
#include <functional>
#include <limits>
#include <map>
#include <numbers>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "accuracy/stability/rounded.hpp"
#include "problems/dahlquist.hpp"

namespace stability {

using phistep::Outcome;
using Point = std::complex<double>;
using Vector = Eigen::Vector2d;

/// λ as a matrix, whose Jacobian is known; `affine(…)` around it promises what it is.
using Decay = problems::ComplexDahlquist;

/// What became of y = start in one step.
struct Step {
  Outcome outcome = Outcome::success;
  Complex factor;         ///< y⁺/y
  bool unharmed = false;  ///< y has every bit it had
  std::array<double, 2> bits{};
};
inline const Point start{1, 0.5};

/// y → y⁺ in one step of Δt.
using Stepping = std::function<Step(Point lambda, double dt)>;

[[nodiscard]] Step measure(auto& stepper, double dt) {
  Vector y{start.real(), start.imag()};
  const Vector before = y;
  const phistep::StepReport report = stepper.step(y, 0, dt);
  return {report.outcome(),
          Complex{y[0], y[1]} / Complex{start.real(), start.imag()},
          std::memcmp(y.data(), before.data(), sizeof(double) * 2) == 0,
          {y[0], y[1]}};
}
inline void set(auto& force, Point lambda) {
  if constexpr (requires { force.lambda; }) force.lambda = lambda;
  else if constexpr (requires { force.f; }) set(force.f, lambda);
  else std::apply([lambda](auto&... term) { (set(phistep::unwrap(term), lambda), ...); }, force.terms);
}
/// One stepper for all cells, as new for each.
[[nodiscard]] Stepping stepping(auto stepper) {
  return [stepper](Point lambda, double dt) mutable {
    stepper.reset();
    if constexpr (requires { stepper.force(); }) set(stepper.force(), lambda);
    else set(stepper.stepper().force(), lambda);
    return measure(stepper, dt);
  };
}

/// A scheme in the atlas.
struct Subject {
  std::string name;
  Stepping step;
  std::function<Complex(Complex)> R;                        ///< by theory
  std::function<Rounded<Complex>(Complex)> model;           ///< its bound
  std::vector<Complex> poles;                               ///< where M − γJ is singular
  double radius = std::numeric_limits<double>::infinity();  ///< of the |z| for which an iteration must converge
  Real jacobian = 0;                                        ///< relative error of what M − γJ is made of
  std::function<Complex(Complex)> instead;  ///< what it does where M − γJ is singular: two half steps, say
  std::function<Rounded<Complex>(Complex)> model_instead;
};

/// The cells of a subject.
struct Tally {
  std::int64_t cells = 0, within = 0, unexplained = 0, harmed = 0, stable = 0;
  std::map<std::string, std::int64_t> explained;
  double worst = 0;      ///< error / bound
  double roundings = 0;  ///< error / (u max(1, |R|)), where Re z ≤ 0
  std::string first;     ///< what is not explained

  void operator+=(const Tally& other) {
    cells += other.cells, within += other.within, unexplained += other.unexplained, harmed += other.harmed;
    stable += other.stable;
    for (const auto& [reason, count] : other.explained) explained[reason] += count;
    worst = std::max(worst, other.worst);
    roundings = std::max(roundings, other.roundings);
    if (first.empty()) first = other.first;
  }
};

[[nodiscard]] inline bool finite(Complex z) { return std::isfinite(z.real()) && std::isfinite(z.imag()); }

/// Less than a digit of R is determined.
[[nodiscard]] inline bool undetermined(const Complex& R, const Rounded<Complex>& model) {
  return !finite(R) || !(model.e * unit_roundoff <= std::max(Real{1}, std::abs(R)) / 10);
}
/// Why a step may fail, or do something else; empty: there is no reason.
///
/// - overflow: the scheme's own numbers (stages, powers of z) leave the range of double: some outcome non_finite_…;
/// - pole: 1 − γz is zero but for the rounding of γz, or the error of a Jacobian by differences: singular_matrix;
/// - no digit: so near to a pole that the bound is a tenth of R or more: y⁺ must be as large as there;
/// - near a pole: what rounding leaves of the residual moves y⁺ by more than (2u)^⅔ |y⁺|, the plateau that Newton's
///   iteration takes for rounding (step/solve/newton.hpp): it may say so instead of returning less than ten digits;
/// - no contraction: a fixed-point iteration beyond its radius may give up;
/// - halved: as for a pole, and the step was done as two.
[[nodiscard]] inline std::string explain(const Subject& subject, const Complex& z, const Step& step,
                                         const Rounded<Complex>& model) {
  const Real largest = std::numeric_limits<double>::max();
  if (!(model.peak * (1 + model.e * unit_roundoff) < largest / 64) &&
      (step.outcome == Outcome::non_finite_state || step.outcome == Outcome::non_finite_force))
    return "overflow";
  Real nearest = std::numeric_limits<Real>::infinity();  // |1 − γz|/(1 + |γz|)
  for (const Complex& pole : subject.poles)
    for (const Complex& p : {pole, std::conj(pole)})
      nearest = std::min(nearest, std::abs(Complex{1} - z / p) / (1 + std::abs(z / p)));
  if (step.outcome == Outcome::singular_matrix && nearest <= std::max(4 * unit_roundoff, subject.jacobian))
    return "pole";
  if (step.outcome == Outcome::success && nearest <= 1e-4L && undetermined(subject.R(z), model) &&
      std::abs(step.factor) >= std::min(std::abs(subject.R(z)) / 1000, 1e-4L / unit_roundoff))
    return "no digit";
  const bool is_near =
      nearest <= (product_cost<Complex> + 4) * unit_roundoff / std::pow(2 * unit_roundoff, Real{2} / 3);
  if ((step.outcome == Outcome::newton_diverged || step.outcome == Outcome::newton_stalled) && is_near)
    return "near a pole";
  if (step.outcome == Outcome::iteration_diverged || step.outcome == Outcome::iteration_stalled) {
    if (is_near) return "near a pole";
    if (std::abs(z) >= static_cast<Real>(subject.radius)) return "no contraction";
  }
  return {};
}

/// One cell, reached by λ and Δt whose product is exact.
inline void look(const Subject& subject, Point z, Tally& tally, int exponent = 0) {
  const Point lambda{std::ldexp(z.real(), -exponent), std::ldexp(z.imag(), -exponent)};
  const Step step = subject.step(lambda, std::ldexp(1.0, exponent));
  const Complex exact{z.real(), z.imag()};
  const Complex R = subject.R(exact);
  const Rounded<Complex> model = subject.model(exact);
  ++tally.cells;
  const auto unexplained = [&](const std::string& why) {
    ++tally.unexplained;
    if (!tally.first.empty()) return;
    std::ostringstream out;
    out.precision(17);
    out << subject.name << ": " << why << " at z = " << z << " 2^" << exponent << ", outcome "
        << phistep::describe(step.outcome) << ", factor " << step.factor << ", R " << R << ", |1-R/measured| "
        << std::abs(Real{1} - R / step.factor) << ", bound " << model.e << " u, peak " << model.peak;
    tally.first = out.str();
  };
  if (step.outcome != Outcome::success) {
    if (!step.unharmed) return ++tally.harmed, unexplained("the state was changed");
    const std::string reason = explain(subject, exact, step, model);
    if (reason.empty()) return unexplained("refused");
    ++tally.explained[reason];
    return;
  }
  if (!finite(step.factor)) return unexplained("not finite");
  // Below 2^-1000 rounding is no longer relative.
  const Real bound = model.e * unit_roundoff + 0x1p-1000L, error = std::abs(step.factor - R);
  if (!(error <= bound) || !finite(R) || undetermined(R, model)) {
    if (subject.instead) {
      const Real halved = subject.model_instead(exact).e * unit_roundoff;
      Step plain = step;
      plain.outcome = Outcome::singular_matrix;
      if (finite(step.factor) && std::abs(step.factor - subject.instead(exact)) <= halved &&
          !explain(subject, exact, plain, model).empty()) {
        ++tally.explained["halved"];
        return;
      }
    }
    if (const std::string reason = explain(subject, exact, step, model); !reason.empty()) {
      ++tally.explained[reason];
      return;
    }
    return unexplained("off by " + std::to_string(static_cast<double>(error / unit_roundoff)) + " u");
  }
  // The running bound's own number is another way to R.
  if (!(std::abs(model.x - R) <= bound)) return unexplained("two theories");
  // |y⁺| ≤ |y| where theory says so, but for the boundary's rounding.
  const bool inside = std::abs(R) <= 1;
  tally.stable += inside;
  if ((std::abs(step.factor) <= 1) != inside && !(std::abs(std::abs(R) - 1) <= bound))
    return unexplained("the wrong side");
  ++tally.within;
  tally.worst = std::max(tally.worst, static_cast<double>(error / bound));
  if (exact.real() <= 0)
    tally.roundings =
        std::max(tally.roundings, static_cast<double>(error / (unit_roundoff * std::max(Real{1}, std::abs(R)))));
}

/// n × n cells of side `spacing` about 0; spacing is a power of two, so that integers and halves are met.
[[nodiscard]] inline Tally over_grid(const Subject& subject, int n, double spacing) {
  Tally tally;
  for (int i = 0; i < n; ++i)
    for (int k = 0; k < n; ++k) look(subject, {(i - n / 2) * spacing, (k - n / 2) * spacing}, tally);
  return tally;
}
/// |z| from 1e-12 to 1e12 along rays from 0, as λ for Δt = 1 and as Δt for |λ| about 1: the bits must be the same.
[[nodiscard]] inline Tally over_decades(const Subject& subject, int per_decade, std::int64_t& different) {
  Tally tally;
  for (int k = -12 * per_decade; k <= 12 * per_decade; ++k)
    for (const double degrees : {0., 30., 60., 85., 90., 95., 110., 135., 160., 180., 225., 270., 315.}) {
      const double size = std::pow(10.0, static_cast<double>(k) / per_decade);
      const double angle = degrees * std::numbers::pi / 180;
      const double real = degrees == 90 || degrees == 270 ? 0 : size * std::cos(angle);
      const double imaginary = degrees == 0 || degrees == 180 ? 0 : size * std::sin(angle);
      const int exponent = std::ilogb(size);
      look(subject, {real, imaginary}, tally);
      look(subject, {real, imaginary}, tally, exponent);
      const Step by_lambda = subject.step({real, imaginary}, 1);
      const Step by_dt =
          subject.step({std::ldexp(real, -exponent), std::ldexp(imaginary, -exponent)}, std::ldexp(1.0, exponent));
      different += by_lambda.outcome != by_dt.outcome || by_lambda.bits != by_dt.bits;
    }
  return tally;
}
/// From a half to 2^-56 of each pole, around it and on it.
[[nodiscard]] inline Tally around_poles(const Subject& subject) {
  Tally tally;
  for (const Complex& pole : subject.poles) {
    const Point p{static_cast<double>(pole.real()), static_cast<double>(pole.imag())};
    look(subject, p, tally);
    for (int k = 1; k <= 56; ++k)
      for (int direction = 0; direction < 8; ++direction) {
        const double angle = direction * std::numbers::pi / 4;
        look(subject, p * (1.0 + std::ldexp(1.0, -k) * Point{std::cos(angle), std::sin(angle)}), tally);
      }
  }
  return tally;
}

// ---- what is read off the map ----------------------------------------------------------------------------------------

/// Whether the step taken lets y grow by more than its rounding; a failed step does.
[[nodiscard]] inline bool grows(const Subject& subject, Point z) {
  const Step step = subject.step(z, 1);
  if (step.outcome != Outcome::success) return true;
  const Real bound = subject.model(Complex{z.real(), z.imag()}).e * unit_roundoff;
  return !(std::abs(step.factor) <= 1 + bound);
}
[[nodiscard]] inline Point on_ray(double size, double degrees_from_left) {
  if (degrees_from_left == 90) return {0, size};
  const double angle = degrees_from_left * std::numbers::pi / 180;
  return {-size * std::cos(angle), size * std::sin(angle)};
}
/// A(α)-stability: the widest sector about the negative real axis without growth, in degrees.
[[nodiscard]] inline double sector(const Subject& subject) {
  double alpha = 90;
  for (int k = -60; k <= 180; ++k) {
    const double size = std::pow(10.0, k / 20.0);
    for (double degrees = 0; degrees < alpha; degrees += 2)
      if (grows(subject, on_ray(size, degrees))) {
        alpha = degrees;
        break;
      }
    if (alpha == 0) return 0;
    if (!grows(subject, on_ray(size, alpha))) continue;
    double still = std::max(0.0, alpha - 2), beyond = alpha;
    for (int i = 0; i < 40; ++i) {
      const double middle = (still + beyond) / 2;
      (grows(subject, on_ray(size, middle)) ? beyond : still) = middle;
    }
    alpha = still;
  }
  return alpha;
}
/// How far along a ray from 0 nothing grows; infinite where that is all the way to 1e12.
[[nodiscard]] inline double reach(const Subject& subject, double degrees_from_left) {
  double still = 0;
  for (int k = -80; k <= 480; ++k) {
    const double size = std::pow(10.0, k / 40.0);
    if (!grows(subject, on_ray(size, degrees_from_left))) {
      still = size;
      continue;
    }
    if (still == 0) return 0;
    double beyond = size;
    for (int i = 0; i < 60; ++i) {
      const double middle = (still + beyond) / 2;
      (grows(subject, on_ray(middle, degrees_from_left)) ? beyond : still) = middle;
    }
    return still;
  }
  return std::numeric_limits<double>::infinity();
}
/// |R| at the far ends: λΔt = −1e12 and 1e12 i.
[[nodiscard]] inline double at_infinity(const Subject& subject) {
  double largest = 0;
  for (const Point z : {Point{-1e12, 0}, Point{0, 1e12}}) {
    const Step step = subject.step(z, 1);
    if (step.outcome != Outcome::success) return std::numeric_limits<double>::infinity();
    largest = std::max(largest, static_cast<double>(std::abs(step.factor)));
  }
  return largest;
}
/// p, with |R − e^z| ∝ |z|^{p+1}: between the two smallest |z| = 2^-k that tell it from rounding.
[[nodiscard]] inline double order_seen(const Subject& subject) {
  double order = 0;
  Real before = 0;
  for (int k = -2; k <= 40; ++k) {
    const Point z = std::ldexp(1.0, -k) * Point{-0.6, 0.8};
    const Complex exact{z.real(), z.imag()};
    const Step step = subject.step(z, 1);
    const Real error = std::abs(step.factor - std::exp(exact));
    // A hundredth of it may be rounding.
    if (step.outcome != Outcome::success || error < 100 * unit_roundoff * subject.model(exact).e) {
      if (before > 0 && order > 0) break;
      before = 0;
      continue;
    }
    if (before > 0) order = static_cast<double>(std::log2(before / error)) - 1;
    before = error;
  }
  return order;
}

}  // namespace stability

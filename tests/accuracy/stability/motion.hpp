#pragma once

// The atlas for motion: what one step does to r'' = −kr − cv, found by taking two of them, beside what theory says.
//
// In units of Δt and with ω = √k, a = ωΔt, ζ = c/2ω, the map of (r, v/ω) is a 2×2 matrix; its entries are compared one by
// one, |P_ij − R_ij| ≤ u e_ij, e_ij the running bounds of the scheme's own operations.

#include <phistep/phistep.hpp>

#include <array>
#include <cmath>
#include <complex>
#include <cstring>
#include <functional>
#include <iostream>
#include <limits>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include "accuracy/stability/models.hpp"
#include "accuracy/stability/rounded.hpp"
#include "accuracy/stability/theory.hpp"

namespace stability::motion {

using phistep::Outcome;
using Vector = Eigen::Matrix<double, 1, 1>;
using State = phistep::Motion<Vector>;

/// Ψ = −kr − cv, its Jacobian known.
template <bool damped>
struct Spring : phistep::ForceTerm {
  static constexpr bool uses_velocity = damped, uses_time = false;
  double k = 1, c = 0;
  void add(double, const auto& y, auto& out) const {
    out.force -= k * y.r;
    if constexpr (damped) out.force -= c * y.v;
  }
  void add_jacobian(double, const auto&, auto& sink) const {
    sink.position(0, 0, -k);
    if constexpr (damped) sink.velocity(0, 0, -c);
  }
};

/// Of (r, v Δt), row by row.
template <class T>
using Square = std::array<std::array<T, 2>, 2>;
using Matrix = Square<Real>;

struct Step {
  Outcome outcome = Outcome::success;
  Matrix P{};  ///< of (r, vΔt)
  bool unharmed = true;
  std::array<double, 4> bits{};
};
/// k Δt² and c Δt are given, and log₂ Δt.
using Stepping = std::function<Step(double k, double c, int exponent)>;

[[nodiscard]] Stepping stepping(auto stepper) {
  return [stepper](double k, double c, int exponent) mutable {
    const double dt = std::ldexp(1.0, exponent);
    auto& force = stepper.force();
    auto& spring = [&]() -> auto& {
      if constexpr (requires { force.k; }) return force;
      else return force.f;
    }
    ();
    spring.k = std::ldexp(k, -2 * exponent);
    spring.c = std::ldexp(c, -exponent);
    Step all;
    // r of one, and v of about one oscillation: each column in its own units.
    const double size = std::exp2(std::round(std::log2(std::sqrt(k))));
    for (const std::size_t column : {std::size_t{0}, std::size_t{1}}) {
      stepper.reset();
      State y{Vector{column == 0 ? 1 : 0}, Vector{column == 0 ? 0 : size / dt}};
      const State before = y;
      const phistep::StepReport report = stepper.step(y, 0, dt);
      if (!report) {
        all.outcome = report.outcome();
        all.unharmed = all.unharmed && std::memcmp(y.r.data(), before.r.data(), sizeof(double)) == 0 &&
                       std::memcmp(y.v.data(), before.v.data(), sizeof(double)) == 0;
        return all;
      }
      const Real by = column == 0 ? 1 : static_cast<Real>(size);
      all.P[0][column] = static_cast<Real>(y.r[0]) / by;
      all.P[1][column] = static_cast<Real>(y.v[0]) * static_cast<Real>(dt) / by;
      all.bits[column] = y.r[0];
      all.bits[2 + column] = y.v[0] * dt;
    }
    return all;
  };
}

// ---- bounds ----------------------------------------------------------------------------------------------------------

namespace bounds {

using Number = Rounded<Real>;
using stability::models::Solve;

struct Motion {
  Number r, v;
};
struct Law {
  Real k, c;
  [[nodiscard]] Number operator()(const Number& r, const Number& v) const {
    return c == 0 ? Number{-k} * r : Number{-k} * r + Number{-c} * v;
  }
};

struct Resolved {
  Motion Y;
  Number w;
};
/// Y.v = b.v + f Ψ(Y),  Y.r = b.r + d Y.v. One correction starts from v where springs are soft, from r where they are
/// stiff; iterations end where f Ψ − w is rounding, and r is what the stiff rule makes of it (step/solve/increment.hpp).
[[nodiscard]] inline Resolved resolve(const Law& law, const Motion& b, const Motion& guess, Real f, Real d, Solve how) {
  const Real k = law.k, c = law.c, W = 1 + f * c + f * d * k;
  if (how != Solve::iterated && (k * d != 0 || c != 0)) {
    const bool at_position = how == Solve::once && f * d * k > 256 * (W - f * d * k);  // as is_stiff() of resolvent.hpp
    Motion start{Number{guess.r.x}, Number{guess.v.x}};
    if (at_position) start.v = scaled(1 / d, start.r - b.r);
    else start.r = b.r + scaled(d, start.v);
    const Number w0 = start.v - b.v, F = scaled(f, law(start.r, start.v)) - w0;
    const Number matrix{W, 4 * W, W}, delta = solved(matrix, F);
    Motion Y{start.r, start.v + delta};
    Y.r = at_position ? start.r + scaled(d, delta) : b.r + scaled(d, Y.v);
    return {Y, w0 + delta};
  }
  const Real v = (b.v.x - f * k * b.r.x) / W, r = ((1 + f * c) * b.r.x + d * b.v.x) / W, w = v - b.v.x;
  const Real terms = 5 * f * k * std::abs(r) + 5 * f * c * std::abs(v) + 3 * std::abs(w);
  const Real e_w = (f * k * b.r.e + b.v.e * (f * c + f * d * k) + terms) / W + 2 * std::abs(w);
  const Real e_v = (f * k * b.r.e + b.v.e + terms) / W + 3 * std::abs(v);
  // Where r is far smaller than what it is made of, it is corrected in place, v = (r − b)/d; there are two corrections at
  // least, each of which leaves 6u of itself: 4u of the matrix, 2u of the quotient.
  const bool in_place = std::abs(r) < std::abs(b.r.x) / 2;
  const Real e_r = ((1 + f * c) * b.r.e + d * b.v.e + d * terms) / W +
                   (in_place ? 2 * std::abs(r) + d * 2 * std::abs(w) / W + 36 * unit_roundoff * d * std::abs(v)
                             : std::abs(b.r.x) + 5 * d * std::abs(v));
  const Real peak = std::max({b.r.peak, b.v.peak, f * k * std::abs(r), f * c * std::abs(v)});
  return {{{r, e_r, peak}, {v, e_v, peak}}, {w, e_w, peak}};
}
[[nodiscard]] inline Motion pair(const Law& law, const Motion& y, Real f, Real d, Solve how) {
  const Number psi = law(y.r, y.v);
  const Motion b{d == 1 ? y.r : y.r + scaled(1 - d, y.v), f == 1 ? y.v : y.v + scaled(1 - f, psi)};
  if (f == 0) return {b.r + scaled(d, b.v), b.v};
  if (d == 0 && law.c == 0) return {b.r, b.v + scaled(f, law(b.r, b.v))};
  return resolve(law, b, y, f, d, how).Y;
}
[[nodiscard]] inline Motion stage(const Law& law, const Motion& y, Real phi, Solve how) {
  if (phi == 0) return pair(law, y, 0, 0, how);
  const Resolved at = resolve(law, y, y, phi, phi, how);
  return {at.Y.r + scaled(1 - phi, at.Y.v), at.Y.v + scaled((1 - phi) / phi, at.w)};
}
[[nodiscard]] inline Motion verlet(const Law& law, const Motion& y, Real dt, Solve how) {
  const Number half = y.v + scaled(dt / 2, law(y.r, y.v)), r = y.r + scaled(dt, half);
  if (law.c == 0) return {r, half + scaled(dt / 2, law(r, half))};
  return resolve(law, {r, half}, y, dt / 2, 0, how).Y;
}

}  // namespace bounds

// ---- theory ----------------------------------------------------------------------------------------------------------

namespace maps {

[[nodiscard]] inline Matrix product(const Matrix& a, const Matrix& b) {
  Matrix c{};
  for (std::size_t i = 0; i < 2; ++i)
    for (std::size_t j = 0; j < 2; ++j) c[i][j] = a[i][0] * b[0][j] + a[i][1] * b[1][j];
  return c;
}

/// R(A) for A = [[0, 1], [−k, −c]]: αI + βA through its eigenvalues, of which ζ = 1 would have but one.
[[nodiscard]] inline Matrix of(const std::function<Complex(Complex)>& R, Real k, Real c) {
  const Real d = k - c * c / 4;
  Real alpha = 0, beta = 0;
  if (d > 0) {
    const Complex z{-c / 2, std::sqrt(d)}, at = R(z);
    beta = at.imag() / z.imag();
    alpha = at.real() - beta * z.real();
  } else {
    const Real fast = -c / 2 - std::sqrt(-d), slow = k / fast;
    const Real at_fast = R({fast, 0}).real(), at_slow = R({slow, 0}).real();
    beta = (at_fast - at_slow) / (fast - slow);
    alpha = (fast * at_slow - slow * at_fast) / (fast - slow);
  }
  return {{{alpha, beta}, {-beta * k, alpha - beta * c}}};
}
/// The pair: (I + …) r⁺ = r + v((1−d)) + d v⁺, v⁺ = v + (1−f)Ψ + fΨ⁺, by Cramer's rule.
[[nodiscard]] inline Matrix pair(Real k, Real c, Real f, Real d) {
  const Real W = 1 + f * c + f * d * k;
  // v⁺ = [(1 − (1−f)c − f(1−d)k) v − k r]/W
  const Real vv = (1 - (1 - f) * c - f * (1 - d) * k) / W, vr = -k / W;
  // r⁺ = r + (1−d) v + d v⁺: 1 + d vr, and (1 − d) + d vv, without cancelling
  const Real rr = (1 + f * c - d * (1 - f) * k) / W, rv = (1 + (f - d) * c) / W;
  return {{{rr, rv}, {vr, vv}}};
}
/// The pair over a time h of its own.
[[nodiscard]] inline Matrix pair_over(Real h, Real k, Real c, Real f, Real d) {
  Matrix P = pair(k * h * h, c * h, f, d);
  P[0][1] *= h;
  P[1][0] /= h;
  return P;
}
[[nodiscard]] inline Matrix verlet(Real k, Real c, Real h = 1) {
  return product(pair_over(h / 2, k, c, 1, 0), pair_over(h / 2, k, c, 0, 1));
}

}  // namespace maps

// ---- the cells -------------------------------------------------------------------------------------------------------

struct Subject {
  std::string name;
  Stepping step;
  std::function<Matrix(Real k, Real c)> R;  ///< of (r, vΔt)
  std::function<bounds::Motion(const bounds::Law&, const bounds::Motion&)> model;
  Real theory = 0x1p-60L;   ///< what R is good for, in units of max(1, |R|): extended precision has 2^-64
  bool damped = true;       ///< takes forces with c ≠ 0
  bool symplectic = false;  ///< det P = 1 where c = 0
};

struct Tally {
  std::int64_t cells = 0, within = 0, unexplained = 0, harmed = 0, stable = 0;
  std::map<std::string, std::int64_t> explained;
  double worst = 0;      ///< error / bound
  double roundings = 0;  ///< error / (u max(1, largest entry)), where ζ ≤ 2
  double area = 0;       ///< |det − 1| of what keeps areas
  std::string first;
  void operator+=(const Tally& other) {
    cells += other.cells, within += other.within, unexplained += other.unexplained, harmed += other.harmed;
    stable += other.stable;
    for (const auto& [reason, count] : other.explained) explained[reason] += count;
    worst = std::max(worst, other.worst), roundings = std::max(roundings, other.roundings);
    area = std::max(area, other.area);
    if (first.empty()) first = other.first;
  }
};

/// Spectral radius.
[[nodiscard]] inline Real spectral_radius(const Matrix& P) {
  const Real half = (P[0][0] + P[1][1]) / 2, det = P[0][0] * P[1][1] - P[0][1] * P[1][0];
  const Real d = half * half - det;
  return d <= 0 ? std::sqrt(std::max(det, Real{0})) : std::abs(half) + std::sqrt(d);
}

/// Bounds of the entries of P, of (r, v/ω), in u.
struct Bound {
  Matrix value{}, error{};
  Real peak = 0;
};
[[nodiscard]] inline Bound bound_of(const Subject& subject, Real k, Real c) {
  Bound out;
  const bounds::Law law{k, c};
  for (const std::size_t column : {std::size_t{0}, std::size_t{1}}) {
    const bounds::Motion end =
        subject.model(law, {bounds::Number{column == 0 ? Real{1} : 0}, bounds::Number{column == 0 ? 0 : Real{1}}});
    const Real a = std::sqrt(k), by = column == 0 ? 1 : a;
    out.value[0][column] = end.r.x * by;
    out.value[1][column] = end.v.x * by / a;
    out.error[0][column] = end.r.e * by;
    out.error[1][column] = end.v.e * by / a;
    out.peak = std::max({out.peak, end.r.peak * by, end.v.peak * by, k, c});
  }
  return out;
}
[[nodiscard]] inline Matrix in_units_of_omega(Matrix P, Real k) {
  const Real a = std::sqrt(k);
  P[0][1] *= a;
  P[1][0] /= a;
  return P;
}

inline void look(const Subject& subject, double k, double c, Tally& tally, int exponent = 0) {
  const Step step = subject.step(k, c, exponent);
  const Bound bound = bound_of(subject, k, c);
  const Matrix R = in_units_of_omega(subject.R(k, c), k);
  ++tally.cells;
  const auto unexplained = [&](const std::string& why) {
    ++tally.unexplained;
    if (!tally.first.empty()) return;
    std::ostringstream out;
    out.precision(17);
    out << subject.name << ": " << why << " at a = " << std::sqrt(k) << ", zeta = " << c / 2 / std::sqrt(k)
        << ", dt = 2^" << exponent << ", outcome " << phistep::describe(step.outcome) << ", peak " << bound.peak;
    const Matrix P = in_units_of_omega(step.P, k);
    for (std::size_t i = 0; i < 2; ++i)
      for (std::size_t j = 0; j < 2; ++j)
        out << "; " << P[i][j] << " for " << R[i][j] << " model " << bound.value[i][j] << " off by "
            << (P[i][j] - R[i][j]) / unit_roundoff << " u, bound " << bound.error[i][j];
    tally.first = out.str();
  };
  if (step.outcome != Outcome::success) {
    if (!step.unharmed) return ++tally.harmed, unexplained("the state was changed");
    // Stages beyond the range of double.
    const Real largest = std::numeric_limits<double>::max();
    if (!(bound.peak < largest / 1024) &&
        (step.outcome == Outcome::non_finite_state || step.outcome == Outcome::non_finite_force)) {
      ++tally.explained["overflow"];
      return;
    }
    return unexplained("refused");
  }
  const Matrix P = in_units_of_omega(step.P, k);
  bool vague = false;
  Real largest = 1, worst = 0, off = 0;
  for (std::size_t i = 0; i < 2; ++i)
    for (std::size_t j = 0; j < 2; ++j) largest = std::max(largest, std::abs(R[i][j]));
  for (std::size_t i = 0; i < 2; ++i)
    for (std::size_t j = 0; j < 2; ++j) {
      const Real limit = bound.error[i][j] * unit_roundoff + subject.theory * largest,
                 error = std::abs(P[i][j] - R[i][j]);
      if (!(error <= limit)) return unexplained("off");
      // Where ωΔt is about 1/u, stages of size vΔt leave more rounding than there is motion; the step has to be right to a
      // tenth all the same.
      if (!(limit <= largest / 10)) {
        if (!(error <= largest / 10)) return unexplained("no digit");
        vague = true;
      }
      if (!(std::abs(bound.value[i][j] - R[i][j]) <= limit)) return unexplained("two theories");
      worst = std::max(worst, error / limit);
      off = std::max(off, error);
    }
  if (vague) {
    ++tally.explained["the bound leaves no digit, the step does"];
    tally.roundings = std::max(tally.roundings, static_cast<double>(off / (unit_roundoff * largest)));
    return;
  }
  // Both eigenvalues within the unit circle: det ≤ 1 and |trace| ≤ 1 + det, but for the rounding of either.
  const auto conditions = [](const Matrix& m) {
    const Real det = m[0][0] * m[1][1] - m[0][1] * m[1][0];
    return std::array<Real, 2>{1 - det, 1 + det - std::abs(m[0][0] + m[1][1])};
  };
  const auto& e = bound.error;
  const Real e_det = (e[0][0] * std::abs(R[1][1]) + e[1][1] * std::abs(R[0][0]) + e[0][1] * std::abs(R[1][0]) +
                      e[1][0] * std::abs(R[0][1]) + 1) *
                     unit_roundoff * 2;
  const Real slack[] = {e_det, e_det + (e[0][0] + e[1][1]) * unit_roundoff};
  const auto mine = conditions(P), theirs = conditions(R);
  bool stable = true;
  for (const std::size_t i : {std::size_t{0}, std::size_t{1}}) {
    stable = stable && theirs[i] >= -slack[i];
    if ((mine[i] >= 0) != (theirs[i] >= 0) && !(std::abs(theirs[i]) <= slack[i])) return unexplained("the wrong side");
  }
  tally.stable += stable;
  if (subject.symplectic && c == 0) {
    if (!(std::abs(mine[0]) <= slack[0])) return unexplained("area");
    if (largest <= 10) tally.area = std::max(tally.area, static_cast<double>(std::abs(mine[0])));
  }
  ++tally.within;
  tally.worst = std::max(tally.worst, static_cast<double>(worst));
  if (c * c <= 16 * k)
    tally.roundings = std::max(tally.roundings, static_cast<double>(off / (unit_roundoff * largest)));
}

/// n × n cells: a = ωΔt to `a_most`, ζ to 2, from half a cell on; where the scheme takes no damping, n² values of a.
[[nodiscard]] inline Tally over_grid(const Subject& subject, int n, double a_most) {
  Tally tally;
  const int columns = subject.damped ? n : 1, rows = subject.damped ? n : n * n;
  for (int i = 0; i < rows; ++i)
    for (int j = 0; j < columns; ++j) {
      const double a = (i + 0.5) / rows * a_most, zeta = subject.damped ? (j + 0.5) / n * 2 : 0;
      look(subject, a * a, 2 * zeta * a, tally);
    }
  return tally;
}
/// a from 1e-12 to 1e12, as ω for Δt = 1 and as Δt for ω about 1: the bits must be the same.
[[nodiscard]] inline Tally over_decades(const Subject& subject, int per_decade, std::int64_t& different) {
  Tally tally;
  for (int i = -12 * per_decade; i <= 12 * per_decade; ++i)
    for (const double zeta : {0.0, 1e-6, 0.01, 0.1, 0.5, 0.9, 1.5, 10.0, 1e3}) {
      if (zeta > 0 && !subject.damped) break;
      const double a = std::pow(10.0, static_cast<double>(i) / per_decade), k = a * a, c = 2 * zeta * a;
      const int exponent = std::ilogb(a);
      look(subject, k, c, tally);
      look(subject, k, c, tally, exponent);
      const Step by_omega = subject.step(k, c, 0), by_dt = subject.step(k, c, exponent);
      // Where one of them overflows, the other may not: v is in another unit.
      const bool both = by_omega.outcome == Outcome::success && by_dt.outcome == Outcome::success;
      if (both && by_omega.bits != by_dt.bits && ++different == 1) {
        std::ostringstream out;
        out.precision(17);
        out << subject.name << ": bits differ at a = " << a << ", zeta = " << zeta;
        for (std::size_t n = 0; n < 4; ++n) out << "; " << by_omega.bits[n] << " " << by_dt.bits[n];
        std::cout << out.str() << std::endl;
      }
    }
  return tally;
}

/// The largest a up to which an undamped oscillation doesn't grow; infinite where that is all the way to 1e12.
[[nodiscard]] inline double limit(const Subject& subject, double zeta = 0) {
  const auto grows = [&](double a) {
    const Step step = subject.step(a * a, 2 * zeta * a, 0);
    if (step.outcome != Outcome::success) return true;
    const Matrix P = in_units_of_omega(step.P, static_cast<Real>(a * a));
    const Real det = P[0][0] * P[1][1] - P[0][1] * P[1][0];
    if (det <= 1 && std::abs(P[0][0] + P[1][1]) <= 1 + det) return false;
    const Bound bound = bound_of(subject, a * a, 2 * zeta * a);
    Real slack = 4;
    for (std::size_t i = 0; i < 2; ++i)
      for (std::size_t j = 0; j < 2; ++j) slack += 4 * bound.error[i][j] * std::max(Real{1}, std::abs(P[i][j]));
    slack *= unit_roundoff;
    return det > 1 + slack || std::abs(P[0][0] + P[1][1]) > 1 + det + slack;
  };
  double still = 0;
  // Compositions have narrow windows of growth, about π say; from 100 on, nothing explicit is left.
  for (double a = 0.01; a < 1e12; a *= a < 1 || a > 100 ? 1.1 : a < 12 ? 1.0001 : 1.002) {
    if (!grows(a)) {
      still = a;
      continue;
    }
    if (still == 0) return 0;
    double beyond = a;
    for (int n = 0; n < 60; ++n) {
      const double middle = (still + beyond) / 2;
      (grows(middle) ? beyond : still) = middle;
    }
    return still;
  }
  return std::numeric_limits<double>::infinity();
}

}  // namespace stability::motion

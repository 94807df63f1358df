#pragma once

// Properties of steps of vectors: random forces, masses, sizes, lengths of step, φ. Sums of terms: flows.hpp. With
// PHISTEP_ENDPOINT_FLOWS of one kind of stepper.

#include <phistep/phistep.hpp>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <string>
#include <utility>

#include "contract/property.hpp"
#include "contract/states.hpp"

namespace flows {

using namespace phistep;
using property::Source;
using Vec = Eigen::VectorXd;
using Mat = Eigen::MatrixXd;
using Moving = Motion<Vec>;

constexpr double u = std::numeric_limits<double>::epsilon() / 2;

/// One type for all forces, so that each scheme is compiled once.
using Law = std::function<Vec(const Vec& r, const Vec& v, double t)>;
struct Force {
  Law law;
  Vec operator()(const Vec& r, const Vec& v, double t) const { return law(r, v, t); }
};
struct Resting {  // … that ignores v and t
  Law law;
  Vec operator()(const Vec& r) const { return law(r, r, 0); }
};

enum class Kind { endpoint, pair, stage, verlet, srkn, composed };

/// A scheme with its φ.
struct Scheme {
  Kind kind = Kind::endpoint;
  double force = 0, drift = 0;
  [[nodiscard]] Scheme adjoint() const { return {kind, 1 - force, 1 - drift}; }
};

/// Steps a motion; false where a step fails.
inline bool march(const Scheme& scheme, const Law& law, const Vec& masses, Moving& y, double t, double dt,
                  int steps = 1) {
  const auto go = [&](auto stepper) {
    for (int n = 0; n < steps; ++n)
      if (const StepReport report = stepper.step(y, t + n * dt, dt); !report) return false;
    return true;
  };
  const auto m = mass(masses);
  switch (scheme.kind) {
    case Kind::endpoint:
    case Kind::pair:
      return go(PhiStepper{y, Force{law}, phi(scheme.force, scheme.drift), m});
#ifndef PHISTEP_ENDPOINT_FLOWS
    case Kind::stage:
      return go(PhiStepper{y, Force{law}, phi_stage(scheme.force), m});
    case Kind::verlet:
      return go(PhiStepper{y, Force{law}, velocity_verlet, m});
    case Kind::srkn:
      return go(PhiStepper{y, Resting{law}, srkn6b, m});
    case Kind::composed:
      return go(PhiStepper{y, Resting{law}, composed(velocity_verlet), m});
#else
    default:
      break;
#endif
  }
  return false;
}

inline double draw_phi(Source& source, const char* name) {
  const double given[] = {0, 1, 0.5};
  const int which = source.integer("which phi", 0, 3);
  return which < 3 ? given[which] : source.real(name, 0, 1);
}
inline Scheme draw_scheme(Source& source) {
  Scheme scheme;
#ifndef PHISTEP_ENDPOINT_FLOWS
  scheme.kind = static_cast<Kind>(source.one_of("scheme", {"endpoint", "pair", "stage", "Verlet"}));
#else  // each kind is a stepper that is compiled anew
  scheme.kind = static_cast<Kind>(source.one_of("scheme", {"endpoint", "pair"}));
#endif
  if (scheme.kind != Kind::verlet) scheme.force = scheme.drift = draw_phi(source, "phi");
  if (scheme.kind == Kind::pair) scheme.drift = draw_phi(source, "phi of the drift");
  return scheme;
}
inline Vec draw_masses(Source& source, Eigen::Index n) {
  Vec m = source.numbers("log of masses", n, 1);
  for (double& each : m) each = std::pow(2.0, each);
  return m;
}
inline double size_of(const Moving& y, double velocity = 1) {
  return std::max(y.r.cwiseAbs().maxCoeff(), velocity * y.v.cwiseAbs().maxCoeff());
}
/// The distance of two motions; velocities times a time, so that the two parts add up.
inline double distance(const Moving& a, const Moving& b, double time = 1) {
  const double x = (a.r - b.r).cwiseAbs().maxCoeff(), w = (a.v - b.v).cwiseAbs().maxCoeff();
  return x + time * w;  // NaN where one is
}

/// 1. A linear force makes a linear map of every step: Φ(ax + by) = aΦ(x) + bΦ(y).
///
/// −K and −C are positive semidefinite, so that ‖W⁻¹M‖ ≤ √κ(M) and the step grows nothing: what is left is rounding in the
/// products K r and C v, n u of their absolute sums g each, and in the solve, as much again.
inline void linearity(Source& source) {
  const int n = source.integer("n", 1, 5);
  const Mat A = source.matrix("A", n, n, 2), B = source.matrix("B", n, n, 1);
  const Mat K = -A * A.transpose(), C = -B * B.transpose();
  const bool damped = source.flag("damped");
  const Law law = [&](const Vec& r, const Vec& v, double) -> Vec { return damped ? Vec(K * r + C * v) : Vec(K * r); };
  const Scheme scheme = draw_scheme(source);
  const Vec m = draw_masses(source, n);
  const double t = source.number("t", 2), dt = source.real("dt", 0.0009765625, 1);
  const Moving x{source.numbers("x.r", n, 1), source.numbers("x.v", n, 1)};
  const Moving y{source.numbers("y.r", n, 1), source.numbers("y.v", n, 1)};
  const double a = source.number("a", 4), b = source.number("b", 4);
  Moving sum{a * x.r + b * y.r, a * x.v + b * y.v}, stepped_x = x, stepped_y = y;
  const bool ok = march(scheme, law, m, sum, t, dt) && march(scheme, law, m, stepped_x, t, dt) &&
                  march(scheme, law, m, stepped_y, t, dt);
  source.require(ok, "a step of a damped linear motion fails");
  const Moving expected{a * stepped_x.r + b * stepped_y.r, a * stepped_x.v + b * stepped_y.v};
  const double k = K.cwiseAbs().rowwise().sum().maxCoeff(), c = damped ? C.cwiseAbs().rowwise().sum().maxCoeff() : 0;
  const double size =
      std::abs(a) * (size_of(x, dt) + size_of(stepped_x, dt)) + std::abs(b) * (size_of(y, dt) + size_of(stepped_y, dt));
  const double growth = 1 + dt * (c + dt * k) / m.minCoeff();
  source.bound(distance(sum, expected, dt), 16 * n * u * growth * size, "not linear");
}

/// A smooth force with couplings, damping and a drive, |∂Ψ/∂r|, |∂Ψ/∂v| ≤ `stiffness`.
inline Law draw_law(Source& source, int n, bool rests = false) {
  const double stiffness = source.real("stiffness", 0, 4);
  const Vec phases = source.numbers("phases", n, 3);
  const bool damped = !rests && source.flag("damped"), driven = !rests && source.flag("driven");
  return [=](const Vec& r, const Vec& v, double t) -> Vec {
    Vec f(n);
    for (Eigen::Index i = 0; i < n; ++i) {
      const Eigen::Index j = (i + 1) % n;
      f[i] = -stiffness / 2 * (std::sin(r[i] + phases[i]) + 0.5 * (r[i] - r[j]));
      if (damped) f[i] -= stiffness / 4 * std::atan(v[i] + 0.5 * v[j]);
      if (driven) f[i] += std::cos(3 * t + phases[i]);
    }
    return f;
  };
}

/// 2. φ over Δt, then 1 − φ over −Δt from there, is the identity: each is the other's adjoint. With φ = ½ that is the
/// scheme itself, as it is of Verlet and its compositions.
///
/// Solved to rounding, each step errs by some u of what it adds up; the stage form goes on from its solve by 1/φ of the
/// increment, and so do roundings. Δt·stiffness ≤ ½ (masses ≥ ½): a step's inverse amplifies by 1/(1 − ½)² at the most. The
/// compositions' substeps add up to 5 Δt, back and forth.
inline void reversal(Source& source) {
  const int n = source.integer("n", 1, 5);
  Scheme scheme = draw_scheme(source);
  if (scheme.kind == Kind::verlet)
    scheme.kind = static_cast<Kind>(3 + source.one_of("or", {"Verlet", "srkn6b", "composed"}));
  const Law law = draw_law(source, n, scheme.kind > Kind::verlet);
  const Vec m = draw_masses(source, n);
  const double t = source.number("t", 2), dt = source.number("dt", 0.0625);
  source.assume(std::abs(dt) > 1e-3);
  const Moving start{source.numbers("r", n, 2), source.numbers("v", n, 2)};
  Moving y = start;
  const bool composed = scheme.kind > Kind::verlet;
  source.require(march(scheme, law, m, y, t, dt), "a short step fails");
  const Scheme back = scheme.kind >= Kind::verlet ? scheme : scheme.adjoint();
  source.require(march(back, law, m, y, t + dt, -dt), "a short step back fails");
  const double size = std::max(1.0, std::max(size_of(start), size_of(y)));
  const bool inside = scheme.kind == Kind::stage && scheme.force > 0 && scheme.force < 1;
  const double amplification = inside ? 1 / std::min(scheme.force, 1 - scheme.force) : 1;
  source.bound(distance(y, start), (composed ? 128 : 32) * u * size * amplification, "does not return");
}

/// 9. Forces between particles keep the momentum at any φ; the midpoint rule keeps angular momentum, and the energy of a
/// quadratic potential.
///
/// Momentum: Newton ends within some u of the step, whose forces are up to 8 here, n of them: n·u·(|p| + Δt·ΣF) a step.
inline void conservation(Source& source) {
  const int n = source.integer("particles", 2, 5);
  const Mat strength = source.matrix("strengths", n, n, 1);
  const bool quadratic = source.flag("quadratic");
  const Law law = [&](const Vec& r, const Vec&, double) -> Vec {
    Vec f = Vec::Zero(2 * n);
    for (Eigen::Index i = 0; i < n; ++i)
      for (Eigen::Index j = 0; j < i; ++j) {
        const Eigen::Vector2d d = r.segment<2>(2 * i) - r.segment<2>(2 * j);
        const double k = std::abs(strength(i, j)) + 0.1;
        const Eigen::Vector2d pull = (quadratic ? -k : -k / (1 + d.squaredNorm())) * d;
        f.segment<2>(2 * i) += pull;
        f.segment<2>(2 * j) -= pull;
      }
    return f;
  };
  Scheme scheme = draw_scheme(source);
  const bool midpoint = scheme.kind == Kind::stage && scheme.force == 0.5;
  Vec m = draw_masses(source, n), masses(2 * n);
  for (Eigen::Index i = 0; i < n; ++i) masses.segment<2>(2 * i).setConstant(m[i]);
  Moving y{source.numbers("r", 2 * n, 2), source.numbers("v", 2 * n, 1)};
  const double dt = source.real("dt", 0.0078125, 0.25);
  const int steps = source.integer("steps", 1, 20);
  struct Sums {
    Eigen::Vector2d p = Eigen::Vector2d::Zero();
    double L = 0, E = 0;
  };
  double scale = 0;
  const auto sums = [&] {
    Sums s;
    for (Eigen::Index i = 0; i < n; ++i) {
      const Eigen::Vector2d r = y.r.segment<2>(2 * i), v = y.v.segment<2>(2 * i);
      s.p += m[i] * v;
      s.L += m[i] * (r[0] * v[1] - r[1] * v[0]);
      s.E += m[i] * v.squaredNorm() / 2;
      for (Eigen::Index j = 0; j < i; ++j)
        s.E += (std::abs(strength(i, j)) + 0.1) * (r - y.r.segment<2>(2 * j)).squaredNorm() / 2;
      scale = std::max({scale, m[i] * v.norm(), m[i] * v.squaredNorm(), m[i] * r.norm() * v.norm(), r.squaredNorm()});
    }
    return s;
  };
  const Sums before = sums();
  source.require(march(scheme, law, masses, y, 0, dt, steps), "a step fails");
  const Sums after = sums();
  source.assume(scale < 1e6);  // unstable ones have no figures
  const double allowed = 8 * n * n * (steps + 1) * u * std::max(scale, 1.0);
  source.bound((after.p - before.p).norm(), allowed, "momentum is lost");
  if (!midpoint) return;
  source.bound(std::abs(after.L - before.L), allowed, "angular momentum is lost");
  if (quadratic) source.bound(std::abs(after.E - before.E), allowed, "energy is lost");
}

/// 10. Units of force and mass: Ψ and M times 2^k give the same bits. Dearer by nothing: the same counts.
inline void scaling(Source& source) {
  const int n = source.integer("n", 1, 5);
  const Law law = draw_law(source, n);
  const Scheme scheme = draw_scheme(source);
  const Vec m = draw_masses(source, n);
  const double t = source.number("t", 2), dt = source.number("dt", 0.125),
               by = std::ldexp(1, source.integer("power", -60, 60));
  source.assume(std::abs(dt) > 1e-3);
  const Moving start{source.numbers("r", n, 2), source.numbers("v", n, 2)};
  Moving one = start, other = start;
  const Law scaled = [&](const Vec& r, const Vec& v, double at) -> Vec { return by * law(r, v, at); };
  const bool ok = march(scheme, law, m, one, t, dt, 3);
  source.require(march(scheme, scaled, by * m, other, t, dt, 3) == ok, "one unit fails where another doesn't");
  source.require(states::same_bits(one.r, other.r) && states::same_bits(one.v, other.v), "units change bits");
}

}  // namespace flows

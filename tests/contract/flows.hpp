#pragma once

// Properties of steps of vectors: those of flows_steps.hpp, and sums of terms.

#include <utility>

#include "contract/flows_steps.hpp"

namespace flows {

/// 10. Terms: grouped in any way the same bits, in any order the same to rounding; a sum of terms is a term's sum; a term
/// that is zero changes nothing; one that enters as kicks is what kicks by hand are.
inline void sums(Source& source) {
  const int n = source.integer("n", 1, 5);
  const Law f = draw_law(source, n, true), g = draw_law(source, n, true), h = draw_law(source, n, true);
  const auto as = [](const Law& law) { return term(Resting{law}); };
  const double t = source.number("t", 2), dt = source.real("dt", 0.001, 0.125);
  const Moving start{source.numbers("r", n, 2), source.numbers("v", n, 2)};
  const auto by = [&](auto force, auto scheme) {
    Moving y = start;
    PhiStepper stepper{y, force, scheme};
    for (int k = 0; k < 3; ++k) source.require(static_cast<bool>(stepper.step(y, t + k * dt, dt)), "a step fails");
    return std::pair{y, stepper.statistics()};
  };
  const auto same = [](const Moving& a, const Moving& b) {
    return states::same_bits(a.r, b.r) && states::same_bits(a.v, b.v);
  };
  const auto [left, count] = by((as(f) + as(g)) + as(h), velocity_verlet);
  const auto [right, again] = by(as(f) + (as(g) + as(h)), velocity_verlet);
  source.require(same(left, right) && count == again, "the grouping of terms matters");
  const auto [turned, turned_count] = by(as(h) + as(f) + as(g), velocity_verlet);
  // |Ψ| ≤ 3·12, three terms: 2 u of them a sum, three steps, and what Δt²·stiffness makes of it.
  const double allowed = 3 * 8 * u * (36 * dt + size_of(left));
  source.bound(distance(left, turned), allowed, "the order of terms matters");
  const Law all = [&](const Vec& r, const Vec& v, double at) -> Vec { return f(r, v, at) + g(r, v, at) + h(r, v, at); };
  const auto [together, one] = by(as(all), velocity_verlet);
  source.bound(distance(left, together), allowed, "a sum of terms is not the term of their sum");
  source.require(one.force_calls == count.force_calls, "a sum of terms counts otherwise than one term");
  const Law nothing = [](const Vec& r, const Vec&, double) -> Vec { return Vec::Zero(r.size()); };
  const auto [with_zero, zero_count] = by(as(f) + as(g) + as(nothing), velocity_verlet);
  const auto [without, two_count] = by(as(f) + as(g), velocity_verlet);
  source.require((with_zero.r.array() == without.r.array()).all() && (with_zero.v.array() == without.v.array()).all(),
                 "a force of zero changes the motion");
  source.require(zero_count == two_count, "a force of zero costs steps or calls");

  // f by the trapezoidal rule between half kicks by g.
  const auto [split, split_count] = by(as(f) + at(forward_euler, Resting{g}), trapezoidal);
  Moving y = start;
  PhiStepper inner{y, as(f), trapezoidal};
  for (int k = 0; k < 3; ++k) {
    y.v += dt / 2 * g(y.r, y.v, 0);
    source.require(static_cast<bool>(inner.step(y, t + k * dt, dt)), "a step fails");
    y.v += dt / 2 * g(y.r, y.v, 0);
  }
  source.bound(distance(split, y), 2 * allowed, "kicks are not those by hand");
}

}  // namespace flows

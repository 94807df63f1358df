#pragma once

// What the quick and the full half of run/stepper/edits share.
#include <phistep/phistep.hpp>

#include <cmath>
#include <random>

#include "contract/states.hpp"
#include "problems/march.hpp"
#include "support/catch.hpp"

using namespace phistep;
using namespace states;

namespace edits_cases {

/// One random edit: nothing, a component, a sign, two particles swapped, a component to 0, or another time.
template <class S>
void edit(S& state, double& t, std::mt19937& random) {
  std::uniform_int_distribution<int> kind(0, 6), which(0, 5);
  const int what = kind(random), k = which(random);
  const auto blocks = Blocks<S>::all(state);
  for_each_block(
      [&](auto, auto& block) {
        if (block.size() != 6) return;
        const int other = (k + 3) % 6;
        if (what == 1) component(block, k) += 1e-9;
        if (what == 2) component(block, k) = -component(block, k);
        if (what == 3) std::swap(component(block, k), component(block, other));
        if (what == 4) component(block, k) = 0;
      },
      blocks);
  if (what == 5) t += 0.37;
  if (what == 6) component(std::get<0>(blocks), k) *= 1.001;  // the positions alone
}

/// A hundred steps with edits between them; before each, a fresh stepper takes the same step.
template <class Case>
void check(auto force, auto scheme, double tolerance, unsigned seed) {
  Case c;
  using S = typename Case::State;
  PhiStepper stepper{c.state, force, scheme};
  std::mt19937 random(seed);
  double t = 0, worst = 0;
  for (int n = 0; n < 100; ++n) {
    edit(c.state, t, random);
    PlainState<S> expected = [&] {
      PlainState<S> copy;
      copy_blocks<S>(copy, c.state);
      return copy;
    }();
    PhiStepper fresh{expected, force, scheme};
    problems::step(fresh, expected, t, 0.05);
    problems::step(stepper, c.state, t, 0.05);
    worst = std::max(worst, distance(numbers(c.state), numbers(expected)));
    t += 0.05;
  }
  CHECK(worst <= tolerance);
}

inline double tolerance_of(const char* scheme) {
  const std::string name = scheme;
  return name.find("euler") != name.npos && name.find("backward") == name.npos
             ? 0
             : 1e-12;  // the explicit ones: to the bit
}

template <class Case>
void check_all(auto force) {
  const auto each = [&](const char* name, auto scheme) {
    CAPTURE(name);
    check<Case>(force, scheme, tolerance_of(name), 17);
  };
  for_each_motion_scheme(each);
}

/// Ψ tells +0 from −0, as atan2, sqrt and 1/x do: what is known at +0 must not pass for what is known at −0.
template <class V>
struct SignOfZero {
  using T = typename V::Scalar;
  V operator()(const V& r) const {
    V f = r;
    for (Eigen::Index i = 0; i < r.size(); ++i) f[i] = std::copysign(T(1), r[i]);
    return f;
  }
};
/// From 0 exactly, at which every step ends that goes there and back; then an edit to −0.
template <class V>
void check_sign_of_zero(auto scheme, int size, double tolerance = 0) {
  using T = typename V::Scalar;
  Motion<V> y{V::Zero(size), V::Zero(size)};
  PhiStepper stepper{y, SignOfZero<V>{}, scheme};
  // r and v are set to what the last step left, but for a sign.
  y.v.setConstant(-T(0.0625));
  y.r.setConstant(T(0.0625) * T(0.125) - T(0.5) * T(0.125) * T(0.125));
  REQUIRE(stepper.step(y, T(0), T(0.125)));
  for (Eigen::Index i = 0; i < size; ++i) REQUIRE(y.r[i] == T(0));
  y.r = -y.r;
  auto z = y;
  PhiStepper fresh{z, SignOfZero<V>{}, scheme};
  REQUIRE(stepper.step(y, T(0.125), T(0.125)));
  REQUIRE(fresh.step(z, T(0.125), T(0.125)));
  CHECK(static_cast<double>((y.v - z.v).cwiseAbs().maxCoeff()) <= tolerance);
}
}  // namespace edits_cases

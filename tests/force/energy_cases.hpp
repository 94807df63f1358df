// What energy.test.cpp and energy.full.cpp share.
#pragma once

#include <phistep/phistep.hpp>

#include <algorithm>
#include <cmath>
#include <functional>
#include <tuple>
#include <utility>
#include <vector>

#include "contract/states.hpp"
#include "support/catch.hpp"

using namespace phistep;
using namespace states;

namespace energy_cases {

/// V and Ψ of a force at a motion's state, for one mass.
template <class S, class F, class M>
double energy_of(F& force, const S& y, const M& m, double t = 0) {
  return static_cast<double>(potential_energy(unwrap(force), t, Blocks<S>::view(y, std::tuple{m})));
}
template <class S, class F, class M>
auto force_of(F& force, const S& y, const M& m, double t = 0) {
  auto out = make_rate<S>(y);
  assign_force(unwrap(force), t, Blocks<S>::view(y, std::tuple{m}), NoMemory{}, out);
  return out.force;
}

/// Largest difference between −∂V/∂r, by central differences, and Ψ at v = 0, relative to Ψ. With δ = 1e-5 and lengths of
/// about 1, differences err by δ²/6 ≈ 2e-11 of the third derivative, and by uV/δ ≈ 2e-11 of V, up to 100 times the force.
template <class S, class F, class M>
double gradient_error(F force, S y, const M& m, double t = 0) {
  y.v.setZero();
  const auto psi = force_of(force, y, m, t);
  constexpr double delta = 1e-5;
  double worst = 0;
  for (Eigen::Index i = 0; i < y.r.size(); ++i) {
    double& x = y.r.data()[i];
    const double at = x;
    x = at + delta;
    const double above = energy_of(force, y, m, t);
    x = at - delta;
    const double below = energy_of(force, y, m, t);
    x = at;
    worst = std::max(worst, std::abs(-(above - below) / (2 * delta) - psi.data()[i]));
  }
  return worst / psi.cwiseAbs().maxCoeff();
}

inline const std::vector<Spring> two_springs{{0, 1, 80.0, 0.4}, {1, 0, 30.0, 0.0}};

}  // namespace energy_cases

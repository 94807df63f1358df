#pragma once

// What the quick and the full half of schemes/tr_bdf2 share.
#include <phistep/phistep.hpp>

#include <cmath>
#include <complex>
#include <vector>

#include "contract/states.hpp"
#include "convergence/observed_order.hpp"
#include "problems/dahlquist.hpp"
#include "problems/forced.hpp"
#include "problems/march.hpp"
#include "support/catch.hpp"

using namespace phistep;
using convergence::check_order;
using convergence::errors;
using problems::distance;
using problems::march;
using Vec = Eigen::VectorXd;

namespace tr_bdf2_cases {

/// One step of y' = λy from 1 with Δt = 1: R(z).
inline double amplification(double z) {
  const problems::Dahlquist problem{z};
  problems::Dahlquist::State y{1};
  PhiStepper stepper{y, problem, tr_bdf2};
  problems::step(stepper, y, 0.0, 1.0);
  return y[0];
}
/// (1 + √2 ζ)/(1 − ζ)², ζ = γz/2
template <class Z>
Z formula(Z z) {
  const Z zeta = z * (1 - std::sqrt(0.5));
  return (1.0 + std::sqrt(2.0) * zeta) / ((1.0 - zeta) * (1.0 - zeta));
}

inline constexpr int n = 20;  // steps
struct LinearPull {
  Vec operator()(const Vec& y) const { return -4 * y; }
  Eigen::MatrixXd jacobian(const Vec& y) const { return -4 * Eigen::MatrixXd::Identity(y.size(), y.size()); }
};
struct Remembering : ForceTerm {
  struct Memory {};
  static constexpr bool uses_velocity = false, uses_time = false;
  void add(double, const auto& y, const Memory&, auto& out) const { out.force -= 4 * y.r; }
  void commit(double, const auto&, Memory&) const {}
};

}  // namespace tr_bdf2_cases

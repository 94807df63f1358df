#pragma once

// What the quick and the full half of schemes/splitting share.
#include <phistep/phistep.hpp>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "accuracy/observed_order.hpp"
#include "contract/states.hpp"
#include "problems/march.hpp"
#include "support/catch.hpp"

using namespace phistep;
using convergence::check_order;
using convergence::errors;
using problems::march;
using Vec = Eigen::VectorXd;
using V1 = Eigen::Matrix<double, 1, 1>;
using V2 = Eigen::Vector2d;

namespace splitting_cases {

inline constexpr int n = 20;  // steps

inline const auto stiff = [](const V2& r) -> V2 { return -9 * r - r.squaredNorm() * r; };
inline const auto soft = [](const V2& r) -> V2 { return -r.array().sin(); };
inline const auto damped_soft = [](const V2& r, const V2& v, double t) -> V2 {
  return -r.array().sin() - 0.4 * v.array() * v.norm() + std::cos(2 * t);
};
inline Motion<V2> start() { return {V2{1, 0.2}, V2{0.3, -0.5}}; }

/// Observed orders against a run of the sum by Verlet or midpoint, fine enough that its error doesn't count.
template <class State>
void check_split_order(const State& y0, auto split, auto whole, auto scheme, double order, int coarsest,
                       double margin) {
  const State exact = march(PhiStepper{y0, whole, midpoint}, y0, 0.0, 2.0, 20000);
  check_order(errors(coarsest,
                     [&](int steps) {
                       return problems::distance(march(PhiStepper{y0, split, scheme}, y0, 0.0, 2.0, steps), exact);
                     }),
              order, margin);
}

/// The eigenvalues' largest magnitude of one step of length 1 of r'' = −(k_s + ω²) r, the ω² part in kicks.
inline double spectral_radius(auto scheme, double k_s, double omega) {
  const auto force = term([k_s](const V1& r) -> V1 { return -k_s * r; }) +
                     at(forward_euler, [omega](const V1& r) -> V1 { return -omega * omega * r; });
  Eigen::Matrix2d map;
  // v is scaled by the stiff frequency, so that the matrix is well scaled too.
  const double scale = std::max(1.0, std::sqrt(k_s));
  for (int column = 0; column < 2; ++column) {
    Motion<V1> y{V1(column == 0 ? 1.0 : 0.0), V1(column == 1 ? scale : 0.0)};
    PhiStepper stepper{y, force, scheme};
    problems::step(stepper, y, 0.0, 1.0);
    map.col(column) << y.r[0], y.v[0] / scale;
  }
  const double half_trace = map.trace() / 2, det = map.determinant(), square = half_trace * half_trace - det;
  return square < 0 ? std::sqrt(det) : std::abs(half_trace) + std::sqrt(square);
}

struct Counted {
  int* calls;
  Vec operator()(const Vec& r) const {
    ++*calls;
    return -4 * r;
  }
};

template <class F>
Statistics count(F force, auto scheme, const auto&... more) {
  Motion<Vec> y{Vec::Ones(4), Vec::Zero(4)};
  PhiStepper stepper{y, force, scheme, more...};
  for (int k = 0; k < n; ++k) problems::step(stepper, y, 0.01 * k, 0.01);
  CHECK(stepper.statistics().steps == n);
  return stepper.statistics();
}

inline const Gravity<V1> weight{V1(-9.81)};
inline const auto springs = [](const Vec& r) -> Vec { return -100 * r; };

/// A slider: its anchor follows once the stretch exceeds 0.1.
struct Slider : ForceTerm {
  struct Memory {
    Vec anchor;
    int begins = 0, commits = 0;
  };
  static constexpr bool uses_velocity = false, uses_time = false;
  void begin(double, double, const auto& y, Memory& m) const {
    if (m.anchor.size() == 0) m.anchor = y.r;
    ++m.begins;
  }
  void add(double, const auto& y, const Memory& m, auto& out) const { out.force -= 30 * (y.r - m.anchor); }
  void commit(double, const auto& y, Memory& m) const {
    for (Eigen::Index i = 0; i < y.r.size(); ++i) m.anchor[i] = std::clamp(m.anchor[i], y.r[i] - 0.1, y.r[i] + 0.1);
    ++m.commits;
  }
};

/// Steps of a motion that is edited on the way, each beside a new stepper's: the largest difference, or the first that is
/// above rounding.
double worst_after_edits(Motion<V2>& y, const auto& force, auto scheme) {
  PhiStepper stepper{y, force, scheme};
  double worst = 0;
  for (int k = 0; k < 20; ++k) {
    if (k % 3 == 1) y.r[k % 2] += 0.01;
    if (k % 4 == 2) y.v = -y.v;
    auto z = y;
    PhiStepper fresh{z, force, scheme};
    problems::step(stepper, y, 0.1 * k, 0.1);
    problems::step(fresh, z, 0.1 * k, 0.1);
    const double off = problems::distance(y, z);
    if (!(off <= 1e-14)) return off;
    worst = std::max(worst, off);
  }
  return worst;
}

/// The weight, term 1 of `force`, is taken away after a step.
template <class State>
void check_new_parameter(State y, const auto& force, const auto& without) {
  PhiStepper stepper{y, force, trapezoidal};
  problems::step(stepper, y, 0.0, 0.01);
  std::get<1>(stepper.force().terms).force.g = V1(0.0);
  auto z = y;
  PhiStepper bare{z, without, trapezoidal};
  problems::step(stepper, y, 0.01, 0.01);
  problems::step(bare, z, 0.01, 0.01);
  CHECK(problems::distance(y, z) <= 1e-15);
}

/// A slider in the kicks and one in the rest, beside springs; the kick `poison` fails once it is `poisoned`.
template <class State>
void check_history(State y, const auto& rest, const auto& poison, bool& poisoned) {
  PhiStepper stepper{y, Slider{} + at(forward_euler, Slider{}) + at(forward_euler, poison) + term(rest), trapezoidal};
  for (int k = 0; k < 5; ++k) problems::step(stepper, y, 0.1 * k, 0.1);
  const auto check = [&] {
    CHECK(std::get<0>(stepper.memory()).commits == 5);
    CHECK(std::get<1>(stepper.memory()).commits == 5);
    CHECK(std::get<1>(stepper.memory()).begins == 5);
    CHECK(std::get<0>(stepper.memory()).anchor == std::get<1>(stepper.memory()).anchor);
  };
  check();
  poisoned = true;
  const auto before = y;
  const StepReport report = stepper.step(y, 0.5, 0.1);
  CHECK(report.outcome() == Outcome::non_finite_force);
  CHECK(report.failure().term == 2);  // in the user's own order
  CHECK((y.r == before.r && y.v == before.v));
  check();
}

}  // namespace splitting_cases

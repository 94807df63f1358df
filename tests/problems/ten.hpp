#pragma once

// The ten problems on which a tolerance has to mean what it says, stiff and not, of first order and motions; and how
// strongly each of them magnifies errors.

#include <Eigen/Core>
#include <phistep/phistep.hpp>

#include <algorithm>
#include <functional>
#include <type_traits>
#include <vector>

#include "problems/brusselator.hpp"
#include "problems/damped_pendulum.hpp"
#include "problems/driven_chain.hpp"
#include "problems/heat.hpp"
#include "problems/hires.hpp"
#include "problems/kepler.hpp"
#include "problems/linear_extrapolation.hpp"
#include "problems/oregonator.hpp"
#include "problems/prothero_robinson.hpp"
#include "problems/robertson.hpp"
#include "problems/van_der_pol.hpp"

namespace problems {

/// A problem with its answer. Errors are max_i |y_i − exact_i| / (|exact_i| + a), and atol = a·rtol goes with them.
template <class F, class S>
struct Case {
  const char* name;
  F force;
  S start, exact;
  double end;
  double a;    ///< what a component below it is measured by [the state's units]
  bool stiff;  ///< explicit steps would be limited by stability

  static constexpr bool is_motion = !phistep::EigenDense<S>;
};

template <class F, class S>
Case(const char*, F, S, S, double, double, bool) -> Case<F, S>;  // clang 14 doesn't deduce aggregates

/// Case::stiff, known when it compiles: what would not run need not be compiled.
template <class F>
inline constexpr bool is_stiff = std::is_same_v<F, Hires> || std::is_same_v<F, Robertson> ||
                                 std::is_same_v<F, Oregonator> || std::is_same_v<F, Heat<Eigen::MatrixXd>>;

/// Calls f(case) for each of the ten.
template <class F>
void for_each_of_ten(F&& f) {
  using phistep::Motion;
  constexpr int points = 20;
  const ProtheroRobinson mild{-10};
  const Kepler kepler;
  const Heat<Eigen::MatrixXd> heat(points);
  const auto modes = [&](double t) -> Vector {
    using H = Heat<Eigen::MatrixXd>;
    return std::exp(H::eigenvalue(points, 1) * t) * H::mode(points, 1) +
           std::exp(H::eigenvalue(points, 4) * t) * H::mode(points, 4);
  };
  f(Case{"Prothero-Robinson, lambda = -10", mild, mild.exact(0), mild.exact(10), 10, 1.0, false});
  f(Case{"Brusselator", Brusselator{}, Brusselator::start(), Brusselator::exact(), Brusselator::end, 1.0, false});
  f(Case{"Kepler, e = 0.6, two periods", kepler, kepler.start(), kepler.exact(2 * Kepler::period), 2 * Kepler::period,
         1.0, false});
  f(Case{"damped pendulum", DampedPendulum{}, DampedPendulum::start(), DampedPendulum::exact(), DampedPendulum::end,
         1.0, false});
  f(Case{"Van der Pol, mu = 5", VanDerPol{}, VanDerPol::start(), VanDerPol::exact(), VanDerPol::end, 1.0, false});
  f(Case{"HIRES", Hires{}, Hires::start(), Hires::exact(), Hires::end, 1e-4, true});
  f(Case{"Robertson", Robertson{}, Robertson::start(), Robertson::exact(), Robertson::end, 1e-6, true});
  f(Case{"Oregonator", Oregonator{}, Oregonator::start(), Oregonator::exact(), Oregonator::end, 1e-6, true});
  f(Case{"heat, 20 points", heat, modes(0), modes(0.1), 0.1, 1.0, true});
  f(Case{"driven chain", DrivenChain{}, DrivenChain::start(), DrivenChain::exact(), DrivenChain::end, 1.0, false});
}

/// The state as one vector, r before v.
template <class S>
[[nodiscard]] Vector stacked(const S& y) {
  if constexpr (phistep::EigenDense<S>) {
    return y;
  } else {
    Vector x(2 * y.r.size());
    x << y.r, y.v;
    return x;
  }
}

/// y' = f(t, y) of a case, for solvers that know vectors only.
template <class F, class S>
[[nodiscard]] auto right_hand_side(const Case<F, S>& problem) {
  return [force = problem.force](double t, const Vector& x) -> Vector {
    if constexpr (phistep::EigenDense<S>) {
      if constexpr (requires { force(S(x), t); }) return force(S(x), t);
      else return force(S(x));
    } else {
      using V = std::remove_cvref_t<decltype(std::declval<S>().r)>;
      const auto half = x.size() / 2;
      const V r = x.head(half), v = x.tail(half);
      Vector rate(x.size());
      if constexpr (requires { force(r, v, t); }) rate << v, force(r, v, t);
      else if constexpr (requires { force(r, v); }) rate << v, force(r, v);
      else rate << v, force(r);
      return rate;
    }
  };
}

/// max |y_i − exact_i| / (|exact_i| + a)
[[nodiscard]] inline double relative_error(const Vector& y, const Vector& exact, double a) {
  return ((y - exact).array() / (exact.array().abs() + a)).abs().maxCoeff();
}
template <class F, class S>
[[nodiscard]] double relative_error(const S& y, const Case<F, S>& problem) {
  return relative_error(stacked(y), stacked(problem.exact), problem.a);
}

/// y' = f(t, y) without its type: what follows is compiled once.
using AnyRate = std::function<Vector(double t, const Vector& y)>;

/// By how much the problem itself magnifies a small relative error made at its start or at one of ten later times, at
/// worst, until its end; at least 1. With w = |y| + a and Φ_s = ∂y(end)/∂y(s), κ = max_s max_i Σ_k |Φ_s|_ik w_k(s)/w_i(end):
/// the norm of errors, with the worst signs. Φ_s is the product of the transitions between the times, by differences.
template <class = void>  // compiled only where it is called
[[nodiscard]] double conditioning(const AnyRate& f, const Vector& start, double end, double a) {
  constexpr int intervals = 11;
  std::vector<Vector> y{start};
  std::vector<Eigen::MatrixXd> transition;
  const auto n = y[0].size();
  for (int s = 0; s < intervals; ++s) {
    const double t0 = end * s / intervals, t1 = end * (s + 1) / intervals;
    const Vector& from = y.back();
    const Vector to = extrapolate(f, from, t0, t1, a);
    Eigen::MatrixXd moved(n, n);
    for (Eigen::Index k = 0; k < n; ++k) {
      const double by = 1e-5 * (std::abs(from[k]) + a);
      Vector up = from, down = from;
      up[k] += by;
      down[k] -= by;
      moved.col(k) = (extrapolate(f, up, t0, t1, a) - extrapolate(f, down, t0, t1, a)) / (2 * by);
    }
    transition.push_back(moved);
    y.push_back(to);
  }
  double kappa = 1;
  Eigen::MatrixXd phi = Eigen::MatrixXd::Identity(n, n);
  const Eigen::ArrayXd at_end = y.back().array().abs() + a;
  for (int s = intervals - 1; s >= 0; --s) {
    const auto i = static_cast<std::size_t>(s);
    phi = (phi * transition[i]).eval();
    const Eigen::ArrayXd growth = (phi.cwiseAbs() * (y[i].array().abs() + a).matrix()).array() / at_end;
    kappa = std::max(kappa, growth.maxCoeff());
  }
  return kappa;
}
template <class F, class S>
[[nodiscard]] double conditioning(const Case<F, S>& problem) {
  return conditioning(right_hand_side(problem), stacked(problem.start), problem.end, problem.a);
}

}  // namespace problems

#pragma once

// The classical test set: problems/*.hpp as one list.

#include <algorithm>
#include <cmath>
#include <functional>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "accuracy/truth/solution.hpp"
#include "problems/e5.hpp"
#include "problems/hires.hpp"
#include "problems/kepler.hpp"
#include "problems/oregonator.hpp"
#include "problems/outer_solar_system.hpp"
#include "problems/pleiades.hpp"
#include "problems/pollution.hpp"
#include "problems/relaxation.hpp"
#include "problems/robertson.hpp"
#include "problems/ten.hpp"

namespace truth {

namespace detail {

template <class P>
[[nodiscard]] Problem stiff(const char* name, const typename P::State& exact, double end, double a) {
  Problem problem;
  problem.name = name;
  problem.start = P::start();
  problem.exact = exact;
  problem.end = end;
  problem.a = a;
  problem.kappa = conditioning(Any{P{}}, problem.start, end, a);
  attach(problem, P{});
  return problem;
}

/// κ: by bench/work_precision --conditioning.
template <class P, class V>
[[nodiscard]] Problem motion(const char* name, const V& r, const V& v, const V& exact_r, const V& exact_v, double end,
                             double a, double kappa) {
  Problem problem;
  const auto n = r.size();
  problem.name = name;
  problem.kind = Kind::motion;
  problem.start.resize(2 * n);
  problem.start << r, v;
  problem.exact.resize(2 * n);
  problem.exact << exact_r, exact_v;
  problem.end = end;
  problem.a = a;
  problem.kappa = kappa;
  problem.acceleration = [](const double* at, double* out) { P::acceleration(at, out); };
  problem.rate = [n](double, const double* y, double* out) {
    std::copy(y + n, y + 2 * n, out);
    P::acceleration(y, out + n);
  };
  return problem;
}

/// y' = f(y, t) with a Jacobian, as problems/ten.hpp has them.
template <class F>
[[nodiscard]] Problem flow(const char* name, Kind kind, const F& force, const Eigen::VectorXd& start,
                           const Eigen::VectorXd& exact, double end) {
  Problem problem;
  problem.name = name;
  problem.kind = kind;
  problem.start = start;
  problem.exact = exact;
  problem.end = end;
  const auto n = start.size();
  using Wide = std::function<Eigen::VectorXd(const Eigen::VectorXd&, double)>;
  const Wide f = [force](const Eigen::VectorXd& y, double t) -> Eigen::VectorXd {
    if constexpr (requires { force(y, t); }) return force(y, t);
    else return force(y);
  };
  problem.rate = [f, n](double t, const double* y, double* out) {
    Eigen::Map<Eigen::VectorXd>(out, n) = f(Eigen::Map<const Eigen::VectorXd>(y, n), t);
  };
  problem.jacobian = [force, n](double t, const double* y, double* J) {
    const Eigen::VectorXd at = Eigen::Map<const Eigen::VectorXd>(y, n);
    Eigen::Map<Eigen::MatrixXd> to(J, n, n);
    if constexpr (requires { force.jacobian(at, t); }) to = force.jacobian(at, t);
    else to = force.jacobian(at);
  };
  problem.kappa = problems::conditioning(problems::Case<Wide, Eigen::VectorXd>{name, f, start, exact, end, 1.0, true});
  return problem;
}

}  // namespace detail

[[nodiscard]] inline std::vector<Problem> classical_problems() {
  using namespace problems;
  std::vector<Problem> all;
  all.push_back(detail::stiff<Robertson>("Robertson to 40", Robertson::exact(), Robertson::end, 1e-6));
  all.push_back(detail::stiff<Robertson>("Robertson to 1e11", Robertson::exact_late(), Robertson::late, 1e-8));
  all.push_back(detail::stiff<Relaxation>("Van der Pol, epsilon = 1e-6", Relaxation::exact(), Relaxation::end, 1));
  all.push_back(detail::stiff<Hires>("HIRES", Hires::exact(), Hires::end, 1e-4));
  all.push_back(detail::stiff<Oregonator>("Oregonator", Oregonator::exact(), Oregonator::end, 1e-6));
  all.push_back(detail::stiff<Pollution>("Pollution", Pollution::exact(), Pollution::end, 1e-4));
  all.push_back(detail::stiff<E5>("E5", E5::exact(), E5::end, 1e-22));
  for (const double lambda : {-10.0, -1e3, -1e6}) {
    using P = ProtheroRobinson;
    Problem problem;  // κ = 1: it damps every error
    problem.name = "Prothero-Robinson, lambda = " + std::to_string(static_cast<int>(lambda));
    problem.kind = lambda < -100 ? Kind::classical : Kind::smooth;
    problem.start = Eigen::VectorXd::Constant(1, P::exact(0)[0]);
    problem.end = 10;
    problem.exact = Eigen::VectorXd::Constant(1, P::exact(problem.end)[0]);
    problem.rate = [lambda](double t, const double* y, double* out) { *out = P{lambda}(P::State{*y}, t)[0]; };
    problem.jacobian = [lambda](double, const double*, double* J) { *J = lambda; };
    problem.by_time = [lambda](double t, double* slope) { *slope = lambda * std::sin(t) - std::cos(t); };
    all.push_back(problem);
  }
  all.push_back(detail::flow("Brusselator", Kind::smooth, Brusselator{}, Brusselator::start(), Brusselator::exact(),
                             Brusselator::end));
  const Kepler kepler;
  all.push_back(detail::motion<KeplerForce>("Kepler, e = 0.6, two periods", kepler.start().r, kepler.start().v,
                                            kepler.exact(2 * Kepler::period).r, kepler.exact(2 * Kepler::period).v,
                                            2 * Kepler::period, 1, 3.4e3));
  all.push_back(detail::motion<Pleiades>("Pleiades", Pleiades::positions(), Pleiades::velocities(),
                                         Pleiades::exact_positions(), Pleiades::exact_velocities(), Pleiades::end, 1,
                                         1.2e3));
  all.push_back(detail::motion<OuterSolarSystem>(
      "Outer solar system", OuterSolarSystem::positions(), OuterSolarSystem::velocities(),
      OuterSolarSystem::exact_positions(), OuterSolarSystem::exact_velocities(), OuterSolarSystem::end, 1e-2, 1.1e4));
  return all;
}

}  // namespace truth

/// @file
/// One problem: schemes picked by hand beside the automatic choice, at equal error.
#pragma once

#include <phistep/advise.hpp>
#include <phistep/automatic.hpp>
#include <phistep/phistep.hpp>
#include <phistep/schemes/radau/radau.hpp>
#include <phistep/schemes/rosenbrock.hpp>

#include <time.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "../stacked.hpp"
#include "rivals.hpp"

namespace automatic {

/// One rung of a ladder of tolerances.
struct Rung {
  double rtol = 0, error = INFINITY, seconds = INFINITY;
};
struct Ladder {
  std::string name;
  std::function<double(double rtol)> run;  ///< → the error at the end, infinite where it failed
  std::vector<Rung> rungs{};
};
struct Problem {
  std::string name;
  std::vector<Ladder> hand, rivals;
  Ladder automatic;
  std::function<std::string(double rtol)> advised, told;  ///< the scheme that advise names; what the automatic run took
  double tightest = 1e-13;
};
void measure(Problem problem);

[[nodiscard]] inline double now() {
  timespec t{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

using bench::stacked;

/// The problem on bare arrays.
template <class S, class F>
[[nodiscard]] BareProblem bare(const S& start, const F& force, double end, double a) {
  struct Self {
    F force;
    S y, out;
    phistep::PhiStepper<S, F, std::remove_const_t<decltype(phistep::tsit5)>> stepper;
  };
  const auto rate = [](void* user, double t, const double* from, double* to) {
    Self& self = *static_cast<Self*>(user);
    if constexpr (requires { self.force.rate(t, from, to); }) {
      self.force.rate(t, from, to);
    } else if constexpr (phistep::EigenDense<S> && std::is_invocable_v<F, const S&>) {
      std::copy(from, from + self.y.size(), self.y.data());
      typename S::MapType(to, self.y.size()) = self.force(self.y);
    } else if constexpr (phistep::EigenDense<S> && std::is_invocable_v<F, const S&, double>) {
      std::copy(from, from + self.y.size(), self.y.data());
      typename S::MapType(to, self.y.size()) = self.force(self.y, t);
    } else {  // motions and terms, as a stepper calls them
      phistep::for_each_number([&](std::size_t k, double& x) { x = from[k]; }, phistep::Blocks<S>::all(self.y));
      static_cast<void>(self.stepper.slope(t, self.y, self.out));
      phistep::for_each_number([&](std::size_t k, double& x) { to[k] = x; }, phistep::Blocks<S>::all(self.out));
    }
  };
  return {stacked(start), end, a, rate,
          std::make_shared<Self>(Self{force, start, start, {start, force, phistep::tsit5}})};
}

/// @param a      atol = a·rtol; errors are max |y_i − exact_i|/(|exact_i| + a)
/// @param samples  the components that `exact` holds; empty: all
template <class S, class F, class Mass = phistep::UnitMasses>
[[nodiscard]] Problem problem(const char* name, S start, F force, double end, Eigen::VectorXd exact, double a,
                              Mass mass = {}, std::vector<Eigen::Index> samples = {}) {
  using phistep::integrate, phistep::tolerance;
  const auto error_of_vector = [exact, a, samples](const Eigen::VectorXd& x) {
    double largest = 0;
    for (Eigen::Index k = 0; k < exact.size(); ++k) {
      const double is = x[samples.empty() ? k : samples[static_cast<std::size_t>(k)]];
      if (!std::isfinite(is)) return double{INFINITY};
      largest = std::max(largest, std::abs(is - exact[k]) / (std::abs(exact[k]) + a));
    }
    return largest;
  };
  const auto error = [error_of_vector](const S& y) { return error_of_vector(stacked(y)); };
  Problem all{name, {}, {}, {}, {}, {}};
  const auto by_hand = [&](const char* scheme_name, auto scheme) {
    all.hand.push_back({scheme_name, [=](double rtol) {
                          S y = start;
                          phistep::PhiStepper stepper{y, std::ref(force), scheme, mass};
                          const tolerance wanted{.rtol = rtol, .atol = a * rtol, .max_steps = 1'000'000};
                          return integrate(stepper, y, {0.0, end}, wanted) ? error(y) : double{INFINITY};
                        }});
  };
  using Rhs = typename phistep::SchemesFor<S, F, Mass>::Rhs;
  constexpr bool is_network = phistep::SchemesFor<S, F, Mass>::is_network;
  if constexpr (Rhs::drifts && !Rhs::couples_unknowns) {
    by_hand("rkn86", phistep::rkn86);
    by_hand("rkn1210", phistep::rkn1210);
  } else {
    by_hand("tsit5", phistep::tsit5);
    by_hand("dop853", phistep::dop853);
  }
  if constexpr (!is_network) {
    by_hand("rodas4", phistep::rodas4);
    by_hand("rodas4p2", phistep::rodas4p2);
    by_hand("rodas5p", phistep::rodas5p);
    by_hand("radau", phistep::radau);
  }
  by_hand("tr_bdf2", phistep::tr_bdf2);
  const auto run = [=](double rtol, S& y) {
    return integrate(y, force, mass, {0.0, end}, tolerance{.rtol = rtol, .atol = a * rtol, .max_steps = 1'000'000});
  };
  all.automatic = {"automatic", [=](double rtol) {
                     S y = start;
                     return run(rtol, y) ? error(y) : double{INFINITY};
                   }};
  all.told = [=](double rtol) {
    S y = start;
    return run(rtol, y).schemes.message();
  };
  all.advised = [=](double rtol) {
    return phistep::advise(start, force, {0.0, end}, tolerance{.rtol = rtol, .atol = a * rtol}, mass).scheme;
  };
  if constexpr (std::is_same_v<Mass, phistep::UnitMasses>)
    if (stacked(start).size() <= 100)
      for (auto& [rival, its_run] : rivals_of(bare(start, force, end, a)))
        all.rivals.push_back({rival, [error_of_vector, its_run = its_run](double rtol) {
                                const Eigen::VectorXd y = its_run(rtol);
                                return y.size() > 0 ? error_of_vector(y) : double{INFINITY};
                              }});
  return all;
}

// One file a group of problems.
void small_problems();
void van_der_pol();
void motions();
void fields();
void sets();

}  // namespace automatic

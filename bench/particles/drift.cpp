/// @file
/// Error and energy against CPU time over a ladder of Δt: φ = 0, ½, 1 and Verlet on seven argon atoms (Hairer, Lubich &
/// Wanner, Geometric Numerical Integration, I.4) over 0.02 ns.
#include <phistep/phistep.hpp>

#include <cmath>
#include <cstdio>
#include <limits>

#include "frontier.hpp"
#include "problems/argon.hpp"

namespace bench {
namespace {
using problems::Argon;
constexpr double end = 0.02;  // [ns]

template <class Scheme>
auto stepper_for(const Argon::State& y, Scheme scheme) {
  return phistep::PhiStepper{y, Argon{}, scheme, phistep::mass(Argon::mass)};
}

/// Position error relative to σ against `exact`; the largest |H − H₀|/k_B on the way [K].
template <class Scheme>
Rung judge(const std::string& name, Scheme scheme, int steps, const Argon::State& exact) {
  auto y = Argon::start();
  auto stepper = stepper_for(y, scheme);
  const double dt = end / steps, before = Argon::energy(y);
  double drift = 0;
  for (int n = 0; n < steps; ++n) {
    if (!stepper.step(y, n * dt, dt)) return {name, dt, std::numeric_limits<double>::infinity()};
    drift = std::max(drift, std::abs(Argon::energy(y) - before));
  }
  const double error = (y.r - exact.r).colwise().norm().maxCoeff() / Argon::sigma;
  Entrant entrant{name, [scheme, steps] {
                    const int repeats = std::max(1, 20000 / steps);
                    const Stopwatch watch;
                    for (int k = 0; k < repeats; ++k) {
                      auto again = Argon::start();
                      auto fresh = stepper_for(again, scheme);
                      static_cast<void>(phistep::integrate(fresh, again, {0, end}, phistep::fixed(end / steps)));
                    }
                    return watch.seconds() / repeats;
                  }};
  return {name, dt, error, drift, std::move(entrant)};
}
}  // namespace

void drift(const Options& options, Table& table) {
  // Verlet's error falls by 4 a halving: what it tends to.
  const auto verlet = [](int steps) {
    auto y = Argon::start();
    auto stepper = stepper_for(y, phistep::velocity_verlet);
    for (int n = 0; n < steps; ++n)
      if (!stepper.step(y, n * end / steps, end / steps)) throw std::runtime_error("the reference failed");
    return y;
  };
  const Argon::State coarse = verlet(200000), fine = verlet(400000);
  Argon::State exact = fine;
  exact.r += (fine.r - coarse.r) / 3;
  std::printf("  reference good to %.1e of sigma\n",
              (fine.r - coarse.r).colwise().norm().maxCoeff() / 3 / Argon::sigma);
  std::vector<Rung> rungs;
  const auto ladder = [&](const std::string& name, auto scheme, int from, int to) {
    for (int steps = from; steps <= (options.is_short ? from : to); steps *= 2) {
      Rung rung = judge(name, scheme, steps, exact);
      if (rung.error < 1) rungs.push_back(std::move(rung));
      else std::printf("    %-18s dt = %.2e ns: %s, not timed\n", name.c_str(), rung.dt, "no digit right");
    }
  };
  ladder("forward Euler", phistep::forward_euler, 4000, 256000);
  ladder("velocity Verlet", phistep::velocity_verlet, 250, 64000);
  ladder("trapezoidal", phistep::trapezoidal, 250, 64000);
  ladder("backward Euler", phistep::backward_euler, 1000, 64000);
  take_turns(rungs, options.rounds);
  write_rungs(options, "drift", "argon", rungs, true);
  for (const double wanted : {1e-2, 1e-3})
    for (const char* method : {"forward Euler", "velocity Verlet", "trapezoidal", "backward Euler"})
      if (const auto seconds = time_to(wanted, method, rungs))
        table.add({"drift", method, 7, 1, "time to error " + as_text(wanted),
                   "ms to an error of " + as_text(wanted) + " sigma", 1e3 * *seconds});
}

}  // namespace bench

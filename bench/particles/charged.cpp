/// @file
/// A drop of a charged Lennard-Jones fluid, the Coulomb forces of all pairs called once in 8 inner steps, beside the same at every
/// step, at the same error of the energy.
#include <phistep/phistep.hpp>

#include <phistep/particles.hpp>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numeric>
#include <stdexcept>
#include <string>
#include <vector>

#include "rows.hpp"
#include "scene.hpp"

namespace bench {
namespace {
using Drop = phistep::Particles<double, 3>;
constexpr double h = 0.004;  // [τ] inner step, and the step where all is called

auto bonds() { return phistep::Pairs{phistep::LennardJones{}.shifted(2.5), 2.5}; }
auto charges() { return phistep::AllPairs{phistep::Coulomb{.k = 1, .epsilon = 0.1}}; }

/// The n atoms of the melt's lattice nearest to a corner, at T = 0.7, in open space; every one has a charge of ±½, neighbours in
/// the list of opposite sign.
Drop cold_drop(Eigen::Index n) {
  const int cells = static_cast<int>(std::ceil(std::cbrt(static_cast<double>(n)) / 1.1)) + 2;
  const Scene melt = melt_start(cells, 0.8442, 0.7);
  const Eigen::Vector3d middle = Eigen::Vector3d::Constant(melt.side / 2);
  std::vector<Eigen::Index> order(static_cast<std::size_t>(melt.size()));
  std::iota(order.begin(), order.end(), 0);
  const auto distance = [&](Eigen::Index i) { return (melt.r.col(i) - middle).squaredNorm(); };
  std::nth_element(order.begin(), order.begin() + n, order.end(), [&](auto a, auto b) {
    return std::pair{distance(a), a} < std::pair{distance(b), b};
  });
  order.resize(static_cast<std::size_t>(n));
  std::sort(order.begin(), order.end());
  Eigen::Matrix3Xd r(3, n), v(3, n);
  Eigen::VectorXd q(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const Eigen::Index from = order[static_cast<std::size_t>(i)];
    r.col(i) = melt.r.col(from), v.col(i) = melt.v.col(from), q[i] = i % 2 == 0 ? 0.5 : -0.5;
  }
  v.colwise() -= v.rowwise().mean().eval();
  Drop drop{r, v};
  drop.set_charge(q);
  return drop;
}

struct Result {
  double seconds = 0;
  double error = 0;  ///< root mean square of E − its mean, of E's kinetic part
  double energy = 0;
  std::int64_t slow_calls = 0;
};
/// @param every  steps between two looks at the energy, which costs as much as a step: not in the time
Result run(const Drop& start, auto force, double dt, int steps, int every, int threads) {
  use_threads(threads);
  Drop y = start;
  phistep::PhiStepper stepper{y, std::move(force), phistep::velocity_verlet};
  Result result;
  std::vector<double> energies;
  double kinetic = 0;
  for (int n = 0; n < steps;) {
    const Stopwatch watch(threads);
    for (int k = 0; k < every && n < steps; ++k, ++n)
      if (const auto report = stepper.step(y, n * dt, dt); !report) throw std::runtime_error(report.message());
    result.seconds += watch.seconds();
    kinetic = y.v.squaredNorm() / 2;
    energies.push_back(kinetic + phistep::potential_energy(stepper, y));
  }
  const Eigen::Map<const Eigen::ArrayXd> E(energies.data(), static_cast<Eigen::Index>(energies.size()));
  result.energy = E.mean();
  result.error = std::sqrt((E - E.mean()).square().mean()) / kinetic;
  result.slow_calls = stepper.calls_by_term()[1];
  return result;
}
}  // namespace

void charged(const Options& options, Table& table) {
  const Eigen::Index n = options.is_short ? 300 : 5000;
  const int k = 8, outer = options.is_short ? 10 : 50;
  // The drop's lattice melts first.
  Drop drop = cold_drop(n);
  {
    phistep::PhiStepper stepper{drop, bonds() + phistep::seldom(k, charges()), phistep::velocity_verlet};
    for (int i = 0; i < (options.is_short ? 20 : 60); ++i)
      if (const auto report = stepper.step(drop, i * k * h, k * h); !report) throw std::runtime_error(report.message());
  }
  const Result all = run(drop, bonds() + charges(), h, k * outer, k, 1);
  const Result seldom = run(drop, bonds() + phistep::seldom(k, charges()), k * h, outer, 1, 1);
  std::printf(
      "  rms of the energy, of the kinetic: %.3e at every step, %.3e once in %d; Coulomb calls %lld and %lld; %.3f s "
      "and %.3f s\n",
      all.error, seldom.error, k, static_cast<long long>(all.slow_calls), static_cast<long long>(seldom.slow_calls),
      all.seconds, seldom.seconds);
  // An error of order 2: what the longer steps must be shortened by.
  const double shorter = std::max(1.0, std::sqrt(seldom.error / all.error));
  std::printf("  speed at equal error: %.2f\n", all.seconds / (seldom.seconds * shorter));
  std::vector<Entrant> entrants;
  for (int threads = 1; threads <= options.threads; threads *= 2) {
    entrants.push_back(
        {"Coulomb at every step",
         [&drop, outer, threads] { return run(drop, bonds() + charges(), h, 8 * outer, 8 * outer, threads).seconds; },
         threads});
    entrants.push_back(
        {"Coulomb once in 8 inner steps",
         [&drop, outer, threads] {
           return run(drop, bonds() + phistep::seldom(8, charges()), 8 * h, outer, outer, threads).seconds;
         },
         threads});
  }
  take_turns(entrants, options.rounds);
  table.rates("charged", n, static_cast<double>(n) * k * outer, "M atom-steps/s", entrants, {"Coulomb at every step"});
}

}  // namespace bench

#include "gravity.hpp"

#include <phistep/particles/bodies/particles.hpp>
#include <phistep/particles/pairs/all_pairs.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

#include "../../examples/plummer.hpp"
#include "rows.hpp"

namespace bench {
namespace {

/// The greatest error of 64 particles' accelerations relative to their size, against a sum in long double.
template <class Scalar>
double worst_error(const Cluster<Scalar>& c) {
  double worst = 0;
  for (std::size_t q = 0; q < 64; ++q) {
    const std::size_t i = q * c.n / 64;
    long double a[3] = {};
    for (std::size_t j = 0; j < c.n; ++j) {
      const long double d[3] = {static_cast<long double>(c.x[j]) - c.x[i], static_cast<long double>(c.y[j]) - c.y[i],
                                static_cast<long double>(c.z[j]) - c.z[i]};
      const long double r2 = d[0] * d[0] + d[1] * d[1] + d[2] * d[2] + static_cast<long double>(c.epsilon) * c.epsilon;
      for (int k = 0; k < 3; ++k) a[k] += c.m[j] * d[k] / (r2 * std::sqrt(r2));
    }
    const long double off = std::hypot(a[0] - c.ax[i], a[1] - c.ay[i], a[2] - c.az[i]);
    worst = std::max(worst, static_cast<double>(off / std::hypot(a[0], a[1], a[2])));
  }
  return worst;
}

template <class Scalar>
void gravity_of(const Options& options, Table& table, const std::string& row, std::size_t n) {
  using Stars = phistep::Particles<Scalar, 3>;
  const auto cluster = plummer_sphere(static_cast<Eigen::Index>(n));
  Cluster<Scalar> c(n);
  Stars stars{cluster.r.template cast<Scalar>()};
  stars.set_mass(cluster.mass());
  for (std::size_t i = 0; i < n; ++i) {
    const auto at = static_cast<Eigen::Index>(i);
    c.x[i] = stars.r(0, at), c.y[i] = stars.r(1, at), c.z[i] = stars.r(2, at), c.m[i] = stars.mass()[at];
  }
  phistep::AllPairs gravity{phistep::SoftenedGravity{1, c.epsilon}};
  auto by_lambda = phistep::all_pairs<phistep::PairWeight::mass>(
      [epsilon2 = c.epsilon * c.epsilon](auto r2) { return -phistep::rsqrt3(r2 + epsilon2); });
  auto out = phistep::make_rate<Stars>(stars);
  const auto masses = Stars::masses(stars);
  const auto call = [&](auto& force) {
    out.force.setZero();
    force.add(Scalar{0}, Stars::view(stars, masses), out);
  };
  // Each term is off by some eps, and the terms' sizes add up to a few times the force; sums of n terms add some √n eps.
  const double tolerance =
      (20 + std::sqrt(static_cast<double>(n))) * static_cast<double>(std::numeric_limits<Scalar>::epsilon());
  const auto check = [&](const std::string& who) {
    const double off = worst_error(c);
    if (!(off <= tolerance)) throw std::runtime_error(who + ": accelerations are off by " + std::to_string(off));
  };
  const auto check_ours = [&](auto& force, const std::string& who) {
    call(force);
    for (std::size_t i = 0; i < n; ++i) {
      const auto at = static_cast<Eigen::Index>(i);
      const Scalar mass = stars.mass()[at];
      c.ax[i] = out.force(0, at) / mass, c.ay[i] = out.force(1, at) / mass, c.az[i] = out.force(2, at) / mass;
    }
    check(who);
  };
  const int repeats = std::max(1, static_cast<int>(1e8 / (static_cast<double>(n) * static_cast<double>(n))));
  const auto timed = [repeats](int threads, auto&& work) {
    use_threads(threads);
    const Stopwatch watch(threads);
    for (int k = 0; k < repeats; ++k) work();
    return watch.seconds();
  };
  std::vector<Entrant> entrants;
  const auto kernels = gravity_by_hand<Scalar>();
  for (const auto& kernel : kernels) {
    kernel.run(c);
    check(kernel.name);
    entrants.push_back({kernel.name, [&timed, &kernel, &c] { return timed(1, [&] { kernel.run(c); }); }});
  }
  check_ours(gravity, "phistep");
  check_ours(by_lambda, "phistep, the user's own law");
  for (int threads = 1; threads <= options.threads; threads *= 2)
    entrants.push_back({"phistep", [&, threads] { return timed(threads, [&] { call(gravity); }); }, threads});
  entrants.push_back({"phistep, the user's own law", [&] { return timed(1, [&] { call(by_lambda); }); }});
  take_turns(entrants, options.rounds);
  std::size_t best = 0;
  for (std::size_t e = 0; e < kernels.size(); ++e)
    if (entrants[e].median() < entrants[best].median()) best = e;
  const double pairs = static_cast<double>(n) * static_cast<double>(n) * repeats / 1e3;
  table.rates(row, static_cast<long>(n), pairs, "G pairs/s", entrants, {entrants[best].name});
}

}  // namespace

/// Directed pairs, n² of them: a kernel that visits each pair once has done two. REBOUND does 0.15 G of them a second.
void gravity(const Options& options, Table& table) {
  const std::vector<std::size_t> sizes =
      options.is_short ? std::vector<std::size_t>{256} : std::vector<std::size_t>{1024, 4096, 16384};
  for (const std::size_t n : sizes) {
    gravity_of<double>(options, table, "gravity", n);
    gravity_of<float>(options, table, "gravity, float", n);
  }
}

}  // namespace bench

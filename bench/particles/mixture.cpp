/// @file
/// Kob and Andersen's mixture, A80B20 of Lennard-Jones with a cutoff of 2.5 σ_ab for each pair of types [W. Kob and
/// H. C. Andersen, Phys. Rev. E 51, 4626 (1995)]: the library's table of cutoffs beside one cutoff and a law that knows its
/// own, which was the way before, and beside LAMMPS.
#include <cmath>
#include <cstdio>
#include <random>
#include <stdexcept>

#include "lammps.hpp"
#include "melt_library.hpp"

namespace bench {
namespace {
using Atoms = phistep::Particles<double, 3>;
constexpr double dt = 0.004, density = 1.2, longest = 2.5;

struct PairOfTypes {
  double epsilon, sigma, cutoff;
};
constexpr PairOfTypes table[] = {{1, 1, 2.5}, {1.5, 0.8, 2.0}, {0.5, 0.88, 2.2}};  // AA, AB, BB

auto own_cutoffs() {
  std::vector<phistep::LennardJones> laws;
  std::vector<double> cutoffs;
  for (const int k : {0, 1, 1, 2})
    laws.push_back({table[k].epsilon, table[k].sigma}), cutoffs.push_back(table[k].cutoff);
  return phistep::ByType{laws, cutoffs};
}

/// By hand: what the pair is, chosen by the sum of both types.
struct HandLaw {
  static auto tag(const auto& body, auto i) { return body.type_of(i); }
  template <class T>
  static T of(T a, T b, auto&& value) {
    const T both = a + b;
    return select(both < T{0.5}, T{value(table[0])}, select(both < T{1.5}, T{value(table[1])}, T{value(table[2])}));
  }
  template <class T>
  T operator()(T r2, T a, T b) const {
    const T s2 = of(a, b, [](const PairOfTypes& p) { return p.sigma * p.sigma; });
    const T depth = of(a, b, [](const PairOfTypes& p) { return 24 * p.epsilon; });
    const T rc2 = of(a, b, [](const PairOfTypes& p) { return p.cutoff * p.cutoff; });
    const T u = s2 / r2, u3 = u * u * u;
    return select(r2 < rc2, depth * u3 * (2 * u3 - 1) / r2, T{0});
  }
};

void step(Atoms& atoms, auto& pairs, int steps) {
  phistep::PhiStepper stepper{atoms, std::ref(pairs), phistep::velocity_verlet};
  for (int n = 0; n < steps; ++n)
    if (const auto report = stepper.step(atoms, n * dt, dt); !report) throw std::runtime_error(report.message());
}

Atoms liquid(int cells) {
  const Scene scene = melt_start(cells, density, 2.0);
  Atoms atoms{scene.r, scene.v};
  std::mt19937 random(4626);
  atoms.set_type(
      Eigen::VectorXi(Eigen::VectorXi::NullaryExpr(scene.size(), [&] { return random() % 5 == 0 ? 1 : 0; })));
  atoms.set_box(phistep::Box<double, 3>::periodic(Eigen::Vector3d::Zero(), Eigen::Vector3d::Constant(scene.side)));
  phistep::Pairs pairs{own_cutoffs()};
  step(atoms, pairs, 400);  // from the crystal
  return atoms;
}

/// Σ V/N by a grid of cells.
double energy_of(const Atoms& atoms) {
  double sum = 0;
  for_each_pair(atoms.r, atoms.box().upper[0], longest, [&](Eigen::Index i, Eigen::Index j, const Eigen::Vector3d& d) {
    const PairOfTypes& p = table[atoms.type()[i] + atoms.type()[j]];
    const double r2 = d.squaredNorm(), s6 = std::pow(p.sigma * p.sigma / r2, 3);
    if (r2 < p.cutoff * p.cutoff) sum += 4 * p.epsilon * s6 * (s6 - 1);
  });
  return sum / static_cast<double>(atoms.size());
}

/// Seconds of `steps` steps after the first one, which makes the list.
double time_of(const Atoms& start, auto pairs, int steps, int threads = 1) {
  use_threads(threads);
  Atoms atoms = start;
  phistep::PhiStepper stepper{atoms, std::ref(pairs), phistep::velocity_verlet};
  double t = 0;
  const auto go = [&](int times) {
    for (int n = 0; n < times; ++n, t += dt)
      if (const auto report = stepper.step(atoms, t, dt); !report) throw std::runtime_error(report.message());
  };
  go(1);
  const Stopwatch watch(threads);
  go(steps);
  return watch.seconds();
}
}  // namespace

void mixture(const Options& options, Table& table_of_rates) {
  const int steps = 100;
  const Atoms start = liquid(options.is_short ? 6 : 20);
  Scene scene{start.box().upper[0], start.r, start.v, start.type()};
  // Answers first: the two ways from one start, and the energy by a grid.
  Atoms mine = start, by_hand = start;
  phistep::Pairs pairs{own_cutoffs()};
  phistep::Pairs hand{HandLaw{}, longest};
  step(mine, pairs, 10), step(by_hand, hand, 10);
  const double energy = pairs.energy(0.0, Atoms::view(mine, Atoms::masses(mine))) / static_cast<double>(mine.size());
  if (!((mine.r - by_hand.r).cwiseAbs().maxCoeff() < 1e-9) || !(std::abs(energy - energy_of(mine)) < 1e-9))
    throw std::runtime_error("the mixture's answers differ: nothing is timed");
  const auto per_atom = [&](const auto& p) {
    return static_cast<double>(p.pairs_listed()) / static_cast<double>(start.size());
  };
  std::printf("  neighbours listed an atom: own cutoffs %.1f, one cutoff %.1f\n", per_atom(pairs), per_atom(hand));

  std::vector<Entrant> entrants{
      {"phistep, own cutoffs", [&] { return time_of(start, phistep::Pairs{own_cutoffs()}, steps); }},
      {"phistep, one cutoff and a law by hand", [&] {
         return time_of(start, phistep::Pairs{HandLaw{}, longest}, steps);
       }}};
  const Lammps lammps{options};
  if (lammps.version()) {
    const std::string data = options.out + "/mixture.data";
    write_lammps(scene, data);
    const std::string deck = write_deck(options, "mixture.in", R"(units lj
atom_style atomic
read_data ${data}
pair_style lj/cut 2.5
pair_coeff 1 1 1.0 1.0 2.5
pair_coeff 1 2 1.5 0.8 2.0
pair_coeff 2 2 0.5 0.88 2.2
neighbor 0.3 bin
neigh_modify delay 0 every 1 check yes
fix 1 all nve
timestep 0.004
thermo ${steps}
run ${steps}
)");
    const auto run = [=, &lammps](bool opt) {
      return lammps.run(deck, {{"data", data}, {"steps", std::to_string(steps)}}, opt);
    };
    const double theirs = std::stod(run(false).thermo.at(0).at(2));  // Step Temp E_pair
    if (!(std::abs(theirs - energy_of(start)) < 1e-6))
      throw std::runtime_error("LAMMPS' energy differs: nothing is timed");
    entrants.push_back({"LAMMPS, checked, skin 0.3", [=] { return run(false).seconds; }});
    entrants.push_back({"LAMMPS opt, checked, skin 0.3", [=] { return run(true).seconds; }});
  }
  take_turns(entrants, options.rounds);
  table_of_rates.rates("mixture", start.size(), static_cast<double>(start.size()) * steps, "M atom-steps/s", entrants,
                       {"phistep, one cutoff and a law by hand", "LAMMPS opt, checked, skin 0.3"});
}

}  // namespace bench

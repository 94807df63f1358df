#include <cmath>
#include <cstdio>
#include <optional>
#include <stdexcept>

#include "lammps.hpp"
#include "melt_lammps.hpp"
#include "melt_library.hpp"

namespace bench {
namespace {
using phistep::PairOptions;

/// LAMMPS' own force law, as a user would write it.
constexpr auto users_law = [](auto r2) {
  const auto y = 1 / r2, y3 = y * y * y;
  return 48 * y * y3 * (y3 - 0.5);
};

/// Thermo lines beside each other: LAMMPS' as printed, ours in as many digits.
bool agrees(const std::vector<std::string>& theirs, const Thermo& ours, long step) {
  const double values[] = {ours.temperature, ours.pair_energy, ours.total_energy, ours.pressure};
  const std::size_t columns[] = {1, 2, 4, 5};  // Step Temp E_pair E_mol TotEng Press
  bool all = true;
  std::printf("  step %-4ld %-9s", step, "phistep");
  for (const double x : values) std::printf(" %14s", as_printed(x).c_str());
  std::printf("\n  %9s %-9s", "", "LAMMPS");
  for (std::size_t k = 0; k < 4; ++k) {
    std::printf(" %14s", theirs.at(columns[k]).c_str());
    all = all && as_printed(values[k]) == theirs[columns[k]];
  }
  std::printf("   %s\n", all ? "equal to the digits printed" : "DIFFERENT");
  return all;
}

/// How many pairs within the cutoff a list of the positions of `every` steps ago does not hold: those that were farther
/// apart than cutoff + skin then. Summed over the steps.
struct Missed {
  long pairs = 0, steps = 0;
};
Missed count_missed(const Scene& scene, int steps, int every, double skin) {
  LibraryMelt<double, phistep::LennardJones> melt{scene, {}, {.skin = skin}};
  Eigen::Matrix3Xd listed = melt.state().r;
  Missed missed;
  for (int n = 1; n <= steps; ++n) {
    melt.step(1);
    const Eigen::Matrix3Xd& r = melt.state().r;
    if (n % every == 0) listed = r;
    long here = 0;
    for_each_pair(r, scene.side, melt_cutoff, [&](Eigen::Index i, Eigen::Index j, const auto&) {
      const double range = melt_cutoff + skin;
      here += nearest(listed.col(j) - listed.col(i), scene.side).squaredNorm() >= range * range;
    });
    missed.pairs += here;
    missed.steps += here > 0;
  }
  return missed;
}
/// The same of phistep's own lists: pairs within the cutoff, by the grid and by the list.
long count_missed_by_ours(const Scene& scene, int steps, double skin) {
  LibraryMelt<double, phistep::LennardJones> melt{scene, {}, {.skin = skin}};
  long missed = 0;
  for (int n = 1; n <= steps; ++n) {
    melt.step(1);
    long inside = 0;
    for_each_pair(melt.state().r, scene.side, melt_cutoff, [&](auto, auto, const auto&) { ++inside; });
    missed += inside - static_cast<long>(melt.force().pairs_inside(melt.view()));
  }
  return missed;
}
}  // namespace

void melt(const Options& options, Table& table) {
  const int cells = options.is_short ? 6 : 20, steps = 100;
  const Scene scene = melt_start(cells);
  const std::string data = options.out + "/melt.data";
  write_lammps(scene, data);
  const Lammps lammps{options};
  const auto version = lammps.version();
  const MeltDeck deck{options, lammps, data, steps};
  // Answers first.
  const Thermo start = thermo_of(scene.r, scene.v, scene.side);
  LibraryMelt<double, phistep::LennardJones> own{scene, {}, {.skin = 0.3}};
  own.step(steps);
  const Thermo end = thermo_of(own.state().r, own.state().v, scene.side);
  if (version) {
    const LammpsRun run = deck.run(safe, 0.3, false);
    std::printf("  LAMMPS %s; temperature, pair energy, total energy, pressure:\n", version->c_str());
    const bool right = agrees(run.thermo.at(0), start, 0) & agrees(run.thermo.at(1), end, steps);
    if (!right) throw std::runtime_error("the melt's answers differ: nothing is timed");
    std::printf("  list builds in %d steps at skin 0.3: LAMMPS %ld, phistep %llu\n", steps, run.builds,
                static_cast<unsigned long long>(own.force().rebuilds() - 1));
  }
  const Missed missed = count_missed(scene, steps, 20, 0.3);
  const long missed_by_ours = count_missed_by_ours(scene, steps, 0.3);
  std::printf("  pairs missed in %d steps at skin 0.3: every 20 unchecked %ld (in %ld steps), phistep's list %ld\n",
              steps, missed.pairs, missed.steps, missed_by_ours);
  table.add({"melt", "missed by a list every 20, unchecked", scene.size(), 1, "missed pairs", "pairs",
             static_cast<double>(missed.pairs)});
  table.add({"melt", "missed by phistep's list", scene.size(), 1, "missed pairs", "pairs",
             static_cast<double>(missed_by_ours)});
  if (missed_by_ours != 0) throw std::runtime_error("phistep's list missed pairs");

  // Each side's own skin, by one run each.
  const auto best_skin = [&](auto&& seconds) {
    double best = 0.3, least = seconds(best);
    for (const double skin : {0.2, 0.25, 0.35, 0.4, 0.45, 0.5})
      if (const double now = seconds(skin); now < least) least = now, best = skin;
    return best;
  };
  const double our_skin = best_skin([&](double skin) { return time_melt(scene, steps, {.skin = skin}); });
  const double their_skin = version ? best_skin([&](double skin) { return deck.run(safe, skin, true).seconds; }) : 0.3;

  const auto ours = [&](const std::string& name, double skin, int unchecked_every = 0, int threads = 1) {
    return Entrant{name,
                   [&scene, steps, skin, unchecked_every, threads] {
                     return time_melt(scene, steps, {.skin = skin, .unchecked_every = unchecked_every}, threads);
                   },
                   threads};
  };
  const auto theirs = [&](const std::string& name, const Policy& policy, double skin, bool opt, int processes = 1) {
    return Entrant{name,
                   [&deck, policy, skin, opt, processes] { return deck.run(policy, skin, opt, processes).seconds; },
                   processes};
  };
  const std::string at_skin = ", skin ";
  std::vector<Entrant> entrants;
  if (version) {
    entrants.push_back(theirs("LAMMPS, checked, skin 0.3", safe, 0.3, false));
    entrants.push_back(theirs("LAMMPS opt, checked, skin 0.3", safe, 0.3, true));
    if (their_skin != 0.3)
      entrants.push_back(theirs("LAMMPS opt, checked, best skin " + as_text(their_skin), safe, their_skin, true));
    entrants.push_back(theirs("LAMMPS opt, delay 10, skin 0.3 (dangerous builds)", by_default, 0.3, true));
    entrants.push_back(theirs("LAMMPS, every 20 unchecked, skin 0.3", unchecked, 0.3, false));
    entrants.push_back(theirs("LAMMPS opt, every 20 unchecked, skin 0.3", unchecked, 0.3, true));
    if (options.threads > 1) entrants.push_back(theirs("LAMMPS opt, checked, skin 0.3", safe, 0.3, true, 2));
  }
  entrants.push_back(ours("phistep, checked, skin 0.3", 0.3));
  if (our_skin != 0.3) entrants.push_back(ours("phistep, checked, best skin " + as_text(our_skin), our_skin));
  entrants.push_back(ours("phistep, every 20 unchecked, skin 0.3", 0.3, 20));
  entrants.push_back({"phistep, checked, a lambda as law, skin " + as_text(our_skin),
                      [&] { return time_melt(scene, steps, {.skin = our_skin}, 1, users_law); }});
  entrants.push_back({"phistep, checked, float, skin " + as_text(our_skin),
                      [&] { return time_melt<float>(scene, steps, {.skin = our_skin}); }});
  for (int threads = 2; threads <= options.threads; threads *= 2) {
    // Wall time beside wall time: the same alone, once more.
    entrants.push_back(ours("phistep, checked, skin " + as_text(our_skin), our_skin, {}, threads));
  }
  take_turns(entrants, options.rounds);
  table.rates("melt", scene.size(), static_cast<double>(scene.size()) * steps, "M atom-steps/s", entrants,
              {"LAMMPS, checked, skin 0.3", "LAMMPS opt, checked, skin 0.3", "LAMMPS, every 20 unchecked, skin 0.3",
               "LAMMPS opt, every 20 unchecked, skin 0.3"});
}

}  // namespace bench

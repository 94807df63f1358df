/// @file
/// Grains that flow down a chute: LAMMPS' bench/in.chute, 32,000 spheres on a rough base, Hookean contacts with tangential
/// history. Its data file is not part of phistep: --chute FILE.
///
/// LAMMPS' `fix nve/sphere` is velocity Verlet whose dashpots see the velocity of half a step before. With v there, that is
/// symplectic Euler: v⁺ = v + Δt M⁻¹Ψ(t, r, v), r⁺ = r + Δt v⁺, so that is what is timed; what LAMMPS prints of a step is
/// the mean of the two velocities around it.
#include <phistep/phistep.hpp>

#include <phistep/particles/bodies/particles.hpp>
#include <phistep/particles/contacts/contact.hpp>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <optional>
#include <stdexcept>

#include "../../adapters/lammps/read_data.hpp"
#include "lammps.hpp"
#include "process.hpp"

namespace bench {
namespace {
using Grains = phistep::Particles<double, 3, phistep::Spin>;
constexpr double dt = 1e-4;

const char* const deck = R"(units lj
atom_style sphere
boundary p p fs
newton off
comm_modify vel yes
read_data ${data}
pair_style gran/hooke/history 200000.0 NULL 50.0 NULL 0.5 0
pair_coeff * *
neighbor ${skin} bin
neigh_modify delay 0 every 1
timestep 0.0001
group bottom type 2
group active subtract all bottom
neigh_modify exclude group bottom bottom
fix 1 all gravity 1.0 chute 26.0
fix 2 bottom freeze
fix 3 active nve/sphere
compute 1 all erotate/sphere
thermo_style custom step atoms ke c_1 vol
thermo_modify norm no
thermo ${steps}
run ${steps}
)";

Grains read(const std::string& path) {
  Grains grains = phistep::read_lammps_data<Grains>(path, {.style = "sphere", .periodic = {true, true, false}}).atoms;
  std::vector<std::uint8_t> base(static_cast<std::size_t>(grains.size()));
  for (Eigen::Index i = 0; i < grains.size(); ++i) base[static_cast<std::size_t>(i)] = grains.type()[i] == 1;
  grains.set_still(std::move(base));
  return grains;
}

using Contact = phistep::Contact<phistep::GranHooke>;

auto make_stepper(const Grains& grains, Contact& contact) {
  const double slope = 26 * std::acos(-1.0) / 180;
  return phistep::PhiStepper{
      grains,
      phistep::Gravity{Eigen::Vector3d{std::sin(slope), 0, -std::cos(slope)}} + phistep::term(std::ref(contact)),
      phistep::symplectic_euler};
}

class Chute {
 public:
  Chute(const Grains& start, double skin)
      : state_{start},
        contact_{phistep::GranHooke{.stiffness = 2e5,
                                    .tangential_stiffness = 2e5 * 2 / 7,
                                    .damping = 50,
                                    .tangential_damping = 0,
                                    .friction = 0.5},
                 skin},
        stepper_{make_stepper(state_, contact_)} {}
  Chute(const Chute&) = delete;  // the stepper refers to the force
  Chute& operator=(const Chute&) = delete;

  void step(int times) {
    for (int n = 0; n < times; ++n)
      if (const auto report = stepper_.step(state_, dt * done_++, dt); !report)
        throw std::runtime_error(report.message());
  }
  [[nodiscard]] const Grains& state() const { return state_; }
  [[nodiscard]] const phistep::ContactStatistics& statistics() const { return contact_.statistics(); }

 private:
  Grains state_;
  Contact contact_;
  decltype(make_stepper(std::declval<const Grains&>(), std::declval<Contact&>())) stepper_;
  int done_ = 0;
};

/// Velocities half a step earlier: v − ½Δt Ψ/m, from one step.
Grains half_a_step_before(const Grains& start) {
  Chute chute{start, 0.1};
  chute.step(1);
  Grains before = start;
  before.v -= (chute.state().v - start.v) / 2;
  before.omega -= (chute.state().omega - start.omega) / 2;
  return before;
}

/// ½ Σ m v² and ½ Σ I ω² with the mean of two velocities.
std::pair<double, double> energies(const Grains& a, const Grains& b) {
  const auto m = a.mass().array();
  const Eigen::Matrix3Xd v = (a.v + b.v) / 2, omega = (a.omega + b.omega) / 2;
  return {0.5 * (m * v.colwise().squaredNorm().transpose().array()).sum(),
          0.5 * (0.4 * m * a.radius().array().square() * omega.colwise().squaredNorm().transpose().array()).sum()};
}

double time_chute(const Grains& start, int steps, double skin, int threads) {
  use_threads(threads);
  Chute chute{start, skin};
  chute.step(1);  // the first search is set-up, as with LAMMPS
  const Stopwatch watch(threads);
  chute.step(steps);
  return watch.seconds();
}
}  // namespace

void grains(const Options& options, Table& table) {
  if (options.chute.empty() || !std::filesystem::exists(options.chute)) {
    std::printf("  skipped: no data file (--chute data.chute[.gz], of LAMMPS' bench folder)\n");
    return;
  }
  const int steps = options.is_short ? 20 : 100;
  const std::string data = options.out + "/chute.data";
  if (run_program("gzip -dcf " + quoted(options.chute) + " > " + quoted(data)).status != 0)
    throw std::runtime_error("cannot read " + options.chute);
  const Grains start = half_a_step_before(read(data));
  const double n = static_cast<double>(start.size());

  // Answers first.
  Chute chute{start, 0.1};
  chute.step(steps);
  const auto contacts = chute.statistics();
  const Grains before = chute.state();
  chute.step(1);
  const auto [kinetic, rotation] = energies(before, chute.state());
  const Lammps lammps{options};
  const auto version = lammps.version();
  const std::string path = write_deck(options, "chute.in", deck);
  const auto run = [&](double skin, int processes) {
    return lammps.run(path, {{"data", data}, {"skin", as_text(skin)}, {"steps", std::to_string(steps)}}, false,
                      processes);
  };
  if (version) {
    const LammpsRun theirs = run(0.1, 1);
    const auto& line = theirs.thermo.at(1);  // Step Atoms KinEng c_1 Volume
    const double their_kinetic = std::strtod(line.at(2).c_str(), nullptr);
    const double their_rotation = std::strtod(line.at(3).c_str(), nullptr);
    std::printf("  after %d steps, of translation and of rotation: phistep %s %s, LAMMPS %s %s\n", steps,
                as_printed(kinetic).c_str(), as_printed(rotation).c_str(), line[2].c_str(), line[3].c_str());
    std::printf("  searches: LAMMPS %ld, phistep %lld; contacts %lld of %lld pairs\n", theirs.builds,
                static_cast<long long>(contacts.rebuilds - 1), static_cast<long long>(contacts.touching),
                static_cast<long long>(contacts.pairs));
    // Not the same arithmetic, and the first dashpot sees another velocity.
    if (!(std::abs(kinetic / their_kinetic - 1) < 1e-7) || !(std::abs(rotation / their_rotation - 1) < 1e-4))
      throw std::runtime_error("the grains' energies differ: nothing is timed");
  }
  double skin = 0.1, least = time_chute(start, steps, skin, 1);
  for (const double other : {0.05, 0.15, 0.2, 0.3})
    if (const double seconds = time_chute(start, steps, other, 1); seconds < least) least = seconds, skin = other;

  std::vector<Entrant> entrants;
  if (version) {
    entrants.push_back({"LAMMPS, skin 0.1", [&] { return run(0.1, 1).seconds; }});
    if (options.threads > 1) entrants.push_back({"LAMMPS, skin 0.1", [&] { return run(0.1, 2).seconds; }, 2});
  }
  entrants.push_back({"phistep, skin 0.1", [&] { return time_chute(start, steps, 0.1, 1); }});
  for (int threads = 1; threads <= options.threads; threads *= 2)
    if (skin != 0.1 || threads > 1)
      entrants.push_back({"phistep, best skin " + as_text(skin),
                          [&, threads] { return time_chute(start, steps, skin, threads); }, threads});
  take_turns(entrants, options.rounds);
  table.rates("grains", start.size(), n * steps, "M grain-steps/s", entrants, {"LAMMPS, skin 0.1"});
}

}  // namespace bench

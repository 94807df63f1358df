/// @file
/// A plugin for LAMMPS: `fix ID group phi STYLE` steps LAMMPS' own arrays by phistep's schemes. LAMMPS computes the forces,
/// moves atoms between ranks, keeps restart files and writes output, as under `fix nve`.
///
///     plugin load phistep_lammps.so
///     fix 1 all phi verlet                  velocity Verlet: in place of fix nve, with its bits
///     fix 1 all phi sphere                  the same with spin: in place of fix nve/sphere
///     fix 1 all phi symplectic_euler
///     fix 1 all phi 0.5 rtol 1e-10          the φ-method, here φ = ½; without rtol its equations are solved to rounding
///
/// A step of LAMMPS asks for one before the forces, r and v at t, and one after them, v at t + Δt. So Verlet is done in halves,
///
///     v½ = v + ½Δt M⁻¹Ψ(t),   r⁺ = r + Δt v½       before
///     v⁺ = v½ + ½Δt M⁻¹Ψ(t + Δt)                    after
///
/// each a step of one pass over the arrays in place, which sends and reduces nothing. The φ-method is done before, with forces at
/// trial positions, all that run_style verlet calls between two steps: f_ID[1] and f_ID[2] in thermo output count these calls, and
/// iterations. Where a number is no longer finite, or the iteration doesn't converge, the run ends with a message.
#include <cstdio>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>

#include "atom.h"
#include "error.h"
#include "explicit.hpp"
#include "fix.h"
#include "force.h"
#include "group.h"
#include "implicit.hpp"
#include "lammps.h"
#include "lammps_plugin.hpp"
#include "update.h"
#include "utils.h"

namespace {
class FixPhi final : public LAMMPS_NS::Fix {
 public:
  FixPhi(LAMMPS_NS::LAMMPS* lammps, int argc, char** argv) : Fix{lammps, argc, argv} {
    const std::string scheme = argc > 3 ? argv[3] : "";
    spins_ = scheme == "sphere";
    is_whole_ = scheme == "symplectic_euler";
    if (!spins_ && !is_whole_ && scheme != "verlet") {
      const double phi = LAMMPS_NS::utils::is_double(scheme) ? std::stod(scheme) : -1;
      double rtol = 0;
      if (argc == 6 && std::string{argv[4]} == "rtol") rtol = LAMMPS_NS::utils::numeric(FLERR, argv[5], false, lammps);
      else if (argc != 4) error->all(FLERR, "fix phi: after φ comes nothing, or rtol and a number");
      if (!(phi > 0 && phi <= 1) || !(rtol >= 0 && rtol < 1))
        error->all(FLERR, "fix phi: expected one of verlet, sphere, symplectic_euler, or 0 < φ <= 1 and 0 <= rtol < 1");
      implicit_.emplace(phi, rtol);
      phi_ = scheme;
    } else if (argc != 4) {
      error->all(FLERR, "fix phi {}: nothing is expected after it", scheme);
    }
    if (spins_ && (atom->omega_flag == 0 || atom->torque_flag == 0 || atom->radius_flag == 0))
      error->all(FLERR, "fix phi sphere needs an atom_style with radius, omega and torque");
    time_integrate = 1;
    dynamic_group_allow = 1;
    vector_flag = 1, size_vector = 2, global_freq = 1, extvector = 0;
  }
  void init() override {
    if (LAMMPS_NS::utils::strmatch(update->integrate_style, "^respa"))
      error->all(FLERR, "fix phi needs run_style verlet");
    if (!implicit_) return;
    if (const std::string why = phistep_lammps::refused(lmp); !why.empty())
      error->all(FLERR, "fix phi {}: {}; take `fix phi verlet` or `sphere`", phi_, why);
    implicit_->forget();
  }
  /// After LAMMPS has moved atoms between ranks.
  void pre_neighbor() override {
    if (implicit_) implicit_->forget();
  }
  /// Calls of the forces beside LAMMPS' own; iterations.
  double compute_vector(int k) override {
    if (!implicit_) return 0;
    return static_cast<double>(k == 0 ? implicit_->calls() : implicit_->iterations());
  }
  int setmask() override {
    using namespace LAMMPS_NS::FixConst;
    if (implicit_) return INITIAL_INTEGRATE | PRE_NEIGHBOR;
    return is_whole_ ? INITIAL_INTEGRATE : INITIAL_INTEGRATE | FINAL_INTEGRATE;
  }
  void initial_integrate(int) override {
    const auto [t, dt] = begin();
    if (implicit_) {
      if (group->dynamic[igroup] != 0) implicit_->forget();  // other atoms, at any step
      const std::string fault = implicit_->step(lmp, movers_, world, t, dt);
      if (!fault.empty()) error->all(FLERR, "fix phi: " + fault);
      return;
    }
    if (is_whole_) return end(whole_.step(movers_, t, dt, atom->x, atom->v, atom->f));
    end(first_.step(movers_, t, dt, atom->x, atom->v, atom->f));
    if (spins_) end(spin_.step(movers_, t, dt / 2, atom->omega, atom->torque));
  }
  void final_integrate() override {
    const auto [t, dt] = begin();
    end(last_.step(movers_, t, dt / 2, atom->v, atom->f));
    if (spins_) end(spin_.step(movers_, t, dt / 2, atom->omega, atom->torque));
  }

 private:
  /// @return t, Δt
  std::pair<double, double> begin() {
    movers_.atom = atom;
    movers_.ftm2v = force->ftm2v;
    movers_.find(groupbit);
    return {static_cast<double>(update->ntimestep) * update->dt, update->dt};
  }
  void end(const std::string& fault) {
    if (fault.empty()) return;
    // This rank ends all of them at once, and what it has not written by then may be lost: its own words come first.
    std::fprintf(stderr, "fix phi: %s\n", fault.c_str());
    std::fflush(nullptr);
    error->one(FLERR, "fix phi: " + fault);
  }

  bool spins_ = false, is_whole_ = false;
  std::string phi_;
  phistep_lammps::Movers movers_;
  phistep_lammps::Motions<std::remove_cvref_t<decltype(phistep::symplectic_euler)>> whole_;
  phistep_lammps::Motions<phistep_lammps::FirstHalf> first_;
  phistep_lammps::Kicks<false> last_;
  phistep_lammps::Kicks<true> spin_;
  std::optional<phistep_lammps::Implicit> implicit_;
};
}  // namespace

extern "C" void lammpsplugin_init(void* lammps, void* handle, void* register_style) {
  lammpsplugin_t fix{};
  fix.version = static_cast<LAMMPS_NS::LAMMPS*>(lammps)->version;
  fix.style = "fix", fix.name = "phi", fix.info = "phistep's schemes for LAMMPS", fix.author = "phistep";
  fix.creator.v2 = [](void* of, int argc, char** argv) -> void* {
    return new FixPhi{static_cast<LAMMPS_NS::LAMMPS*>(of), argc, argv};
  };
  fix.handle = handle;
  reinterpret_cast<lammpsplugin_regfunc*>(register_style)(&fix, lammps);
}

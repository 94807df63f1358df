/// @file
/// A plugin for LAMMPS: `fix ID group phi STYLE` steps LAMMPS' own arrays by phistep's schemes. LAMMPS computes the forces,
/// moves atoms between ranks, keeps restart files and writes output, as under `fix nve`.
///
///     plugin load phistep_lammps.so
///     fix 1 all phi verlet                  velocity Verlet: in place of fix nve, with its bits
///     fix 1 all phi sphere                  the same with spin: in place of fix nve/sphere
///     fix 1 all phi symplectic_euler
///
/// A step of LAMMPS asks for one before the forces, r and v at t, and one after them, v at t + Δt. So Verlet is done in halves,
///
///     v½ = v + ½Δt M⁻¹Ψ(t),   r⁺ = r + Δt v½       before
///     v⁺ = v½ + ½Δt M⁻¹Ψ(t + Δt)                    after
///
/// each a step of one pass over the arrays in place. Nothing is sent or reduced. Where a number is no longer finite the run
/// ends, and the message names the atom.
#include <algorithm>
#include <cstddef>
#include <memory>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include <phistep/in_place.hpp>

#include "atom.h"
#include "error.h"
#include "fix.h"
#include "force.h"
#include "lammps.h"
#include "lammps_plugin.hpp"
#include "update.h"
#include "utils.h"

namespace {
using LAMMPS_NS::Atom;
using LAMMPS_NS::Fix;

/// Verlet's first half: v½ = v + ½Δt M⁻¹Ψ(t), r⁺ = r + Δt v½. Its second half is forward Euler's v⁺ = v½ + ½Δt M⁻¹Ψ.
struct FirstHalf {
  static constexpr phistep::SchemeFacts facts{.motion_only = true,
                                              .is_explicit = true,
                                              .is_symplectic = true,
                                              .is_a_stable = false,
                                              .is_l_stable = false,
                                              .energy = phistep::EnergyBalance::rest};
  static constexpr const char* name() { return "velocity Verlet, its first half"; }
  static constexpr int order() { return 1; }
};
}  // namespace

template <phistep::State S>
class phistep::SchemeOn<FirstHalf, S> : public phistep::SchemeDefaults {
 public:
  template <class Rhs>
  static constexpr phistep::KernelNeeds needs{.passes = 1};
  SchemeOn(FirstHalf, const auto& /*y*/) {}
  static int order() { return FirstHalf::order(); }
  static phistep::Outcome step(auto& kernel, auto& step) {
    return kernel.kick_drift(step, phistep::Advance{step.dt / 2, phistep::Zero{}, step.dt});
  }
};

namespace {
/// The atoms of this rank that the fix moves.
struct Movers {
  const Atom* atom = nullptr;
  double ftm2v = 1;       // force × ftm2v = mass × velocity per time
  std::vector<int> some;  // their indices, where the group isn't all
  bool is_all = true;

  void find(int groupbit) {
    const int n = atom->nlocal;
    is_all = std::all_of(atom->mask, atom->mask + n, [groupbit](int mask) { return (mask & groupbit) != 0; });
    some.clear();
    if (is_all) return;
    for (int i = 0; i < n; ++i)
      if ((atom->mask[i] & groupbit) != 0) some.push_back(i);
  }
  [[nodiscard]] std::ptrdiff_t size() const { return is_all ? atom->nlocal : static_cast<std::ptrdiff_t>(some.size()); }
  [[nodiscard]] std::ptrdiff_t index(std::ptrdiff_t k) const {
    return is_all ? k : some[static_cast<std::size_t>(k)];
  }
};

/// i ↦ h/m_i of components.
struct InverseInertia {
  const double* all;
  double operator()(std::ptrdiff_t component) const { return all[component]; }
  auto operator()(phistep::PacketIndex components) const { return phistep::Packet<double>::load(all + components.first); }
};
/// The masses, or moments of inertia 2/5 m r², that LAMMPS' arrays hold now.
template <bool spins>
class Inertia {
 public:
  static constexpr phistep::Structure structure = phistep::Structure::diagonal;
  static constexpr bool is_matrix = false;

  explicit Inertia(const Movers& movers) : movers_{&movers} {}
  template <class Scalar, class Block>
  [[nodiscard]] Inertia bind(const Block& /*block*/) const {
    return *this;
  }
  /// Divided as LAMMPS does.
  [[nodiscard]] InverseInertia scaled(double h) const {
    const auto n = static_cast<std::size_t>(movers_->size());
    const Atom& atom = *movers_->atom;
    inverse_.resize(3 * n);
    const double by = spins ? h * movers_->ftm2v / 0.4 : h * movers_->ftm2v;
    for (std::size_t k = 0; k < n; ++k) {
      const std::ptrdiff_t i = movers_->index(static_cast<std::ptrdiff_t>(k));
      double each = 0;
      if constexpr (spins) each = by / (atom.radius[i] * atom.radius[i] * atom.rmass[i]);
      else each = by / (atom.rmass != nullptr ? atom.rmass[i] : atom.mass[atom.type[i]]);
      inverse_[3 * k] = inverse_[3 * k + 1] = inverse_[3 * k + 2] = each;
    }
    return {inverse_.data()};
  }
  [[nodiscard]] double operator[](std::ptrdiff_t component) const {
    const std::ptrdiff_t i = movers_->index(component / 3);
    const Atom& atom = *movers_->atom;
    const double m = atom.rmass != nullptr ? atom.rmass[i] : atom.mass[atom.type[i]];
    return (spins ? 0.4 * atom.radius[i] * atom.radius[i] * m : m) / movers_->ftm2v;
  }
  void subtract_product(const auto& x, auto&& out) const {
    for (std::ptrdiff_t i = 0; i < x.size(); ++i) out[i] -= (*this)[i] * x[i];
  }
  void add_product(auto&& x, auto& out) const {
    for (std::ptrdiff_t i = 0; i < out.size(); ++i) out.data()[i] += (*this)[i] * x(i);
  }
  void for_each_entry(std::ptrdiff_t n, auto&& f) const {
    for (std::ptrdiff_t i = 0; i < n; ++i) f(i, i, (*this)[i]);
  }

 private:
  const Movers* movers_;
  mutable std::vector<double> inverse_;
};
}  // namespace
template <bool spins>
struct phistep::MassKind<Inertia<spins>> {
  using type = Inertia<spins>;
  static type make(const type& all) { return all; }
};

namespace {
/// An array of LAMMPS, three numbers an atom: itself, or of a part of its atoms a copy.
class Rows {
 public:
  [[nodiscard]] auto take(const Movers& movers, double** all) {
    first_ = all[0];
    const std::ptrdiff_t n = movers.size();
    if (movers.is_all) return phistep::places<3>(first_, n, std::ptrdiff_t{3});
    copy_.resize(static_cast<std::size_t>(3 * n));
    for (std::ptrdiff_t k = 0; k < n; ++k) std::copy_n(first_ + 3 * movers.index(k), 3, copy_.data() + 3 * k);
    return phistep::places<3>(copy_.data(), n, std::ptrdiff_t{3});
  }
  void give(const Movers& movers) {
    if (movers.is_all) return;
    for (std::ptrdiff_t k = 0; k < movers.size(); ++k)
      std::copy_n(copy_.data() + 3 * k, 3, first_ + 3 * movers.index(k));
  }

 private:
  double* first_ = nullptr;
  std::vector<double> copy_;
};
using Places = decltype(std::declval<Rows&>().take(std::declval<const Movers&>(), nullptr));
struct AlreadyThere {  // LAMMPS has computed the forces
  void operator()() const {}
};

/// Positions and velocities under a scheme.
template <class Scheme>
class Motions {
  using State = phistep::MotionInPlace<Places, Places, Places>;
  using Force = decltype(std::declval<State&>().force_of_r(AlreadyThere{}));
  using Stepper = phistep::PhiStepper<State, Force, Scheme, phistep::MassList<Inertia<false>>>;

 public:
  /// @return why the step failed; empty: it is done
  std::string step(const Movers& movers, double t, double dt) {
    const Atom& atom = *movers.atom;
    if (movers.size() == 0) return {};
    const Places r = r_.take(movers, atom.x), v = v_.take(movers, atom.v), f = f_.take(movers, atom.f);
    if (stepper_) state_->point_at(r, v, f);
    else {
      state_ = std::make_unique<State>(r, v, f);
      stepper_ = std::make_unique<Stepper>(*state_, state_->force_of_r(AlreadyThere{}), Scheme{},
                                           phistep::mass(Inertia<false>{movers}));
    }
    const auto report = stepper_->step(*state_, t, dt);
    r_.give(movers), v_.give(movers);
    return report ? std::string{} : report.message();
  }

 private:
  Rows r_, v_, f_;
  std::unique_ptr<State> state_;
  std::unique_ptr<Stepper> stepper_;
};

/// Velocities under forces alone, angular ones under torques: forward Euler.
template <bool spins>
class Kicks {
  using State = phistep::VectorInPlace<Places, Places>;
  using Force = decltype(std::declval<State&>().force(AlreadyThere{}));
  using Stepper = phistep::PhiStepper<State, Force, std::remove_cvref_t<decltype(phistep::forward_euler)>,
                                      phistep::MassList<Inertia<spins>>>;

 public:
  /// @return why the step failed; empty: it is done
  std::string step(const Movers& movers, double t, double dt) {
    const Atom& atom = *movers.atom;
    if (movers.size() == 0) return {};
    const Places v = v_.take(movers, spins ? atom.omega : atom.v), f = f_.take(movers, spins ? atom.torque : atom.f);
    if (stepper_) state_->point_at(v, f);
    else {
      state_ = std::make_unique<State>(v, f);
      stepper_ = std::make_unique<Stepper>(*state_, state_->force(AlreadyThere{}), phistep::forward_euler,
                                           phistep::mass(Inertia<spins>{movers}));
    }
    const auto report = stepper_->step(*state_, t, dt);
    v_.give(movers);
    return report ? std::string{} : report.message();
  }

 private:
  Rows v_, f_;
  std::unique_ptr<State> state_;
  std::unique_ptr<Stepper> stepper_;
};

class FixPhi final : public Fix {
 public:
  FixPhi(LAMMPS_NS::LAMMPS* lammps, int argc, char** argv) : Fix{lammps, argc, argv} {
    const std::string scheme = argc == 4 ? argv[3] : "";
    spins_ = scheme == "sphere";
    is_whole_ = scheme == "symplectic_euler";
    if (!spins_ && !is_whole_ && scheme != "verlet")
      error->all(FLERR, "fix phi: one of verlet, sphere, symplectic_euler is expected after its name");
    if (spins_ && (atom->omega == nullptr || atom->torque == nullptr || atom->radius == nullptr))
      error->all(FLERR, "fix phi sphere needs an atom_style with radius, omega and torque");
    time_integrate = 1;
    dynamic_group_allow = 1;
  }
  int setmask() override {
    using namespace LAMMPS_NS::FixConst;
    return is_whole_ ? INITIAL_INTEGRATE : INITIAL_INTEGRATE | FINAL_INTEGRATE;
  }
  void initial_integrate(int) override {
    const auto [t, dt] = begin();
    if (is_whole_) return end(whole_.step(movers_, t, dt));
    end(first_.step(movers_, t, dt));
    if (spins_) end(spin_.step(movers_, t, dt / 2));
  }
  void final_integrate() override {
    const auto [t, dt] = begin();
    end(last_.step(movers_, t, dt / 2));
    if (spins_) end(spin_.step(movers_, t, dt / 2));
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
    if (!fault.empty()) error->one(FLERR, "fix phi: " + fault);
  }

  bool spins_ = false, is_whole_ = false;
  Movers movers_;
  Motions<std::remove_cvref_t<decltype(phistep::symplectic_euler)>> whole_;
  Motions<FirstHalf> first_;
  Kicks<false> last_;
  Kicks<true> spin_;
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

/// @file
/// Explicit steps, in place, around the one call of the forces that LAMMPS does.
#pragma once

#include <memory>
#include <string>
#include <type_traits>
#include <utility>

#include <phistep/in_place.hpp>

#include "atoms.hpp"

namespace phistep_lammps {
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
}  // namespace phistep_lammps

template <phistep::State S>
class phistep::SchemeOn<phistep_lammps::FirstHalf, S> : public phistep::SchemeDefaults {
 public:
  template <class Rhs>
  static constexpr phistep::KernelNeeds needs{.passes = 1};
  SchemeOn(phistep_lammps::FirstHalf, const auto& /*y*/) {}
  static int order() { return phistep_lammps::FirstHalf::order(); }
  static phistep::Outcome step(auto& kernel, auto& step) {
    return kernel.kick_drift(step, phistep::Advance{step.dt / 2, phistep::Zero{}, step.dt});
  }
};

namespace phistep_lammps {
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
}  // namespace phistep_lammps

/// @file
/// Explicit steps, in place, around the one call of the forces that LAMMPS does.
#pragma once

#include <array>
#include <cstddef>
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
  static phistep::Outcome step(auto& eq) {
    return eq.kick_drift(phistep::Advance{eq.dt / 2, phistep::Zero{}, eq.dt});
  }
};

namespace phistep_lammps {
struct AlreadyThere {  // LAMMPS has computed the forces
  void operator()() const {}
};

/// One step over arrays of LAMMPS in place: the blocks of a state, and their forces.
template <class State, class Scheme, bool spins>
class ArraysStep {
  static auto force_of(State& state) {
    if constexpr (State::drifts) return state.force_of_r(AlreadyThere{});
    else return state.force(AlreadyThere{});
  }
  using Stepper = phistep::PhiStepper<State, decltype(force_of(std::declval<State&>())), std::remove_cvref_t<Scheme>,
                                      phistep::MassList<Inertia<spins>>>;

 public:
  /// @param arrays  of the state's blocks, and of their forces
  /// @return why the step failed; empty: it is done
  std::string step(const Movers& movers, double t, double dt, auto... arrays) {
    if (movers.size() == 0) return {};
    const auto places = [&]<std::size_t... k>(std::index_sequence<k...>, auto&& use) {
      use(rows_[k].take(movers, arrays)...);
    };
    places(std::index_sequence_for<decltype(arrays)...>{}, [&](const auto&... at) {
      if (stepper_) return state_->point_at(at...);
      state_ = std::make_unique<State>(at...);
      stepper_ = std::make_unique<Stepper>(*state_, force_of(*state_), std::remove_cvref_t<Scheme>{},
                                           phistep::mass(Inertia<spins>{movers}));
    });
    const auto report = stepper_->step(*state_, t, dt);
    for (std::size_t k = 0; k + 1 < sizeof...(arrays); ++k) rows_[k].give(movers);  // but the forces
    if (report) return {};
    // LAMMPS' name of the atom, where the arrays' order means nothing to its users.
    phistep::Failure failure = report.failure();
    if (failure.column < 0) return failure.message();
    const auto tag = movers.atom->tag[movers.index(static_cast<std::ptrdiff_t>(failure.column))];
    failure.index = failure.column = -1;
    return "atom " + std::to_string(tag) + "; " + failure.message();
  }

 private:
  std::array<Rows, 3> rows_;
  std::unique_ptr<State> state_;
  std::unique_ptr<Stepper> stepper_;
};
/// Positions and velocities under a scheme.
template <class Scheme>
using Motions = ArraysStep<phistep::MotionInPlace<Places, Places, Places>, Scheme, false>;
/// Velocities under forces alone, angular ones under torques: forward Euler.
template <bool spins>
using Kicks = ArraysStep<phistep::VectorInPlace<Places, Places>, decltype(phistep::forward_euler), spins>;
}  // namespace phistep_lammps

/// @file
/// The φ-method with forces at trial positions. All ranks share one step: each holds the numbers of its own atoms, and what the
/// iteration's convergence depends on is summed over all.
#pragma once

#include <mpi.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <phistep/mpi_field.hpp>

#include "angle.h"
#include "atoms.hpp"
#include "bond.h"
#include "comm.h"
#include "dihedral.h"
#include "fix.h"
#include "force.h"
#include "improper.h"
#include "kspace.h"
#include "lammps.h"
#include "modify.h"
#include "pair.h"
#include "pointers.h"
#include "update.h"

namespace phistep_lammps {
/// Three numbers for each atom of this rank that moves.
struct Numbers {
  MPI_Comm ranks;
  std::ptrdiff_t of_all_ranks;
  std::vector<double> all;
};
struct Operations : phistep::MpiFieldOps<Operations, double> {
  using Handle = Numbers*;
  static Handle clone(Handle x) { return new Numbers{*x}; }
  static void release(Handle x) { delete x; }
  static std::ptrdiff_t size(Handle x) { return x->of_all_ranks; }
  static std::span<double> numbers(Handle x) { return x->all; }
  static MPI_Comm communicator(Handle x) { return x->ranks; }
};
using Field = phistep::Field<Operations>;

/// M⁻¹Ψ(r, v): LAMMPS' forces with the atoms at r, with velocities v, divided by their masses. Where a step starts LAMMPS has
/// computed them.
class Accelerations : LAMMPS_NS::Pointers {
 public:
  /// @param start  of the step, while the forces are those there
  Accelerations(LAMMPS_NS::LAMMPS* lammps, const Movers& movers, std::int64_t& calls, const Numbers*& start)
      : Pointers{lammps}, movers_{&movers}, calls_{&calls}, start_{&start} {}
  const Field& operator()(const Field& r, const Field& v) {
    out_.take_shape(r);
    if (r.handle() != *start_) {  // a trial's: of all ranks
      *start_ = nullptr;
      movers_->scatter(r.handle()->all.data(), atom->x);
      movers_->scatter(v.handle()->all.data(), atom->v);
      compute();
    }
    std::vector<double>& to = out_.handle()->all;
    for (std::ptrdiff_t k = 0; k < movers_->size(); ++k) {
      const double by = movers_->ftm2v / movers_->mass(k);
      for (std::ptrdiff_t d = 0; d < 3; ++d)
        to[static_cast<std::size_t>(3 * k + d)] = by * atom->f[movers_->index(k)][d];
    }
    return out_;
  }

 private:
  /// As the loop of run_style verlet does it, without energies and virials.
  void compute() {
    comm->forward_comm();
    const auto n = static_cast<std::size_t>(atom->nlocal + (force->newton ? atom->nghost : 0));
    if (n > 0) {
      std::memset(atom->f[0], 0, 3 * n * sizeof(double));
      if (atom->torque != nullptr) std::memset(atom->torque[0], 0, 3 * n * sizeof(double));
    }
    if (modify->n_pre_force > 0) modify->pre_force(0);
    if (force->pair != nullptr) force->pair->compute(0, 0);
    if (force->bond != nullptr) force->bond->compute(0, 0);
    if (force->angle != nullptr) force->angle->compute(0, 0);
    if (force->dihedral != nullptr) force->dihedral->compute(0, 0);
    if (force->improper != nullptr) force->improper->compute(0, 0);
    if (force->kspace != nullptr) force->kspace->compute(0, 0);
    if (force->newton) comm->reverse_comm();
    if (modify->n_post_force_any > 0) modify->post_force(0);
    ++*calls_;
  }

  const Movers* movers_;
  std::int64_t* calls_;
  const Numbers** start_;
  Field out_;
};

/// What can't be asked for at trial states, in words; empty: all can. Some forces add to a memory whenever they are computed, some
/// are another random number each time, and what holds bonds by forces takes the step for Verlet's.
inline std::string refused(LAMMPS_NS::LAMMPS* lammps) {
  const auto begins = [](const char* style, auto... with) {
    return style != nullptr && (std::string_view{style}.starts_with(with) || ...);
  };
  const char *const pair = lammps->force->pair_style, *const remembers = " has a memory of contacts, to which each trial adds",
             *const is_random = " is another random force at each trial";
  for (const LAMMPS_NS::Fix* fix : lammps->modify->get_fix_list()) {
    const std::string name = "fix " + std::string{fix->style};
    if (begins(fix->style, "shake", "rattle")) return name + " holds bonds by forces made for Verlet's step";
    if (begins(fix->style, "langevin", "brownian", "gle", "gld", "wiener")) return name + is_random;
    if (begins(fix->style, "wall/gran")) return name + remembers;
    if (begins(fix->style, "NEIGH_HISTORY")) return "pair_style " + std::string{pair} + remembers;
  }
  if (begins(pair, "dpd", "mdpd", "sdpd", "tdpd", "edpd")) return "pair_style " + std::string{pair} + is_random;
  return {};
}

class Implicit {
  using State = phistep::Motion<Field>;
  using Stepper =
      phistep::PhiStepper<State, Accelerations, decltype(phistep::phi(0.5)), phistep::UnitMasses, phistep::FixedPoint>;

 public:
  Implicit(double phi, double rtol) : phi_{phi}, rtol_{rtol} {}
  /// The atoms are other ones, or elsewhere in the arrays.
  void forget() { stepper_.reset(); }
  /// The φ-method's equations are solved by fixed-point iteration, w ← γ M⁻¹Ψ(Y(w)), which needs no Jacobian. It contracts by
  /// φ²(ωΔt)², and converges for ωΔt < 1/φ.
  /// @return why the step failed, on every rank; empty: it is done
  std::string step(LAMMPS_NS::LAMMPS* lammps, const Movers& movers, MPI_Comm ranks, double t, double dt) {
    const Atom& atom = *movers.atom;
    if (!stepper_) {
      auto all = static_cast<double>(3 * movers.size());
      MPI_Allreduce(MPI_IN_PLACE, &all, 1, MPI_DOUBLE, MPI_SUM, ranks);
      of_all_ranks_ = static_cast<std::ptrdiff_t>(all);
    }
    State state{taken(movers, atom.x, ranks), taken(movers, atom.v, ranks)};
    if (!stepper_)
      stepper_ = std::make_unique<Stepper>(state, Accelerations{lammps, movers, calls_, start_}, phistep::phi(phi_),
                                           phistep::fixed_point({.rtol = rtol_}));
    start_ = state.r.handle();
    const auto before = stepper_->statistics().iterations;
    const auto report = stepper_->step(state, t, dt);
    iterations_ += stepper_->statistics().iterations - before;
    movers.scatter(state.r.handle()->all.data(), atom.x);
    movers.scatter(state.v.handle()->all.data(), atom.v);
    return report ? std::string{} : spoiled(movers, ranks) + report.message();
  }
  /// Of this run: calls of the forces beside LAMMPS' own, iterations.
  [[nodiscard]] std::int64_t calls() const { return calls_; }
  [[nodiscard]] std::int64_t iterations() const { return iterations_; }

 private:
  /// The first atom, of all ranks, on which the last trial's force isn't finite.
  [[nodiscard]] static std::string spoiled(const Movers& movers, MPI_Comm ranks) {
    auto first = std::numeric_limits<std::int64_t>::max();
    for (std::ptrdiff_t k = 0; k < movers.size(); ++k) {
      const std::ptrdiff_t i = movers.index(k);
      const double* const f = movers.atom->f[i];
      if (!std::isfinite(f[0] + f[1] + f[2])) first = std::min<std::int64_t>(first, movers.atom->tag[i]);
    }
    MPI_Allreduce(MPI_IN_PLACE, &first, 1, MPI_INT64_T, MPI_MIN, ranks);
    return first == std::numeric_limits<std::int64_t>::max() ? "" : "the force on atom " + std::to_string(first) + "; ";
  }
  [[nodiscard]] Field taken(const Movers& movers, double** rows, MPI_Comm ranks) const {
    std::vector<double> all(static_cast<std::size_t>(3 * movers.size()));
    movers.gather(rows, all.data());
    return Field{new Numbers{ranks, of_all_ranks_, std::move(all)}};
  }
  double phi_, rtol_;
  std::int64_t calls_ = 0, iterations_ = 0;
  std::ptrdiff_t of_all_ranks_ = 0;
  const Numbers* start_ = nullptr;
  std::unique_ptr<Stepper> stepper_;
};
}  // namespace phistep_lammps

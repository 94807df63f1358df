/// @file
/// The implicit solve where no particle acts on another: each particle's equations are solved by themselves, by the same
/// Newton iteration on `dim` unknowns, until that particle has converged. One hard particle costs its own iterations, not
/// those of all, and each one ends in the bits that it would have had alone.
///
/// Statistics: a "force call" (Jacobian, factorization, solve, iteration) is one sweep over those particles that still
/// need it, so that their numbers are those of the particle that needed most; active_iterations is the sum over all.
///
/// Only the pace of a particle's solve is kept for the next step: with blocks this small, a Jacobian and its factors cost
/// less than the memory traffic of keeping them. Affine forces with a Jacobian, whose factors never change, take NewtonResolvent instead.
#pragma once

#include <Eigen/Core>

#include <algorithm>
#include <functional>
#include <tuple>
#include <type_traits>
#include <vector>

#include "phistep/base/facts/structure.hpp"
#include "phistep/base/outcome/outcome.hpp"
#include "phistep/base/outcome/statistics.hpp"
#include "phistep/base/outcome/step_report.hpp"
#include "phistep/base/state/blocks.hpp"
#include "phistep/base/state/motion.hpp"
#include "phistep/base/state/unknowns.hpp"
#include "phistep/force/local.hpp"
#include "phistep/step/equation/right_hand_side.hpp"
#include "phistep/step/mass/mass.hpp"
#include "phistep/step/solve/resolvent.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// What the mass of all is for the particle whose components begin at `at`.
template <int dim>
[[nodiscard]] auto mass_of_particle(const auto& mass, [[maybe_unused]] Index at) {
  if constexpr (requires { mass.template particle<dim>(at); }) return mass.template particle<dim>(at);
  else return mass;
}

/// One particle's share of a state: void where S has blocks that a particle can't be cut out of.
template <class Plain, int dim>
struct OneParticle {
  using type = void;
};
template <EigenDense Vector, int dim>
  requires(!Vector::IsRowMajor || Vector::IsVectorAtCompileTime)
struct OneParticle<Vector, dim> {
  using type = Eigen::Matrix<typename Vector::Scalar, dim, 1>;
};
template <class Vector, int dim>
  requires(!Vector::IsRowMajor || Vector::IsVectorAtCompileTime)
struct OneParticle<Motion<Vector>, dim> {
  using type = Motion<Eigen::Matrix<typename Vector::Scalar, dim, 1>>;
};

/// Whether each particle of S can be solved by itself under this right-hand side.
template <State S, class Rhs>
inline constexpr bool solves_particlewise = [] {
  using Traits = typename Rhs::Traits;
  if constexpr (Traits::structure == Structure::local && Traits::block > 0)
    return is_particlewise<typename Rhs::Force, Traits::block> &&
           !std::is_void_v<typename OneParticle<PlainState<S>, Traits::block>::type> &&
           Rhs::mass_structure <= Structure::diagonal && std::is_same_v<typename Rhs::Memory, NoMemory> &&
           !(Traits::is_affine && Traits::has_jacobian);
  else return false;
}();

template <State S, class Rhs, bool position>
class LocalResolvent : public ResolventDefaults {
  static constexpr int dim = Rhs::Traits::block;
  using Scalar = ScalarOf<S>;
  using Plain = PlainState<S>;
  using Rate = RateOf<S>;
  using One = typename OneParticle<Plain, dim>::type;
  using Vector = Eigen::Matrix<Scalar, dim, 1>;
  using OneMass = decltype(mass_of_particle<dim>(std::get<0>(std::declval<const typename Rhs::Masses&>()), Index{}));
  using OneRhs = RightHandSide<One, std::reference_wrapper<typename Rhs::Force>, std::tuple<OneMass>>;
  using Own = NewtonResolvent<One, OneRhs, void, position>;
  using Pace = typename Own::Pace;
  static constexpr bool each_has_its_mass = !std::is_same_v<OneMass, std::tuple_element_t<0, typename Rhs::Masses>>;

 public:
  /// @throws std::invalid_argument where the state isn't made of particles of dim coordinates.
  LocalResolvent(const Plain& y, Rhs& rhs, const Newton<>& solver) : newton_{at_rest(), bind(rhs), solver} {
    resize(y, rhs);
  }

  void resize(const Plain& y, const Rhs&) {
    for_each_block([](auto, const auto& block) { check_particles<dim>(block); }, Blocks<S>::all(y));
    increment_.setZero(unknowns<S>(y));
    paces_.assign(static_cast<std::size_t>(increment_.size() / dim), {});
  }
  /// Forgets what solves have left.
  void forget() { std::fill(paces_.begin(), paces_.end(), Pace{}); }
  void reset() {
    forget();
    newton_.reset();
  }
  void forget_unsaved() { reset(); }

  [[nodiscard]] Outcome resolve(Rhs& rhs, const Gamma<Scalar>& gamma, Scalar t, Plain& Y, const Plain& guess, Rate& psi,
                                SolveRecord& record, bool /*knows_psi*/ = false, SolveTolerance<Plain> allowed = {}) {
    OneRhs one_rhs = bind(rhs);
    Statistics& spent = one_rhs.statistics();
    Statistics most;
    hardest_.iterations = 0;
    Outcome outcome = Outcome::success;
    for (Index at = 0; at < increment_.size() && outcome == Outcome::success; at += dim) {
      if constexpr (each_has_its_mass) one_rhs.rebind(std::tuple{mass_of_particle<dim>(std::get<0>(rhs.masses()), at)});
      One y, from, weight;
      if (allowed.target > 0) read(*allowed.weight, at, weight);
      typename Blocks<One>::Rate rate;
      read(Y, at, y);
      read(guess, at, from);
      spent = {};
      story_.iterations = 0;
      newton_.drop();
      Pace& pace = paces_[static_cast<std::size_t>(at / dim)];
      newton_.pace() = pace;
      outcome =
          newton_.resolve(one_rhs, gamma, rhs.inside(t), y, from, rate, story_, false,
                          SolveTolerance<One>{&weight, allowed.target, allowed.rtol, nullptr, allowed.has_unsized});
      pace = newton_.pace();
      write(y, at, Y);
      for_each_block([at](auto, const auto& one, auto& all) { flat(all).template segment<dim>(at) = one; },
                     Blocks<One>::Rate::blocks(rate), Rate::blocks(psi));
      increment_.template segment<dim>(at) = newton_.increment();

      rhs.statistics().active_iterations += spent.iterations;
      most = largest_of(most, spent);
      if (outcome != Outcome::success) record.particle = at / dim;
      if (story_.iterations > hardest_.iterations || outcome != Outcome::success) hardest_ = story_;
    }
    rhs.statistics() = rhs.statistics() + most;
    for (int k = 0; k < hardest_.iterations; ++k)
      record.add(hardest_.increments[std::min(static_cast<std::size_t>(k), SolveRecord::history_length - 1)]);
    return outcome;
  }

  [[nodiscard]] static bool keeps_factors() { return true; }
  [[nodiscard]] static const char* solver_name() { return "particle by particle"; }
  [[nodiscard]] const auto& increment() const { return increment_; }

 private:
  [[nodiscard]] static OneRhs bind(Rhs& rhs) {
    // A state of no particles has no first mass.
    if constexpr (each_has_its_mass) return {std::ref(rhs.force()), std::tuple{OneMass{Vector::Ones()}}};
    else return {std::ref(rhs.force()), std::tuple{std::get<0>(rhs.masses())}};
  }
  [[nodiscard]] static One at_rest() {
    One one;
    set_zero(Blocks<One>::all(one));
    return one;
  }
  static void read(const Plain& all, Index at, One& one) {
    for_each_block([at](auto, auto& to, const auto& from) { to = flat(from).template segment<dim>(at); },
                   Blocks<One>::all(one), Blocks<S>::all(all));
  }
  static void write(const One& one, Index at, Plain& all) {
    for_each_block([at](auto, const auto& from, auto& to) { flat(to).template segment<dim>(at) = from; },
                   Blocks<One>::all(one), Blocks<S>::all(all));
  }

  Own newton_;
  std::vector<Pace> paces_;
  Eigen::Matrix<Scalar, static_unknowns<S>, 1> increment_;
  SolveRecord story_, hardest_;
};

template <State S, class Rhs, bool position>
  requires(solves_particlewise<S, Rhs>)
struct ResolventFor<S, Rhs, Newton<>, position> {
  using type = LocalResolvent<S, Rhs, position>;
};

}}  // namespace phistep::PHISTEP_ABI

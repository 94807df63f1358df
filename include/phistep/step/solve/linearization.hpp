/// @file
/// K = ∂Ψ/∂r, C = ∂Ψ/∂v (or ∂Ψ/∂y) and the factorized matrix W = M − γ_f C − γ_f γ_d K of a resolve: which system serves
/// them is decided from the force's own traits, and what was made is kept while it serves.
#pragma once

#include <Eigen/Core>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>
#include <type_traits>

#include "phistep/base/archive/archive.hpp"
#include "phistep/base/facts/structure.hpp"
#include "phistep/base/machine/memory.hpp"
#include "phistep/base/numbers/finite_witness.hpp"
#include "phistep/base/outcome/outcome.hpp"
#include "phistep/base/outcome/statistics.hpp"
#include "phistep/base/state/blocks.hpp"
#include "phistep/base/state/unknowns.hpp"
#include "phistep/step/equation/right_hand_side.hpp"
#include "phistep/step/jacobian/analytic.hpp"
#include "phistep/step/jacobian/difference_tangent.hpp"
#include "phistep/step/jacobian/differences.hpp"
#include "phistep/step/mass/bound_masses.hpp"
#include "phistep/step/matrix/choice.hpp"
#include "phistep/step/matrix/dense_system.hpp"
#include "phistep/step/matrix/linear_system.hpp"
#include "phistep/step/matrix/static_sparse_system.hpp"
#include "phistep/step/solve/convergence.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// Where the tangents come from that the force doesn't give entry by entry.
template <State S, class Rhs, class LinearSolver, bool has_K, bool has_C>
struct TangentSource {
  using type = DifferenceTangent<S, Rhs, has_K, has_C>;
};

/// Which Jacobian and factors are there, and for which γ they were made.
template <class Scalar>
class KeptFactors {
 public:
  [[nodiscard]] bool has_jacobian() const { return has_jacobian_; }
  [[nodiscard]] bool has_factors() const { return has_factors_; }
  [[nodiscard]] bool has_factors_for(const Gamma<Scalar>& gamma) const { return has_factors_ && gamma == factored_; }
  /// |γ/γ_p − 1| of factors made for γ_p: about what an iteration on them leaves of the error.
  [[nodiscard]] double staleness(const Gamma<Scalar>& gamma) const {
    return has_factors_ ? std::abs(static_cast<double>(gamma.force / factored_.force) - 1) : 0;
  }
  void drop() { has_jacobian_ = has_factors_ = false; }

 protected:
  /// A new solve with coefficients γ. Factors made for others, γ_p, serve where |γ/γ_p − 1| ≤ within; corrections are then
  /// scaled.
  void begin(const Gamma<Scalar>& gamma, Scalar within, bool is_square) {
    scale_ = Scalar{1};
    if (!has_factors_ || gamma == factored_) return;
    const Scalar scale = correction_scale(gamma, factored_, within, is_square);
    if (scale == 0) has_factors_ = false;
    else scale_ = scale;
  }
  void set_factors(bool there, const Gamma<Scalar>& gamma) {
    has_factors_ = there;
    factored_ = gamma;
    scale_ = Scalar{1};
  }
  void scale(auto& x) const {
    if (scale_ != Scalar{1}) x *= scale_;
  }

  Gamma<Scalar> factored_{};
  Scalar scale_{1};
  bool has_jacobian_ = false, has_factors_ = false;
};

/// `position` = false serves resolves with γ_d = 0 only (Verlet's last half-kick): no K, and terms that ignore v are
/// never asked for a tangent.
/// @tparam stages  each factorization serves several solves
/// @tparam shifted  others factorize, with K and C
/// @tparam iterated  solves are corrected until they fit
template <State S, class Rhs, class LinearSolver, bool position, bool stages = false, bool shifted = false,
          bool iterated = !stages>
class Linearization : public KeptFactors<ScalarOf<S>> {
  using Kept = KeptFactors<ScalarOf<S>>;
  using Kept::has_jacobian_, Kept::has_factors_, Kept::factored_;

 public:
  using Scalar = ScalarOf<S>;
  using Plain = PlainState<S>;
  using Rate = RateOf<S>;
  using Traits = typename Rhs::Traits;
  static constexpr int n_static = static_unknowns<S>;
  static constexpr bool has_K = Rhs::drifts && position;
  static constexpr bool has_C = Rhs::couples_unknowns;
  static constexpr bool matrix_free = is_matrix_free<LinearSolver>;
  static constexpr bool analytic = !matrix_free && (position ? Traits::has_jacobian : Traits::has_velocity_jacobian);
  static constexpr bool patterned = !matrix_free && !analytic && Traits::has_pattern;
  static constexpr MatrixFacts facts = [] {
    MatrixFacts all{.n = n_static,
                    .has_K = has_K,
                    .has_C = has_C,
                    .symmetric = Traits::is_symmetric,
                    .constant = Traits::is_affine,
                    .iterated = iterated,
                    .shifted = shifted,
                    .block = Traits::block,
                    .differenced = !analytic,
                    .own_solver = !matrix_free && !std::is_void_v<LinearSolver>,
                    .matrix_free = matrix_free,
                    .preconditioned = is_preconditioned_krylov<LinearSolver>};
    if (analytic || patterned) all.structure = position ? Traits::structure : Traits::velocity_structure;
    all.structure = combine(all.structure, Rhs::mass_structure);
    if (!std::is_void_v<LinearSolver>) all.structure = Structure::sparse;
    if (all.structure == Structure::network) all.symmetric = analytic && Traits::is_symmetric_network;
    if constexpr (!has_K && has_C && analytic && solved_blocks<S> == 1)
      all.static_pattern =
          Rhs::mass_structure <= Structure::diagonal && has_sparse_pattern<typename Rhs::Force, n_static>;
    return all;
  }();
  static constexpr const SystemRow& row = system_row(facts);
  /// Specialized beside each system. A lambda that says nothing of itself is of Structure::dense: DenseSystem (dense_system.hpp).
  using System = typename SystemFor<row.kind, facts, Scalar, LinearSolver, typename Rhs::Force>::type;
  static_assert(
      LinearSystem<System, Scalar, n_static>,
      "phistep: this system lacks what the concept LinearSystem (phistep/step/matrix/linear_system.hpp) asks for");

  /// Tangents or their products come from differences of the force.
  static constexpr bool takes_differences = [] {
    using Source = typename TangentSource<S, Rhs, LinearSolver, has_K, has_C>::type;
    if constexpr (matrix_free) return !Source::Products::has_product;
    else return !analytic;
  }();

  /// J was supplied, or its pattern declared, by the user. What no iteration corrects has to check it.
  static constexpr bool is_promised = [] {
    if constexpr (!matrix_free) return Traits::is_affine || analytic || patterned;
    else return ProductTraits<typename Rhs::Force, std::remove_cvref_t<typename Rhs::View>, Rate>::has_product;
  }();

  /// @throws std::invalid_argument where a dense Jacobian of more than 1000 unknowns would be formed by differences.
  void resize(const Plain& y, [[maybe_unused]] Rhs& rhs) {
    const Index n = unknowns<S>(y);
    if (!analytic && !patterned && !matrix_free && n > dense_difference_limit)
      throw std::invalid_argument(
          "phistep: the Jacobian of " + std::to_string(n) +
          " unknowns by differences would be dense. Name its pattern, sparsity(f, pattern); or form no "
          "matrix, newton<MatrixFree<>>() of <phistep/krylov.hpp> or, for mild "
          "stiffness, fixed_point(); or give the force a member jacobian(...), its terms "
          "add_jacobian(...)");
    if constexpr (!analytic) differences_.resize(y, rhs);  // may throw, so it comes before anything has a new size
    n_ = n;
    system_.resize(n);
    this->drop();
  }

  /// What the last argument of a stepper holds.
  void take(const auto& solver) { system_.take(solver.linear); }
  /// A new solve with coefficients γ. @param within  see KeptFactors
  void begin(const Gamma<Scalar>& gamma, Scalar within) {
    if constexpr (!analytic) differences_.begin();
    if constexpr (matrix_free) system_.begin();
    if constexpr (follows_tolerance) within = std::min(within, Scalar{8} * std::numeric_limits<Scalar>::epsilon());
    Kept::begin(gamma, within, has_K && !has_C);
  }
  /// Drops Jacobian and factors, and forgets what solves have found out about W.
  void forget_solves() {
    this->drop();
    system_.begin_anew();
  }
  /// For another force: forgets the pattern of the differences, too, which may be another one.
  void forget() {
    forget_solves();
    if constexpr (!analytic) differences_.forget_pattern();
  }
  /// Forgets also the matrix's own pattern, with what was found out about it.
  void forget_pattern() {
    forget();
    system_.forget_pattern();
  }

  /// Products are made at the iterate they serve: none are ever kept.
  [[nodiscard]] bool has_jacobian() const { return !matrix_free && has_jacobian_; }
  [[nodiscard]] bool has_factors() const { return !matrix_free && has_factors_ && system_.has_solver(); }
  /// Factors, of a Jacobian at (t, Y) where none is kept. There, Ψ is psi.
  [[nodiscard]] Outcome refresh(Rhs& rhs, const Gamma<Scalar>& gamma, Scalar t, const Plain& Y, const Rate& psi,
                                const NewtonOptions& options, const SolveTolerance<Plain>& allowed) {
    if (matrix_free || (!stages && !has_jacobian()))  // stages have linearized
      if (const Outcome bad = linearize(rhs, gamma, t, Y, psi, options, allowed); failed(bad)) return bad;
    has_factors_ = false;
    const Outcome outcome =
        system_.factorize(each_mass_entry<S>(rhs.masses(), Y), gamma.force, gamma.drift, rhs.statistics());
    this->set_factors(outcome == Outcome::success, gamma);
    return outcome;
  }
  /// x ← W⁻¹ x. @param allowed  of a controlled run: rules where the options don't
  [[nodiscard]] Outcome solve(auto& x, const NewtonOptions& options, Statistics& statistics,
                              [[maybe_unused]] const SolveTolerance<Plain>& allowed = {}) {
    ++statistics.solves;
    const Outcome outcome = [&] {
      if constexpr (follows_tolerance || (matrix_free && stages))
        if (allowed.target > 0 && (stages || options.linear_rtol == 0))
          return system_.solve_within(
              x, inexact_share * allowed.target, [&](auto& weights) { take_unknowns<S>(weights, *allowed.weight); },
              statistics);
      if constexpr (matrix_free)
        if (allowed.target > 0 && options.linear_rtol == 0) return system_.solve(x, inexact_share, statistics);
      if constexpr (is_iterative) return system_.solve(x, options.linear_rtol, statistics);
      else return system_.solve(x);
    }();
    if (outcome != Outcome::success) {
      has_factors_ = false;  // a failed solve is not repeated with the same factors
      return outcome;
    }
    this->scale(x);
    return all_finite(x.data(), x.size()) ? Outcome::success : Outcome::singular_matrix;
  }
  // For fields (embed/field_linearization.hpp), spread over ranks, which ask each other less so. Of numbers, nothing: solve() itself,
  // no sum known (−1), no size, nothing to agree on.
  [[nodiscard]] Outcome solve_unagreed(auto& x, const NewtonOptions& options, Statistics& statistics,
                                       const SolveTolerance<Plain>& allowed, double /*square*/) {
    return solve(x, options, statistics, allowed);
  }
  [[nodiscard]] static double square_of(const auto&...) { return -1; }
  [[nodiscard]] static bool sizes(const auto&...) { return false; }
  [[nodiscard]] static Outcome agree(const Plain&) { return Outcome::success; }
  /// x ← P⁻¹ x, b ← W x, with a preconditioner P.
  void approximate(auto& x, auto& b) requires requires(System& system) { system.approximate(x, b); }
  { system_.approximate(x, b); }
  /// The same with factors of the very γ, by a small system that can only fail by what shows in x.
  static constexpr bool solves_in_registers =
      (row.kind == SystemKind::dense || row.kind == SystemKind::static_pattern) && n_static != Eigen::Dynamic &&
      n_static <= small_dense_limit;
  void solve_unchecked(auto& x, Statistics& statistics) requires solves_in_registers {
    ++statistics.solves;
    static_cast<void>(system_.solve(x));
  }
  /// The differences that made the matrix reached much further than Y and its correction: the matrix is gone.
  [[nodiscard]] bool differences_reached_too_far(const Plain& Y, const auto& correction) {
    if constexpr (!analytic)
      if (differences_.differences_reached_too_far(Y, correction)) return this->drop(), true;
    return false;
  }

  /// Whose block made W singular, −1 where that isn't known.
  [[nodiscard]] std::int64_t singular_particle() const { return system_.singular_particle(); }
  /// ‖γ_f γ_d K‖ / ‖W‖ and ‖W‖, largest entries.
  [[nodiscard]] double drift_share() const { return system_.drift_share(); }
  [[nodiscard]] double magnitude() const { return system_.magnitude(); }

  /// How the linear equations are solved, in words.
  [[nodiscard]] const char* name() const { return system_.name(row.name); }

  /// The linear solver takes a tolerance, and leaves that much of its residual.
  static constexpr bool follows_tolerance = is_preconditioned_krylov<LinearSolver>;
  static constexpr bool is_iterative = SolvesToTolerance<System, Eigen::Matrix<Scalar, n_static, 1>>;
  /// K and C at (t, Y), where Ψ is psi. Of γ, differences need the ratio.
  [[nodiscard]] Outcome linearize(Rhs& rhs, const Gamma<Scalar>& gamma, Scalar t, const Plain& Y, const Rate& psi,
                                  const NewtonOptions& options, const SolveTolerance<Plain>& allowed) {
    if constexpr (!matrix_free) ++rhs.statistics().jacobians;
    has_jacobian_ = false;  // a force that throws leaves half of one
    if constexpr (analytic) {
      set_jacobian<position, Rate, n_static>(rhs.force(), rhs.inside(t), rhs.view(Y), rhs.trial_memory(), n_, system_);
    } else {
      system_.clear();
      differences_.compute(rhs, gamma, t, Y, psi, options, allowed, system_);
    }
    // Without an rtol the weights are never read: allowed.weight may then be null.
    system_.scale_rows_by([&](auto& x) { take_unknowns<S>(x, *allowed.weight); },
                          static_cast<Scalar>(allowed.target > 0 ? allowed.rtol : 0));
    has_jacobian_ = system_.is_finite();
    return has_jacobian_ ? Outcome::success : Outcome::non_finite_jacobian;
  }
  /// K and C as they are, for schemes that make matrices of their own.
  [[nodiscard]] System& system() { return system_; }
  [[nodiscard]] bool has_factors_for(const Gamma<Scalar>& gamma) const { return has_factors() && gamma == factored_; }
  /// out += factor K x
  void add_position_product(Scalar factor, const auto& x, auto& out) const {
    static_assert(
        requires { system_.add_position_product(factor, x, out); },
        "phistep: this scheme multiplies with dPsi/dr, which the linear solver of this force can't do; name one "
        "that can, newton<Eigen::SparseLU<Eigen::SparseMatrix<double>>>(), or take another scheme");
    system_.add_position_product(factor, x, out);
  }

 private:
  [[no_unique_address]] Only<!analytic, typename TangentSource<S, Rhs, LinearSolver, has_K, has_C>::type> differences_;
  System system_;
  Index n_ = 0;
};

}}  // namespace phistep::PHISTEP_ABI

/// @file
/// Which scheme suits a problem, and what its steps cost: functions of what is known of it before a step. Limits and digits are
/// where the diagrams of run time against error (bench/work_precision) cross; costs are a model of calls and operations, so that
/// no choice depends on a clock.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>

#include "phistep/base/facts/structure.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// What was counted in a sparse Jacobian (field_matrix.hpp).
struct FieldCounts {
  double entries = -1;  ///< of L, below its diagonal, an unknown, at least; < 0: not counted
  double products = 0;  ///< Σ c² over the columns of L with c entries each, an unknown
  double row = 5;       ///< entries of W an unknown; until they are counted, those of a grid in the plane
  bool is_symmetric = false;
};

/// What the choice depends on, beside the stiffness.
struct AdvisedProblem {
  std::int64_t unknowns = 0;  ///< solved for: n for a motion, whose r and v are 2n numbers
  bool is_motion = false, uses_velocity = false, has_history = false, has_jacobian = false, has_pattern = false;
  bool is_affine = false;      ///< one matrix all along
  bool is_driven = false;      ///< the force uses the time
  bool is_dynamic = false;     ///< its size is known at run time alone: none of its matrices lie in registers
  bool has_sparse_lu = false;  ///< dense by structure, eliminated by a `jacobian_pattern`
  Structure structure = Structure::dense;
  double rtol = 1e-4;
  int digits = 15;          ///< of the scalar
  bool oscillates = false;  ///< the fastest modes do, as far as estimated: λ near ±iω
  double turns = 0;         ///< |λ|max times what is left of the run, as far as estimated
  FieldCounts field;        ///< where Krylov iterations can serve
};

/// The schemes among which is chosen.
enum class SuitableScheme : std::uint8_t {
  dormand_prince_8,
  nystrom_8,
  nystrom_12,
  verlet,
  rodas_4,  ///< Rodas4P2, of order 4
  rodas_5p,
  radau_iia,
  tr_bdf_2,
  rodas_4_krylov,  ///< the same by Krylov iterations, preconditioned by modified incomplete factors
  rodas_5p_krylov
};

/// What is known of a scheme, and how many of what a step of it costs.
struct SchemeRow {
  const char* name;   ///< as a user writes it
  double bound = 0;   ///< |λΔt| up to which an explicit step is stable, about, for a real λ < 0 or, of motion, ±iω
  double start = 0;   ///< [ns]
  double calls = 0;   ///< of the force
  double stages = 0;  ///< that are summed up
  double solves = 0;  ///< 0: it is explicit
  double jacobians = 0;    ///< those that are made: radau keeps two of three
  double factors = 0;      ///< factorizations of a dense matrix
  double not_dense = 1;    ///< times that for any other: radau's complex equations are solved side by side
  bool by_krylov = false;  ///< its linear equations, by conjugate gradients or BiCGSTAB
};
/// In the order of SuitableScheme.
inline constexpr SchemeRow scheme_rows[]{
    // name, bound, start, calls, stages, solves, Jacobians, factorizations
    {"dop853", 6.3, 25, 12, 12},
    {"rkn86", 3.6, 25, 8, 8},
    {"rkn1210", 8.3, 25, 17, 17},
    {"velocity_verlet", 2, 25, 1, 1},
    {"rodas4p2", 0, 40, 6, 6, 6, 1, 1},
    {"rodas5p", 0, 40, 8, 8, 8, 1, 1},
    {"radau", 0, 40, 20, 0, 12, 0.3, 1, 2.5},
    {"tr_bdf2", 0, 0, 6, 0, 6, 1, 1},
    {"rodas4p2", 0, 0, 6, 0, 6, 1, 1, 1, true},
    {"rodas5p", 0, 0, 8, 0, 8, 1, 1, 1, true},
};
[[nodiscard]] constexpr const SchemeRow& row_of(SuitableScheme scheme) {
  return scheme_rows[static_cast<std::size_t>(scheme)];
}
[[nodiscard]] constexpr const char* name_of(SuitableScheme scheme) { return row_of(scheme).name; }
[[nodiscard]] constexpr bool is_by_krylov(SuitableScheme scheme) { return row_of(scheme).by_krylov; }

/// Up to here a matrix is dense in the caches, and its factors cost as much as a few force calls.
inline constexpr std::int64_t few_unknowns = 50;
/// Up to here a dense Jacobian by differences and its factors are worth a step of high order (measured: 80 to 96 unknowns).
inline constexpr std::int64_t dense_unknowns = 200;

[[nodiscard]] constexpr SuitableScheme suitable_by_krylov(double rtol) {
  return rtol >= 1e-5 ? SuitableScheme::rodas_4_krylov : SuitableScheme::rodas_5p_krylov;
}
/// Where the diagrams cross: from `cheap` on rodas4p2's six stages win, from `high` down radau's orders, between them rodas5p.
struct StiffLimits {
  double cheap, high;  ///< of rtol
};
[[nodiscard]] constexpr StiffLimits stiff_limits(const AdvisedProblem& scene) {
  const bool many = scene.unknowns > dense_unknowns;
  switch (scene.structure) {
    case Structure::sparse:
      // A matrix a run: Rosenbrock steps reuse it, and radau's complex ones are worth it for many digits only.
      if (scene.is_affine) return {2e-3, 3e-8};
      return many ? StiffLimits{2e-3, 1e-4} : StiffLimits{3e-2, 3e-2};  // many: grids in the plane; few: Cusp
    case Structure::dense:
      break;
    default:
      return {2e-3, 3e-6};  // Brusselator, medical Akzo and Plate, bands
  }
  if (scene.has_sparse_lu) return {5e-4, 3e-11};  // Pollution: radau has no such elimination
  if (scene.unknowns <= 10)
    return scene.is_dynamic && !scene.is_driven
               ? StiffLimits{1, 1}         // STIFF DETEST
               : StiffLimits{5e-4, 3e-5};  // Robertson, van der Pol, HIRES, E5; Chapman
  if (scene.unknowns <= few_unknowns)
    return scene.is_driven ? StiffLimits{3e-3, 3e-3}
                           : StiffLimits{5e-4, 1e-7};  // ring modulator; Pollution as a dense problem
  return {2e-3, 3e-6};                                 // Beam, Cusp and Plate as dense problems
}

/// [ns, about, on one core of this decade] of W's equations, an unknown; measured on 8² to 256² points and 5³ to 32³. By L D Lᵀ:
/// c²/2 products a column of L, two an entry and solve. LU of an unsymmetric W takes four times that. By conjugate gradients in
/// Eisenstat's form: 1 ns an entry of W and iteration. With modified incomplete factors a solve needs some (ρ·γ)^¼ of these
/// (I. Gustafsson, BIT 18 (1978) 142): 6 on 64² points, 12 on 256². BiCGSTAB needs half as many, of twice the price.
struct FieldCost {
  double factors, solve, krylov_solve;
  double by_factors,
      by_krylov;  ///< in a step of six stages, with a tenth of the analysis: few digits take some ten steps
};
[[nodiscard]] inline FieldCost field_cost(const AdvisedProblem& scene) {
  constexpr double stages = 6;
  const FieldCounts& W = scene.field;
  const double price = W.is_symmetric ? 1 : 4,
               factorizations = scene.is_affine ? 0.25 : 1;  // they serve while Δt stays
  const double factors = price * 0.33 * W.products, solve = price * 1.8 * W.entries,
               krylov_solve = (1 + 0.7 * std::sqrt(std::sqrt(scene.turns))) * W.row;
  return {factors, solve, krylov_solve, price * 45 + factorizations * factors + stages * solve, stages * krylov_solve};
}
/// Whether Krylov iterations can serve, and cost less.
[[nodiscard]] inline bool is_for_krylov(const AdvisedProblem& scene) {
  const FieldCost cost = field_cost(scene);
  return scene.field.entries >= 0 && cost.by_krylov < cost.by_factors;
}

/// [ns, about, on one core of this decade] of a step of n unknowns, where a force call costs 12 + 2n, or of a stencil, whose
/// loops are in packs, 5 + 1.4n (measured: 1 and 1.65). Dense factorizations and solves are those measured for n = 2 … 40, those of
/// bands for 3 entries a row (with 10, twice that), of sparse matrices for the fill of 64² points, until it is counted.
[[nodiscard]] inline double step_cost(SuitableScheme scheme, const AdvisedProblem& scene) {
  const SchemeRow& row = row_of(scheme);
  const auto n = static_cast<double>(scene.unknowns);
  const bool is_dense = scene.structure == Structure::dense, is_sparse = scene.structure == Structure::sparse;
  const double call = is_sparse ? 5 + 1.4 * n : 12 + 2 * n;
  // The sums of an explicit scheme's stages: of many unknowns they are in packs, too.
  const double sums = row.stages * n * (row.solves == 0 && is_sparse ? 0.15 : 0.1 * row.stages);
  const FieldCost field = field_cost(scene);
  double factors = 30 * n, solve = 7 * n, columns = 5;
  if (is_dense) factors = 10 + n * n * (1.7 + 0.13 * n), solve = 5 + n * (5 + 0.5 * n), columns = n;
  else if (is_sparse) factors = 300 * n, solve = 25 * n, columns = 10;
  if (row.by_krylov) factors = 80 * n, solve = n * field.krylov_solve;
  else if (!is_dense && scene.field.entries >= 0) factors = n * (80 + field.factors), solve = n * field.solve;
  return row.start + row.calls * call + sums + row.solves * solve +
         row.jacobians * (scene.has_jacobian ? 2 : columns) * call +
         row.factors * (is_dense ? 1 : row.not_dense) * factors;
}

/// For stiff problems, by the structure of the matrix, its size and the tolerance.
[[nodiscard]] inline SuitableScheme suitable_implicit(const AdvisedProblem& scene) {
  using enum SuitableScheme;
  if (scene.structure == Structure::network) return tr_bdf_2;
  if (!scene.has_jacobian && !scene.has_pattern && scene.unknowns > dense_unknowns) return tr_bdf_2;
  const StiffLimits limits = stiff_limits(scene);
  // Without factors each stage costs alike, and six are better than eight. radau's matrices are complex, and unsymmetric.
  if (is_for_krylov(scene)) return suitable_by_krylov(scene.rtol);
  // What an explicit start has left of fast oscillations, Rosenbrock's error estimates see for long, radau's damped one doesn't.
  if (scene.rtol <= limits.high || (scene.oscillates && scene.structure != Structure::sparse)) return radau_iia;
  return scene.rtol >= limits.cheap ? rodas_4 : rodas_5p;
}
/// For problems that are not stiff, by the arguments of the force and the tolerance.
[[nodiscard]] constexpr SuitableScheme suitable_explicit(const AdvisedProblem& scene) {
  using enum SuitableScheme;
  if (!scene.is_motion || scene.uses_velocity) return dormand_prince_8;
  return scene.rtol > 1e-8 ? nystrom_8 : nystrom_12;
}
[[nodiscard]] inline SuitableScheme suitable_scheme(const AdvisedProblem& scene, bool is_stiff) {
  using enum SuitableScheme;
  if (scene.has_history) return verlet;
  if (is_stiff) return suitable_implicit(scene);
  const SuitableScheme scheme = suitable_explicit(scene);
  return scheme == nystrom_8 && scene.rtol >= 1e-3 && scene.unknowns > 1000 ? verlet : scheme;
}

/// Why suitable_scheme has named it, as a sentence.
/// @param tolerance  "a tolerance of 1e-06"
template <class = void>
[[nodiscard]] std::string sentence_of(SuitableScheme scheme, const AdvisedProblem& scene,
                                      const std::string& tolerance) {
  using enum SuitableScheme;
  const std::string n = std::to_string(scene.unknowns);
  switch (scheme) {
    case dormand_prince_8:
      return std::string(scene.is_motion ? "its force depends on v" : "it is of first order") +
             ": an explicit Runge-Kutta pair of order 8 needs the fewest force calls at " + tolerance;
    case nystrom_8:
    case nystrom_12:
      return "its force ignores v: a Runge-Kutta-Nystrom pair of order " +
             std::string(scheme == nystrom_8 ? "8" : "12") + " needs the fewest force calls at " + tolerance;
    case verlet:
      return scene.has_history
                 ? "its force has a history (contacts, friction): steps that resolve an impact, of equal length; "
                   "phistep::preflight says how long"
                 : "many particles at few digits: one force call a step, and a bounded error of the energy at fixed dt";
    case tr_bdf_2:
      return scene.structure == Structure::network
                 ? "its bonds are solved by conjugate gradients, which serve schemes that resolve; TR-BDF2 damps what "
                   "it "
                   "can't resolve"
                 : "it has neither a Jacobian nor a pattern: one of " + n +
                       " unknowns by differences costs as many force calls, and TR-BDF2 keeps it for many steps";
    case rodas_4:
      return "for few digits, six linear solves with one matrix and no iteration are the cheapest step";
    case rodas_5p:
      return "with " + n + " unknowns the factorization is what costs: order 5 has one for eight solves";
    case radau_iia:
      return scene.rtol <= stiff_limits(scene).high
                 ? "at " + tolerance + " and " + n + " unknowns Radau's orders 5, 9 and 13 are ahead"
                 : "its fastest modes oscillate, which Radau damps, and its error estimate, too";
    case rodas_4_krylov:
    case rodas_5p_krylov:
      break;
  }
  return "a factorization would have at least " + std::to_string(static_cast<int>(scene.field.entries)) +
         " entries of L an unknown, which cost some " + std::to_string(static_cast<int>(field_cost(scene).by_factors)) +
         " ns a step, " + (scene.field.is_symmetric ? "conjugate gradients " : "BiCGSTAB ") +
         std::to_string(static_cast<int>(field_cost(scene).by_krylov));
}

}}  // namespace phistep::PHISTEP_ABI

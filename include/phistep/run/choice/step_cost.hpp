/// @file
/// What a step of each scheme costs, and how far stability lets an explicit one go: a model of calls and operations, so that
/// no choice depends on a clock.
#pragma once

#include "phistep/base/facts/structure.hpp"
#include "phistep/base/version.hpp"
#include "phistep/run/choice/suitable_scheme.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// |λΔt| up to which an explicit scheme's step is stable, for a real λ < 0 or, of motion, ±iω: where |R| = 1.
[[nodiscard]] constexpr double stability_bound(SuitableScheme scheme) {
  switch (scheme) {
    case SuitableScheme::dormand_prince_8:
      return 6.3;
    case SuitableScheme::nystrom_8:
      return 3.6;
    case SuitableScheme::nystrom_12:
      return 8.3;
    default:
      return 2;
  }
}

/// |ωΔt| up to which errors grow by less than 1e-4 a step for λ = ±iω.
[[nodiscard]] constexpr double turning_bound(SuitableScheme scheme) {
  if (scheme == SuitableScheme::dormand_prince_8) return 5.9;
  return stability_bound(scheme);
}

/// [ns, about, on one core of this decade] of a step of n unknowns, where a force call costs 12 + 2n, or of a stencil, whose
/// loops are in packs, 5 + 1.4n (measured: 1 and 1.65). Dense factorizations and solves are those measured for n = 2 … 40, those of
/// bands for 3 entries a row (with 10, twice that), of sparse matrices for the fill of 64² points, until it is counted. radau's complex
/// equations are solved side by side: a step is some 20 calls and 12 real solves, and keeps two Jacobians of three.
[[nodiscard]] inline double step_cost(SuitableScheme scheme, const AdvisedProblem& scene) {
  const auto n = static_cast<double>(scene.unknowns);
  const bool is_dense = scene.structure == Structure::dense, is_sparse = scene.structure == Structure::sparse;
  const double call = is_sparse ? 5 + 1.4 * n : 12 + 2 * n;
  // The sums of the stages: of many unknowns they are in packs, too.
  const auto explicit_step = [&](double calls) { return 25 + calls * (call + (is_sparse ? 0.15 : 0.1 * calls) * n); };
  const FieldCounts& field = scene.field;
  const bool is_counted = field.entries >= 0;
  const double factors = is_dense     ? 10 + n * n * (1.7 + 0.13 * n)
                         : is_counted ? n * (80 + price_of_factors(field) * 0.33 * field.products)
                         : is_sparse  ? 300 * n
                                      : 30 * n,
               solve = is_dense     ? 5 + n * (5 + 0.5 * n)
                       : is_counted ? price_of_factors(field) * 1.8 * n * field.entries
                       : is_sparse  ? 25 * n
                                    : 7 * n,
               columns = is_dense    ? n
                         : is_sparse ? 10
                                     : 5,
               jacobian = (scene.has_jacobian ? 2 : columns) * call;
  const auto linear_stages = [&](double stages) {
    return 40 + stages * (call + solve + 0.1 * stages * n) + jacobian + factors;
  };
  const auto by_krylov = [&](double stages) {
    return jacobian + 80 * n + stages * (call + n * field_cost(scene).by_krylov / 6);
  };
  switch (scheme) {
    case SuitableScheme::dormand_prince_8:
      return explicit_step(12);
    case SuitableScheme::nystrom_8:
      return explicit_step(8);
    case SuitableScheme::nystrom_12:
      return explicit_step(17);
    case SuitableScheme::verlet:
      return explicit_step(1);
    case SuitableScheme::rodas_4:
      return linear_stages(6);
    case SuitableScheme::rodas_5p:
      return linear_stages(8);
    case SuitableScheme::rodas_4_krylov:
      return by_krylov(6);
    case SuitableScheme::rodas_5p_krylov:
      return by_krylov(8);
    case SuitableScheme::radau_iia:
      return 40 + (is_dense ? 1 : 2.5) * factors + 0.3 * jacobian + 20 * call + 12 * solve;
    case SuitableScheme::tr_bdf_2:
      break;
  }
  return jacobian + factors + 6 * (call + solve);
}

}}  // namespace phistep::PHISTEP_ABI

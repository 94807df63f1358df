/// @file
/// A force and its masses at a state as numbers: ∂Ψ/∂r and ∂Ψ/∂v (or ∂Ψ/∂y) as sparse matrices, and the masses beside them.
#pragma once

#include <Eigen/Core>
#include <Eigen/SparseCore>

#include <algorithm>
#include <cmath>
#include <functional>
#include <tuple>
#include <type_traits>
#include <vector>

#include "phistep/base/state/blocks.hpp"
#include "phistep/base/state/reductions.hpp"
#include "phistep/base/state/unknowns.hpp"
#include "phistep/step/equation/right_hand_side.hpp"
#include "phistep/step/jacobian/analytic.hpp"
#include "phistep/step/jacobian/difference_tangent.hpp"
#include "phistep/step/jacobian/differences.hpp"
#include "phistep/study/stability/spectrum.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// Collects the entries of ∂Ψ/∂r and ∂Ψ/∂v (or ∂Ψ/∂y), divided by the largest mass.
struct TangentSink {
  std::vector<Eigen::Triplet<double>> K, C;
  double scale = 1;
  bool finite = true;
  void position(Index i, Index j, auto x) { put(K, i, j, static_cast<double>(x)); }
  void velocity(Index i, Index j, auto x) { put(C, i, j, static_cast<double>(x)); }
  void rate(Index i, Index j, auto x) { velocity(i, j, x); }

 private:
  void put(auto& list, Index i, Index j, double x) {
    finite = finite && std::isfinite(x);
    if (x != 0) list.emplace_back(static_cast<int>(i), static_cast<int>(j), x / scale);
  }
};

/// The tangent of no force at all.
template <State S>
[[nodiscard]] Tangent zero_tangent(const PlainState<S>& y) {
  const Index n = unknowns<S>(y);
  Index p = 0;
  if constexpr (Blocks<S>::drifts) p = position_of<S>(y).size();
  return {SparseRows(n, p), SparseRows(n, n)};
}

/// ∂Ψ/∂r and ∂Ψ/∂v (or ∂Ψ/∂y) of one force or term at (t, y), divided by the largest mass.
template <State S, class F, class Masses>
[[nodiscard]] Tangent tangent_of(F& force, ScalarOf<S> t, ScalarOf<S> dt, const PlainState<S>& y, const Masses& masses,
                                 const MemoryOf<F>& memory, const PreflightMasses& numbers) {
  using Rhs = RightHandSide<S, std::reference_wrapper<F>, Masses>;
  using Traits = typename Rhs::Traits;
  const Index n = unknowns<S>(y);
  Tangent tangent = zero_tangent<S>(y);
  if (n == 0) return tangent;
  Rhs rhs{std::ref(force), masses};
  rhs.set_memory(memory);
  rhs.begin(t, dt, y);
  RateOf<S> psi = make_rate<S>(y);
  rhs.evaluate_into(t, y, psi);
  TangentSink sink;
  sink.scale = numbers.largest;
  if constexpr (Traits::has_jacobian) {
    add_jacobian<true, RateOf<S>, static_unknowns<S>>(rhs.force(), t, rhs.view(y), rhs.trial_memory(), n, sink);
  } else if (Traits::has_pattern || n <= dense_difference_limit) {
    DifferenceTangent<S, Rhs, Rhs::drifts, Rhs::couples_unknowns> differences;
    differences.resize(y, rhs);
    // Increments follow what a step moves; a Δt far too long would reach too far, so the second time it is what K and C say.
    const auto compute = [&](ScalarOf<S> gamma) {
      sink.K.clear(), sink.C.clear();
      differences.begin();
      differences.compute(rhs, {gamma, gamma}, t, y, psi, NewtonOptions{}, SolveTolerance<PlainState<S>>{}, sink);
      const double lightest = numbers.lumped.minCoeff();
      double k = 0, c = 0;
      for (const auto& entry : sink.K) k = std::max(k, std::abs(entry.value()));
      for (const auto& entry : sink.C) c = std::max(c, std::abs(entry.value()));
      return std::sqrt(k / lightest) + c / lightest;
    };
    const double rate = compute(dt);
    if (!Traits::is_affine && rate > 0 && !(rate * static_cast<double>(dt) <= 1 && dt > 0))
      static_cast<void>(compute(static_cast<ScalarOf<S>>(1 / rate)));
  } else {
    tangent.known = false;
  }
  tangent.finite = sink.finite && !first_non_finite(RateOf<S>::blocks(psi));
  if (!tangent.finite) return tangent;
  tangent.K.setFromTriplets(sink.K.begin(), sink.K.end());
  tangent.C.setFromTriplets(sink.C.begin(), sink.C.end());
  return tangent;
}

/// Masses over all unknowns, divided by the largest.
template <State S, class Masses>
[[nodiscard]] PreflightMasses preflight_masses(const PlainState<S>& y, const Masses& masses) {
  const Index n = unknowns<S>(y);
  PreflightMasses all;
  all.lumped.setZero(n);
  Eigen::VectorXd beside = Eigen::VectorXd::Zero(n);  // Σ_{j≠i} |M_ij|/√(M_ii M_jj)
  const auto each = [&](auto&& put) {
    for_each_part(
        [&](Index at, const auto& block, const auto& mass) {
          all.is_matrix = all.is_matrix || std::remove_cvref_t<decltype(mass)>::is_matrix;
          for_each_inertia(mass, block.size(),
                           [&](Index i, Index j, auto m) { put(at + i, at + j, static_cast<double>(m)); });
        },
        Blocks<S>::solved(y), masses);
  };
  each([&](Index i, Index j, double m) {
    if (i == j) all.lumped[i] += m;
  });
  if (n > 0 && all.lumped.maxCoeff() > 0) all.largest = all.lumped.maxCoeff();
  all.lumped /= all.largest;
  if (!all.is_matrix) return all;
  const bool exact = n <= exact_spectrum_limit;
  if (exact) all.matrix.setZero(n, n);
  bool positive = true;
  each([&](Index i, Index j, double m) {
    m /= all.largest;
    if (exact) all.matrix(i, j) += m;
    positive = positive && all.lumped[i] > 0;
    if (i != j) beside[i] += std::abs(m) / std::sqrt(all.lumped[i] * all.lumped[j]);
  });
  all.lower = positive ? 1 - beside.maxCoeff() : 0;
  return all;
}

/// Rows of a particle, where the state or the force names particles; else 0.
template <State S, class Traits>
[[nodiscard]] int particle_rows(const PlainState<S>& y) {
  const auto& first = std::get<0>(Blocks<S>::solved(y));
  using Block = std::remove_cvref_t<decltype(first)>;
  if (Traits::block > 1) return Traits::block;
  if (!Block::IsVectorAtCompileTime && !Block::IsRowMajor && first.cols() > 1) return static_cast<int>(first.rows());
  return 0;
}

}}  // namespace phistep::PHISTEP_ABI

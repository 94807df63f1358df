/// @file
/// ∂Ψ/∂y·x, the Jacobian times a direction, without the matrix. A force offers it by a member
///
///     void apply_jacobian(t, const auto& y, const auto& x, auto& out) const;
///
/// which adds ∂Ψ/∂r·x.r + ∂Ψ/∂v·x.v to out.force (first order: ∂Ψ/∂y·x.y to out.rate). t, y and out are those of `add`; the
/// direction x is seen as the state is, with directions in the place of its blocks. A force with memory takes it after y.
/// Beside it a force may have
///
///     void jacobian_diagonal(t, const auto& y, auto& sink) const;
///
/// which emits diagonal entries into the sink of `add_jacobian`, for preconditioners. Terms with `jacobian` or
/// `add_jacobian` alone are asked for their entries, which are used and forgotten.
#pragma once

#include <Eigen/Core>

#include "phistep/base/version.hpp"
#include "phistep/force/evaluate.hpp"
#include "phistep/force/signature.hpp"
#include "phistep/step/jacobian/analytic.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

template <class F, class View, class Rate>
concept AppliesJacobian = requires(F& f, double t, const View& y, const View& x, Rate& out) {
  f.apply_jacobian(t, y, x, out);
}
|| requires(F& f, double t, const View& y, const MemoryOf<F>& memory, const View& x, Rate& out) {
  f.apply_jacobian(t, y, memory, x, out);
};

/// Whether F knows its Jacobian's products, and its diagonal.
template <class F, class View, class Rate>
struct ProductTraits {
  static constexpr bool applies = AppliesJacobian<F, View, Rate>;
  static_assert(applies || !has_member_named<F, NameApplyJacobian>,
                "phistep: a force's apply_jacobian must take (t, y, x, out): the time, the state, a direction seen as "
                "the state is, and the rate to add to");
  static constexpr bool has_product = applies || ForceTraits<F, View, Rate>::has_jacobian;
  static constexpr bool emits_diagonal = requires(F & f, double t, const View& y, ProbeSink& sink) {
    f.jacobian_diagonal(t, y, sink);
  };
  static constexpr bool has_diagonal = emits_diagonal || (!applies && ForceTraits<F, View, Rate>::has_jacobian);
};
template <class... T, class View, class Rate>
struct ProductTraits<Sum<T...>, View, Rate> {
  static constexpr bool has_product = (ProductTraits<Unwrapped<T>, View, Rate>::has_product && ...);
  static constexpr bool has_diagonal = (ProductTraits<Unwrapped<T>, View, Rate>::has_diagonal && ...);
};

/// out += entry · x for every entry emitted.
template <class Scalar>
struct ProductSink {
  const Scalar* r;  ///< direction of positions, null for first-order states
  const Scalar* v;  ///< direction of velocities, or of y
  Scalar* out;
  void position(Index i, Index j, Scalar entry) const { out[i] += entry * r[j]; }
  void velocity(Index i, Index j, Scalar entry) const { out[i] += entry * v[j]; }
  void rate(Index i, Index j, Scalar entry) const { velocity(i, j, entry); }
};

/// out += ∂Ψ/∂y·x.  @param sink  where terms that only know their entries put them
template <bool position, int static_n, class F, class View, class Memory, class Rate, class Scalar>
void add_product(F& force, Scalar t, const View& y, const Memory& memory, const View& x, Index n, Rate& out,
                 const ProductSink<Scalar>& sink) {
  if constexpr (is_sum<F>) {
    for_each_term(force, memory, [&](auto, auto& part, const auto& its_memory) {
      add_product<position, static_n>(part, t, y, its_memory, x, n, out, sink);
    });
  } else if constexpr (ProductTraits<F, View, Rate>::applies) {
    if constexpr (remembers<F>) force.apply_jacobian(t, y, memory, x, out);
    else force.apply_jacobian(t, y, x, out);
  } else {
    add_jacobian<position, Rate, static_n>(force, t, y, memory, n, sink);
  }
}

/// Emits at least the diagonal of ∂Ψ/∂r and ∂Ψ/∂v.
template <bool position, int static_n, class Rate, class F, class View, class Memory, class Sink, class Scalar>
void add_diagonal(F& force, Scalar t, const View& y, const Memory& memory, Index n, Sink& sink) {
  if constexpr (is_sum<F>)
    for_each_term(force, memory, [&](auto, auto& part, const auto& its_memory) {
      add_diagonal<position, static_n, Rate>(part, t, y, its_memory, n, sink);
    });
  else if constexpr (ProductTraits<F, View, Rate>::emits_diagonal) force.jacobian_diagonal(t, y, sink);
  else add_jacobian<position, Rate, static_n>(force, t, y, memory, n, sink);
}

}}  // namespace phistep::PHISTEP_ABI

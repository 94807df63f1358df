/// @file
/// A force's own Jacobian, entry by entry, into whatever matrix the solver keeps.
#pragma once

#include <Eigen/Core>

#include <string>
#include <type_traits>

#include "phistep/force/evaluate.hpp"
#include "phistep/force/signature.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// Calls put(i, j, value) for every stored entry of a dense or sparse matrix.
/// @throws WrongSize where the matrix isn't n×n (at compile time where the sizes are known).
template <int static_n, class J>
void for_each_entry(const J& jacobian, Index n, auto&& put) {
  if constexpr (std::is_base_of_v<Eigen::DenseBase<J>, J> && static_n != Eigen::Dynamic)
    static_assert((J::RowsAtCompileTime == static_n || J::RowsAtCompileTime == Eigen::Dynamic) &&
                      (J::ColsAtCompileTime == static_n || J::ColsAtCompileTime == Eigen::Dynamic),
                  "phistep: the force's Jacobian must have one row and one column per unknown");
  if (jacobian.rows() != n || jacobian.cols() != n)
    throw WrongSize("phistep: the force's Jacobian is " + std::to_string(jacobian.rows()) + " x " +
                        std::to_string(jacobian.cols()) + ", there are " + std::to_string(n) + " unknowns",
                    jacobian.rows(), jacobian.cols());
  for_each_stored<static_n>(jacobian, put);
}

/// Emits ∂Ψ/∂r, ∂Ψ/∂v (or ∂Ψ/∂y) at (t, y) into sink.position, sink.velocity (or sink.rate).
/// With position = false only ∂Ψ/∂v is wanted, and terms that ignore v are not asked.
template <bool position, class Rate, int static_n, class F, class View, class Memory, class Sink, class Scalar>
void add_jacobian(F& force, Scalar t, const View& y, const Memory& memory, Index n, Sink& sink) {
  if constexpr (is_sum<F>) {
    for_each_term(force, memory, [&](auto, auto& part, const auto& its_memory) {
      add_jacobian<position, Rate, static_n>(part, t, y, its_memory, n, sink);
    });
  } else {
    using Traits = ForceTraits<F, View, Rate>;
    if constexpr (!position && !Traits::uses_velocity) {
      return;
    } else if constexpr (Traits::returns_jacobian) {
      const auto& jacobian = call_jacobian<Traits::arity>(force, y, t);
      const auto to_position = [&sink](Index i, Index j, const auto& x) { sink.position(i, j, x); };
      const auto to_velocity = [&sink](Index i, Index j, const auto& x) { sink.velocity(i, j, x); };
      if constexpr (FirstOrderLike<View>) {
        for_each_entry<static_n>(jacobian, n, [&sink](Index i, Index j, const auto& x) { sink.rate(i, j, x); });
      } else if constexpr (Traits::arity == 1) {
        for_each_entry<static_n>(jacobian, n, to_position);
      } else {
        constexpr bool has_both = BothTangents<std::remove_cvref_t<decltype(jacobian)>>;
        static_assert(has_both, "phistep: jacobian(r, v) must return phistep::MotionJacobian{K, C}");
        if constexpr (has_both) {
          if constexpr (position) for_each_entry<static_n>(jacobian.K, n, to_position);
          for_each_entry<static_n>(jacobian.C, n, to_velocity);
        }
      }
    } else if constexpr (remembers<F>) {
      force.add_jacobian(t, y, memory, sink);
    } else {
      force.add_jacobian(t, y, sink);
    }
  }
}

/// The same into a sink that is new: a matrix that the force returns as the sink keeps it goes there at once.
template <bool position, class Rate, int static_n, class F, class View, class Memory, class Sink, class Scalar>
void set_jacobian(F& force, Scalar t, const View& y, const Memory& memory, Index n, Sink& sink) {
  if constexpr (!is_sum<F> && FirstOrderLike<View> && static_n != Eigen::Dynamic) {
    using Traits = ForceTraits<F, View, Rate>;
    if constexpr (Traits::returns_jacobian) {
      using J = std::remove_cvref_t<decltype(call_jacobian<Traits::arity>(force, y, t))>;
      if constexpr (std::is_same_v<J, Eigen::Matrix<Scalar, static_n, static_n>> &&
                    requires(const J& j) { sink.set_rates(j); })
        return sink.set_rates(call_jacobian<Traits::arity>(force, y, t));
    }
  }
  sink.clear();
  add_jacobian<position, Rate, static_n>(force, t, y, memory, n, sink);
}

// ∂Ψ/∂y·x, the Jacobian times a direction, without the matrix. A force offers it by a member
//
// void apply_jacobian(t, const auto& y, const auto& x, auto& out) const;
//
// which adds ∂Ψ/∂r·x.r + ∂Ψ/∂v·x.v to out.force (first order: ∂Ψ/∂y·x.y to out.rate). t, y and out are those of `add`; the
// direction x is seen as the state is, with directions in the place of its blocks. A force with memory takes it after y.
// Beside it a force may have
//
// void jacobian_diagonal(t, const auto& y, auto& sink) const;
//
// which emits diagonal entries into the sink of `add_jacobian`, for preconditioners. Terms with `jacobian` or
// `add_jacobian` alone are asked for their entries, which are used and forgotten.

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

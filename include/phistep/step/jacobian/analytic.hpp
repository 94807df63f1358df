/// @file
/// A force's own Jacobian, entry by entry, into whatever matrix the solver keeps.
#pragma once

#include <Eigen/Core>

#include <string>
#include <type_traits>

#include "phistep/base/version.hpp"
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
  if constexpr (is_sparse_matrix<J>) {
    for (Index outer = 0; outer < jacobian.outerSize(); ++outer)
      for (typename J::InnerIterator entry(jacobian, outer); entry; ++entry)
        put(entry.row(), entry.col(), entry.value());
  } else {
    const Index size = static_n == Eigen::Dynamic ? n : static_n;  // so that loops unroll
    for (Index j = 0; j < size; ++j)
      for (Index i = 0; i < size; ++i) put(i, j, jacobian(i, j));
  }
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
      const auto to_position = [&sink](Index i, Index j, Scalar x) { sink.position(i, j, x); };
      const auto to_velocity = [&sink](Index i, Index j, Scalar x) { sink.velocity(i, j, x); };
      if constexpr (FirstOrderLike<View>) {
        for_each_entry<static_n>(jacobian, n, [&sink](Index i, Index j, Scalar x) { sink.rate(i, j, x); });
      } else if constexpr (Traits::arity == 1) {
        for_each_entry<static_n>(jacobian, n, to_position);
      } else {
        static_assert(
            requires {
              jacobian.K;
              jacobian.C;
            },
            "phistep: jacobian(r, v) must return phistep::MotionJacobian{K, C}");
        if constexpr (requires {
                        jacobian.K;
                        jacobian.C;
                      }) {
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

}}  // namespace phistep::PHISTEP_ABI

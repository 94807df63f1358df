/// @file
/// What a force needs and offers, read from its own signature and members.
#pragma once

#include <Eigen/Core>

#include <concepts>
#include <tuple>
#include <type_traits>
#include <utility>

#include "phistep/base/facts/structure.hpp"
#include "phistep/force/arity.hpp"
#include "phistep/force/sum.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

// Whether F has any member of a given name, even a template or overloaded, which no call can test: in a class that derives from F
// and from one with such a member, taking its address is ambiguous.

struct NameAdd {
  int add;
  template <class F>
  using Member = decltype(&F::add);
};
struct NameJacobian {
  int jacobian;
  template <class F>
  using Member = decltype(&F::jacobian);
};
struct NameApplyJacobian {
  int apply_jacobian;
  template <class F>
  using Member = decltype(&F::apply_jacobian);
};

template <class F, class Name>
struct WithName : F, Name {};
template <class F, class Name>
inline constexpr bool has_member_named = false;
template <class F, class Name>
  requires(std::is_class_v<F> && !std::is_final_v<F>)
inline constexpr bool has_member_named<F, Name> = !requires { typename Name::template Member<WithName<F, Name>>; };

/// ∂Ψ/∂r and ∂Ψ/∂v of a force that depends on both: what `jacobian(r, v[, t])` returns.
template <class Position, class Velocity = Position>
struct MotionJacobian {
  Position K;  ///< ∂Ψ/∂r, n × n [force/length]
  Velocity C;  ///< ∂Ψ/∂v, n × n [force·time/length]
};
template <class Position, class Velocity>
MotionJacobian(Position, Velocity) -> MotionJacobian<Position, Velocity>;

template <class J>
concept BothTangents = requires(const J& both) {
  both.K;
  both.C;
};

/// The history of a force that has none.
struct NoMemory {};

template <class F>
struct MemoryTrait {
  using type = NoMemory;
};
template <class F>
  requires requires { typename F::Memory; }
struct MemoryTrait<F> {
  using type = typename F::Memory;
};
template <class... T>
struct MemoryTrait<Sum<T...>> {
  static constexpr bool any = (!std::is_same_v<typename MemoryTrait<Unwrapped<T>>::type, NoMemory> || ...);
  using type = std::conditional_t<any, std::tuple<typename MemoryTrait<Unwrapped<T>>::type...>, NoMemory>;
};
/// The value that carries a force's history, NoMemory where there is none.
template <class F>
using MemoryOf = typename MemoryTrait<Unwrapped<F>>::type;
template <class F>
inline constexpr bool remembers = !std::is_same_v<MemoryOf<F>, NoMemory>;

/// Whether a memory only saves work, as a neighbour list does, so that Ψ doesn't depend on it. Its type says so by `is_cache`.
template <class Memory>
inline constexpr bool is_cache = requires {
  requires Memory::is_cache;
};
template <>
inline constexpr bool is_cache<NoMemory> = true;
template <class... Memory>
inline constexpr bool is_cache<std::tuple<Memory...>> = (is_cache<Memory> && ...);
/// Whether Ψ depends on what was before.
template <class F>
inline constexpr bool has_history = !is_cache<MemoryOf<F>>;

/// Accepts every entry; the shape that `add_jacobian` is probed with.
struct ProbeSink {
  void position(Index, Index, double) {}
  void velocity(Index, Index, double) {}
  void rate(Index, Index, double) {}
};

/// A struct that adds its force to `out`.
template <class F, class View, class Rate>
concept Accumulating = requires(F& f, double t, const View& y, Rate& out) {
  f.add(t, y, out);
}
|| requires(F& f, double t, const View& y, const MemoryOf<F>& memory, Rate& out) { f.add(t, y, memory, out); };

/// An Eigen sparse matrix, recognised without including Eigen/Sparse.
template <class J>
inline constexpr bool is_sparse_matrix = requires(const J& j) {
  j.outerIndexPtr();
};
template <class K, class C>
inline constexpr bool is_sparse_matrix<MotionJacobian<K, C>> = is_sparse_matrix<K> || is_sparse_matrix<C>;

/// put(i, j, value) for each stored entry of a dense or sparse matrix. @tparam n  its size, if known: loops then unroll
template <int n = Eigen::Dynamic>
void for_each_stored(const auto& A, auto&& put) {
  if constexpr (is_sparse_matrix<std::remove_cvref_t<decltype(A)>>) {
    for (Index outer = 0; outer < A.outerSize(); ++outer)
      for (typename std::remove_cvref_t<decltype(A)>::InnerIterator entry(A, outer); entry; ++entry)
        put(entry.row(), entry.col(), entry.value());
  } else {
    const Index rows = n == Eigen::Dynamic ? A.rows() : n, columns = n == Eigen::Dynamic ? A.cols() : n;
    for (Index j = 0; j < columns; ++j)
      for (Index i = 0; i < rows; ++i) put(i, j, A(i, j));
  }
}

template <class F, class View>
concept AddsJacobian = requires(F& f, double t, const View& y, ProbeSink& sink) {
  f.add_jacobian(t, y, sink);
}
|| requires(F& f, double t, const View& y, const MemoryOf<F>& memory, ProbeSink& sink) {
  f.add_jacobian(t, y, memory, sink);
};

/// Whether F states that it ignores v, or t: then it is not given them (force/evaluate.hpp).
template <class F>
inline constexpr bool ignores_velocity = requires {
  requires !F::uses_velocity;
};
template <class F>
inline constexpr bool ignores_time = requires {
  requires !F::uses_time;
};

/// Needs and offers of force F for states seen through View, with rates of type Rate.
template <class F, class View, class Rate>
struct ForceTraits {
  static constexpr bool accumulates = Accumulating<F, View, Rate>;
  static constexpr int arity = [] {
    if constexpr (accumulates) return 0;
    else return call_arity<F, View>();
  }();
  static constexpr ForceFault fault = [] {
    if constexpr (accumulates) return ForceFault::none;
    else if constexpr (arity == 0) return fault_of_form<F, View>();
    else if constexpr ((MotionLike<View> && arity >= 2 && ignores_velocity<F>) ||
                       (arity == (MotionLike<View> ? 3 : 2) && ignores_time<F>))
      return ForceFault::unused;
    else
      return fault_of_result<decltype(call_with<arity>(std::declval<F&>(), std::declval<const View&>(),
                                                       typename ViewScalar<View>::type{})),
                             std::remove_cvref_t<decltype(std::get<0>(Rate::blocks(std::declval<Rate&>())))>>();
  }();
  static constexpr bool valid = fault == ForceFault::none;

  // What a static member says (a template where it depends on the kind of state), else what the form of a call says.
  static constexpr bool uses_velocity = [] {
    if constexpr (requires { bool{F::template uses_velocity_of<View>}; }) return F::template uses_velocity_of<View>;
    else if constexpr (requires { bool{F::uses_velocity}; }) return F::uses_velocity;
    else return accumulates || !MotionLike<View> || arity >= 2;
  }();
  static constexpr bool uses_time = [] {
    if constexpr (requires { bool{F::template uses_time_of<View>}; }) return F::template uses_time_of<View>;
    else if constexpr (requires { bool{F::uses_time}; }) return F::uses_time;
    else return accumulates || arity == (MotionLike<View> ? 3 : 2);
  }();

  /// The force says that calling it again costs less than remembering its result: a table, an array given from outside.
  static constexpr bool is_lookup = requires { requires F::is_lookup; };
  static constexpr bool is_affine = requires { requires F::is_affine; };
  static constexpr bool is_symmetric = requires { requires F::is_symmetric; };
  /// The force knows where its tangents can be non-zero, so that differences need few calls.
  static constexpr bool has_pattern = requires(const F& f, Index n) { f.pattern(n); };
  /// Rows of one particle's block of the tangent, 0 where the force names none; a network that leaves it to the state has those
  /// of its particles, the columns of a matrix.
  static constexpr int block = [] {
    int named = 0;
    if constexpr (requires { int{F::block}; }) named = F::block;
    if constexpr (MotionLike<View> && requires { requires F::structure == Structure::network; }) {
      using FirstBlock = FirstOf<View>;
      constexpr int rows = FirstBlock::RowsAtCompileTime;
      if (named == 0 && rows > 0 && !FirstBlock::IsVectorAtCompileTime && !FirstBlock::IsRowMajor) named = rows;
    }
    return named;
  }();

  static constexpr bool returns_jacobian = takes<arity, JacobianOf<F>, View>();
  static constexpr bool has_jacobian = returns_jacobian || AddsJacobian<F, View>;
  static constexpr bool has_velocity_jacobian = has_jacobian || !uses_velocity;
  static_assert(has_jacobian || !has_member_named<F, NameJacobian>,
                "phistep: the force's member jacobian(...) must take the same arguments as the force itself");

  static constexpr Structure structure = [] {
    if constexpr (requires {
                    { F::structure } -> std::convertible_to<Structure>;
                  }) {
      return Structure{F::structure};
    } else if constexpr (returns_jacobian) {
      using J = decltype(call_jacobian<arity>(std::declval<F&>(), std::declval<const View&>(),
                                              typename ViewScalar<View>::type{}));
      return is_sparse_matrix<std::remove_cvref_t<J>> ? Structure::sparse : Structure::dense;
    } else {
      return Structure::dense;
    }
  }();
  static constexpr Structure velocity_structure = uses_velocity ? structure : Structure::none;
  /// Whether its tangent is symmetric in a network: forces of pairs are if they are given as edges, and so is a diagonal.
  static constexpr bool is_symmetric_network = [] {
    if constexpr (structure == Structure::network) return requires {
        requires F::has_edges;
      };
    else return structure <= Structure::diagonal || is_symmetric;
  }();
};

/// A sum needs what any of its terms needs, and has a Jacobian where all have one.
template <class... T, class View, class Rate>
struct ForceTraits<Sum<T...>, View, Rate> {
  template <class Part>
  using Of = ForceTraits<Unwrapped<Part>, View, Rate>;
  static constexpr bool accumulates = true;
  static constexpr int arity = 0;
  static constexpr ForceFault fault = [] {
    ForceFault first = ForceFault::none;
    ((first = first == ForceFault::none ? Of<T>::fault : first), ...);
    return first;
  }();
  static constexpr bool valid = fault == ForceFault::none;
  static constexpr bool uses_velocity = (Of<T>::uses_velocity || ...);
  static constexpr bool uses_time = (Of<T>::uses_time || ...);
  static constexpr bool is_lookup = (Of<T>::is_lookup && ...);
  static constexpr bool is_affine = (Of<T>::is_affine && ...);
  static constexpr bool is_symmetric = (Of<T>::is_symmetric && ...);
  static constexpr bool is_symmetric_network = (Of<T>::is_symmetric_network && ...);
  static constexpr bool has_pattern =
      ((Of<T>::has_pattern || Of<T>::structure <= Structure::diagonal) && ...) && (Of<T>::has_pattern || ...);
  /// Terms that name a block must agree on it.
  static constexpr int block = [] {
    int all = 0;
    const auto join = [&all](int of) { all = of == 0 || all == of ? all : all == 0 ? of : -1; };
    (join(Of<T>::block), ...);
    return all < 0 ? 0 : all;
  }();
  static constexpr bool blocks_agree = ((Of<T>::block == 0 || Of<T>::block == block) && ...);
  static constexpr bool returns_jacobian = false;
  static constexpr bool has_jacobian = (Of<T>::has_jacobian && ...);
  static constexpr bool has_velocity_jacobian = (Of<T>::has_velocity_jacobian && ...);
  static constexpr auto joined = [](auto... of) {
    Structure all = Structure::none;
    ((all = combine(all, of)), ...);
    return blocks_agree ? all : combine(all, Structure::sparse);
  };
  static constexpr Structure structure = joined(Of<T>::structure...);
  static constexpr Structure velocity_structure = joined(Of<T>::velocity_structure...);
};

}}  // namespace phistep::PHISTEP_ABI

/// @file
/// What a force needs and offers, read from its own signature: arity alone decides, so no body is ever instantiated
/// with the wrong types.
#pragma once

#include <Eigen/Core>

#include <concepts>
#include <tuple>
#include <type_traits>
#include <utility>

#include "phistep/core/member_named.hpp"
#include "phistep/core/structure.hpp"
#include "phistep/core/version.hpp"
#include "phistep/force/sum.hpp"
#include "phistep/state/blocks.hpp"
#include "phistep/state/motion.hpp"

namespace phistep::inline PHISTEP_ABI {

/// ∂Ψ/∂r and ∂Ψ/∂v of a force that depends on both: what `jacobian(r, v[, t])` returns.
template <class Position, class Velocity = Position>
struct MotionJacobian {
  Position K;  ///< ∂Ψ/∂r, n × n [force/length]
  Velocity C;  ///< ∂Ψ/∂v, n × n [force·time/length]
};
template <class Position, class Velocity>
MotionJacobian(Position, Velocity) -> MotionJacobian<Position, Velocity>;

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

/// Whether a memory is nothing but work saved, as a neighbour list: Ψ doesn't depend on it. Says so by `is_cache`.
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

template <class View>
concept FirstOrderLike = requires(const View& view) {
  view.y;
}
&&!requires(const View& view) { view.r; };
template <class View>
concept MotionLike = requires(const View& view) {
  view.r;
  view.v;
};
template <class View>
struct ViewScalar {
  using type = typename std::remove_cvref_t<decltype([](const View& view) -> decltype(auto) {
    if constexpr (MotionLike<View>) return (view.r);
    else return (view.y);
  }(std::declval<const View&>()))>::Scalar;
};

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

/// Number of arguments of a force that is called and returns, 0 where no accepted form fits.
template <class F, class View>
[[nodiscard]] consteval int call_arity() {
  if constexpr (MotionLike<View>) {
    using V = decltype(std::declval<const View&>().r);
    using T = typename ViewScalar<View>::type;
    if constexpr (std::is_invocable_v<F&, V, V, T>) return 3;
    else if constexpr (std::is_invocable_v<F&, V, V>) return 2;
    else if constexpr (std::is_invocable_v<F&, V>) return 1;
    else return 0;
  } else if constexpr (FirstOrderLike<View>) {
    using Y = decltype(std::declval<const View&>().y);
    using T = typename ViewScalar<View>::type;
    if constexpr (std::is_invocable_v<F&, Y, T>) return 2;
    else if constexpr (std::is_invocable_v<F&, Y>) return 1;
    else return 0;
  } else {
    return 0;
  }
}

/// Calls f with as many of (r, v, t) or (y, t) as it takes.
template <int arity, class View, class Scalar>
[[nodiscard]] decltype(auto) call_with(auto&& f, const View& y, Scalar t) {
  if constexpr (MotionLike<View>) {
    if constexpr (arity == 3) return f(y.r, y.v, t);
    else if constexpr (arity == 2) return f(y.r, y.v);
    else return f(y.r);
  } else {
    if constexpr (arity == 2) return f(y.y, t);
    else return f(y.y);
  }
}

/// Calls f.jacobian with the force's own arguments.
template <int arity, class F, class View, class Scalar>
[[nodiscard]] decltype(auto) call_jacobian(F& f, const View& y, Scalar t) {
  if constexpr (MotionLike<View>) {
    if constexpr (arity == 3) return f.jacobian(y.r, y.v, t);
    else if constexpr (arity == 2) return f.jacobian(y.r, y.v);
    else return f.jacobian(y.r);
  } else {
    if constexpr (arity == 2) return f.jacobian(y.y, t);
    else return f.jacobian(y.y);
  }
}

/// True where f.jacobian takes the force's own arguments.
template <class F, class View, int arity, class T = typename ViewScalar<View>::type>
[[nodiscard]] consteval bool returns_jacobian() {
  if constexpr (MotionLike<View> && arity == 3) return requires(F & f, const View& y, T t) {
      f.jacobian(y.r, y.v, t);
    };
  else if constexpr (MotionLike<View> && arity == 2) return requires(F & f, const View& y) {
      f.jacobian(y.r, y.v);
    };
  else if constexpr (MotionLike<View> && arity == 1) return requires(F & f, const View& y) {
      f.jacobian(y.r);
    };
  else if constexpr (FirstOrderLike<View> && arity == 2) return requires(F & f, const View& y, T t) {
      f.jacobian(y.y, t);
    };
  else if constexpr (FirstOrderLike<View> && arity == 1) return requires(F & f, const View& y) {
      f.jacobian(y.y);
    };
  else return false;
}
/// An Eigen sparse matrix, told without including Eigen/Sparse.
template <class J>
inline constexpr bool is_sparse_matrix = requires(const J& j) {
  j.outerIndexPtr();
};
template <class K, class C>
inline constexpr bool is_sparse_matrix<MotionJacobian<K, C>> = is_sparse_matrix<K> || is_sparse_matrix<C>;

template <class F, class View>
concept AddsJacobian = requires(F& f, double t, const View& y, ProbeSink& sink) {
  f.add_jacobian(t, y, sink);
}
|| requires(F& f, double t, const View& y, const MemoryOf<F>& memory, ProbeSink& sink) {
  f.add_jacobian(t, y, memory, sink);
};

/// Owning Eigen objects, and views of memory that outlives the call; not an expression that refers to dead temporaries.
template <class R>
concept PlainResult = EigenDense<std::remove_cvref_t<R>>;

/// Why a force can't be taken.
enum class ForceFault {
  none,
  form,           ///< none of those accepted
  member,         ///< a pointer to a member function
  changes_state,  ///< takes a non-const reference
  output,         ///< writes its result into an argument
  time_first,
  nothing,    ///< is returned
  lazy,       ///< an expression is
  no_vector,  ///< nor an expression
  scalar,     ///< of another type than the state's
  size        ///< likewise
};

template <class F, class... Arguments>
[[nodiscard]] consteval bool writes_into() {
  if constexpr (std::is_invocable_v<F&, Arguments...>) return std::is_void_v<std::invoke_result_t<F&, Arguments...>>;
  else return false;
}
/// Why f can't be called. One question after the other: each compiles a generic lambda's body.
template <class F, class View>
[[nodiscard]] consteval ForceFault fault_of_form() {
  if constexpr (std::is_member_pointer_v<F>) {
    return ForceFault::member;
  } else if constexpr (MotionLike<View>) {
    using V = std::remove_cvref_t<decltype(std::declval<const View&>().r)>;
    using T = typename ViewScalar<View>::type;
    if constexpr (writes_into<F, V&, V&, V&, T>()) return ForceFault::output;
    else if constexpr (writes_into<F, V&, V&, V&>()) return ForceFault::output;
    else if constexpr (writes_into<F, V&, V&, T>()) return ForceFault::output;
    else if constexpr (writes_into<F, V&, V&>()) return ForceFault::output;
    else if constexpr (std::is_invocable_v<F&, V&, V&, T>) return ForceFault::changes_state;
    else if constexpr (std::is_invocable_v<F&, V&, V&>) return ForceFault::changes_state;
    else if constexpr (std::is_invocable_v<F&, V&>) return ForceFault::changes_state;
    else if constexpr (std::is_invocable_v<F&, T, V&, V&>) return ForceFault::time_first;
    else if constexpr (std::is_invocable_v<F&, T, V&>) return ForceFault::time_first;
    else return ForceFault::form;
  } else if constexpr (FirstOrderLike<View>) {
    using Y = std::remove_cvref_t<decltype(std::declval<const View&>().y)>;
    using T = typename ViewScalar<View>::type;
    if constexpr (writes_into<F, Y&, Y&, T>()) return ForceFault::output;
    else if constexpr (writes_into<F, T, Y&, Y&>()) return ForceFault::output;
    else if constexpr (writes_into<F, Y&, Y&>()) return ForceFault::output;
    else if constexpr (std::is_invocable_v<F&, Y&, T>) return ForceFault::changes_state;
    else if constexpr (std::is_invocable_v<F&, Y&>) return ForceFault::changes_state;
    else if constexpr (std::is_invocable_v<F&, T, Y&>) return ForceFault::time_first;
    else return ForceFault::form;
  } else {
    return ForceFault::form;
  }
}
/// Whether a result can stand in a block of the state's rate.
template <class Result, class Block>
[[nodiscard]] consteval ForceFault fault_of_result() {
  using R = std::remove_cvref_t<Result>;
  if constexpr (std::is_void_v<R>) {
    return ForceFault::nothing;
  } else if constexpr (!PlainResult<R>) {
    return std::is_base_of_v<Eigen::EigenBase<R>, R> ? ForceFault::lazy : ForceFault::no_vector;
  } else {
    if (!std::is_same_v<typename R::Scalar, typename Block::Scalar>) return ForceFault::scalar;
    const bool fits = R::SizeAtCompileTime == Eigen::Dynamic || Block::SizeAtCompileTime == Eigen::Dynamic ||
                      (int{R::RowsAtCompileTime} == int{Block::RowsAtCompileTime} &&
                       int{R::ColsAtCompileTime} == int{Block::ColsAtCompileTime});
    return fits ? ForceFault::none : ForceFault::size;
  }
}
/// Says what is wrong, and what to write instead.
template <ForceFault fault, bool of_motion>
struct Refusal {
  static_assert(fault != ForceFault::form || !of_motion,
                "phistep: the force of a motion must be callable as f(r), f(r, v) or f(r, v, t), or be a struct with "
                "add(t, y, out)");
  static_assert(fault != ForceFault::form || of_motion,
                "phistep: the force of a first-order state must be callable as f(y) or f(y, t), or be a struct with "
                "add(t, y, out)");
  static_assert(fault != ForceFault::member,
                "phistep: a member function needs its object: give a lambda, [&system](const Vec& y) -> Vec { return "
                "system.rate(y); }");
  static_assert(
      fault != ForceFault::changes_state,
      "phistep: the force takes the state by non-const reference; take it by const reference (const Vec&), or "
      "wrap it in a lambda that does");
  static_assert(fault != ForceFault::output,
                "phistep: the force writes its result into an argument, as Odeint's f(y, dydt, t) does; wrap it in a "
                "lambda that returns it: [](const Vec& y, double t) -> Vec { Vec dydt(y.size()); f(y, dydt, t); return "
                "dydt; }");
  static_assert(
      fault != ForceFault::time_first,
      "phistep: time comes last: a force must be callable as f(y) or f(y, t), that of a motion as f(r), f(r, v) "
      "or f(r, v, t)");
  static_assert(
      fault != ForceFault::nothing,
      "phistep: the force returns nothing; it must return a vector (-> Vec), or be a struct with add(t, y, out)");
  static_assert(fault != ForceFault::lazy,
                "phistep: the force returns a lazy Eigen expression, which would refer to dead temporaries; "
                "give the lambda a return type (-> Vec) or end with .eval()");
  static_assert(fault != ForceFault::no_vector,
                "phistep: the force must return an Eigen vector or matrix like the state, not a number or a container");
  static_assert(fault != ForceFault::scalar, "phistep: the force returns another scalar type than the state's");
  static_assert(fault != ForceFault::size, "phistep: the force returns a vector of another size than the state's");
  static constexpr bool is_said = true;
};

/// What a force says about itself by a static member (a template where it depends on the kind of state); `otherwise`
/// where it is silent.
template <class F, class View>
[[nodiscard]] consteval bool says_uses_velocity(bool otherwise) {
  if constexpr (requires { bool{F::template uses_velocity_of<View>}; }) return F::template uses_velocity_of<View>;
  else if constexpr (requires { bool{F::uses_velocity}; }) return F::uses_velocity;
  else return otherwise;
}
template <class F, class View>
[[nodiscard]] consteval bool says_uses_time(bool otherwise) {
  if constexpr (requires { bool{F::template uses_time_of<View>}; }) return F::template uses_time_of<View>;
  else if constexpr (requires { bool{F::uses_time}; }) return F::uses_time;
  else return otherwise;
}
/// Rows of a particle's vector where a state has them as columns of a matrix, 0 where it doesn't.
template <class View>
[[nodiscard]] consteval int dimension_of() {
  if constexpr (MotionLike<View>) {
    using Positions = std::remove_cvref_t<decltype(std::declval<const View&>().r)>;
    if constexpr (!Positions::IsVectorAtCompileTime && !Positions::IsRowMajor && int{Positions::RowsAtCompileTime} > 0)
      return Positions::RowsAtCompileTime;
  }
  return 0;
}
/// Rows of one particle's (or chain link's) block of the tangent, 0 where the force names none; a network that leaves it to
/// the state has that of its particles.
template <class F, class View>
[[nodiscard]] consteval int block_of() {
  int named = 0;
  if constexpr (requires { int{F::block}; }) named = F::block;
  if constexpr (requires { requires F::structure == Structure::network; })
    if (named == 0) named = dimension_of<View>();
  return named;
}

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
    else
      return fault_of_result<decltype(call_with<arity>(std::declval<F&>(), std::declval<const View&>(),
                                                       typename ViewScalar<View>::type{})),
                             std::remove_cvref_t<decltype(std::get<0>(Rate::blocks(std::declval<Rate&>())))>>();
  }();
  static constexpr bool valid = fault == ForceFault::none;

  static constexpr bool uses_velocity =
      says_uses_velocity<F, View>(accumulates || (MotionLike<View> ? arity >= 2 : true));
  static constexpr bool uses_time = says_uses_time<F, View>(accumulates || arity == (MotionLike<View> ? 3 : 2));

  /// The force says that calling it again costs less than remembering its result: a table, an array given from outside.
  static constexpr bool is_lookup = requires { requires F::is_lookup; };
  static constexpr bool is_affine = requires { requires F::is_affine; };
  static constexpr bool is_symmetric = requires { requires F::is_symmetric; };
  /// The force knows where its tangents can be non-zero, so that differences need few calls.
  static constexpr bool has_pattern = requires(const F& f, Index n) { f.pattern(n); };
  static constexpr int block = block_of<F, View>();

  static constexpr bool returns_jacobian = phistep::returns_jacobian<F, View, arity>();
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
  /// Whether its tangent is symmetric where pairs are given as edges: those are, and so is a diagonal.
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
  static constexpr bool has_pattern = false;
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
  static constexpr Structure structure = [] {
    Structure all = Structure::none;
    ((all = combine(all, Of<T>::structure)), ...);
    return blocks_agree ? all : combine(all, Structure::sparse);
  }();
  static constexpr Structure velocity_structure = [] {
    Structure all = Structure::none;
    ((all = combine(all, Of<T>::velocity_structure)), ...);
    return blocks_agree ? all : combine(all, Structure::sparse);
  }();
};

}  // namespace phistep::inline PHISTEP_ABI

/// @file
/// How a force that returns its result is called: as f(r), f(r, v), f(r, v, t), or as f(y), f(y, t); and why it can't be.
/// Arity alone decides, so no body is ever instantiated with the wrong types.
#pragma once

#include <Eigen/Core>

#include <type_traits>
#include <utility>

#include "phistep/base/state/blocks.hpp"
#include "phistep/base/version.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

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
/// Of a struct of blocks with names of its own, whose forces add: nothing.
template <class View>
struct ViewScalar {
  using type = void;
};
template <MotionLike View>
struct ViewScalar<View> {
  using type = typename std::remove_cvref_t<decltype(std::declval<const View&>().r)>::Scalar;
};
template <FirstOrderLike View>
struct ViewScalar<View> {
  using type = typename std::remove_cvref_t<decltype(std::declval<const View&>().y)>::Scalar;
};

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
/// Owning Eigen objects, and views of memory that outlives the call; not an expression that refers to dead temporaries.
template <class R>
concept PlainResult = EigenDense<std::remove_cvref_t<R>> || FieldBlock<R>;

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
struct Refusal : Refuses {
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
};

}}  // namespace phistep::PHISTEP_ABI

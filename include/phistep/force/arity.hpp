/// @file
/// How a force that returns its result is called: as f(r), f(r, v), f(r, v, t), or as f(y), f(y, t); and why it can't be.
/// Arity alone decides, so no body is ever instantiated with the wrong types.
#pragma once

#include <Eigen/Core>

#include <type_traits>
#include <utility>

#include "phistep/base/state/blocks.hpp"

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
/// The positions, or the unknowns.
template <class View>
[[nodiscard]] const auto& first_of(const View& y) {
  if constexpr (MotionLike<View>) return y.r;
  else return y.y;
}
template <class View>
using FirstOf = std::remove_cvref_t<decltype(first_of(std::declval<const View&>()))>;
/// Of a struct of blocks with names of its own, whose forces add: nothing.
template <class View>
struct ViewScalar {
  using type = void;
};
template <class View>
  requires(MotionLike<View> || FirstOrderLike<View>)
struct ViewScalar<View> {
  using type = typename FirstOf<View>::Scalar;
};

/// Whether f can be called with so many of (r, v, t) or (y, t).
template <int arity, class F, class View>
[[nodiscard]] consteval bool takes() {
  using T = typename ViewScalar<View>::type;
  if constexpr (MotionLike<View>) {
    using V = decltype(std::declval<const View&>().r);
    if constexpr (arity == 3) return std::is_invocable_v<F&, V, V, T>;
    if constexpr (arity == 2) return std::is_invocable_v<F&, V, V>;
    if constexpr (arity == 1) return std::is_invocable_v<F&, V>;
  } else if constexpr (FirstOrderLike<View>) {
    using Y = decltype(std::declval<const View&>().y);
    if constexpr (arity == 2) return std::is_invocable_v<F&, Y, T>;
    if constexpr (arity == 1) return std::is_invocable_v<F&, Y>;
  }
  return false;
}
/// Number of arguments of a force that is called and returns, 0 where no accepted form fits.
template <class F, class View>
[[nodiscard]] consteval int call_arity() {
  if constexpr (takes<3, F, View>()) return 3;
  else if constexpr (takes<2, F, View>()) return 2;
  else return takes<1, F, View>() ? 1 : 0;
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

/// f.jacobian as a function, which is called with the force's own arguments.
template <class F>
struct JacobianOf {
  F& f;
  // The return type is explicit: a check whether f has a Jacobian must not compile the Jacobian's body.
  template <class... Arguments, class Force = F>
  auto operator()(const Arguments&... x) const -> decltype(std::declval<Force&>().jacobian(x...)) {
    return f.jacobian(x...);
  }
};
template <int arity, class F, class View, class Scalar>
[[nodiscard]] decltype(auto) call_jacobian(F& f, const View& y, Scalar t) {
  return call_with<arity>(JacobianOf<F>{f}, y, t);
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
  nothing,    ///< nothing is returned
  lazy,       ///< an Eigen expression is returned, which would refer to dead temporaries
  no_vector,  ///< neither a vector nor an expression is returned
  scalar,     ///< its scalar type is not the state's
  size,       ///< its size is not the state's
  unused      ///< its arguments have what it says it doesn't use
};

template <class F, class... Arguments>
struct WritesInto : std::false_type {};
template <class F, class... Arguments>
  requires std::is_void_v<std::invoke_result_t<F&, Arguments...>>
struct WritesInto<F, Arguments...> : std::true_type {
};
/// Why f can't be called. Tests end at the first that holds (std::disjunction): each one compiles a generic lambda's body.
/// @tparam Block  a block of the state, as a reference that isn't const
/// @tparam Whole  the state's blocks, likewise
template <class F, class T, class Block, class... Whole>
[[nodiscard]] consteval ForceFault fault_of_arguments() {
  if constexpr (std::disjunction_v<WritesInto<F, Whole..., Block, T>, WritesInto<F, Whole..., Block>,
                                   WritesInto<F, Block, Block, T>, WritesInto<F, Block, Block>,
                                   WritesInto<F, T, Whole..., Block>>)
    return ForceFault::output;
  else if constexpr (std::disjunction_v<std::is_invocable<F&, Whole..., T>, std::is_invocable<F&, Whole...>,
                                        std::is_invocable<F&, Block>>)
    return ForceFault::changes_state;
  else if constexpr (std::disjunction_v<std::is_invocable<F&, T, Whole...>, std::is_invocable<F&, T, Block>>)
    return ForceFault::time_first;
  else return ForceFault::form;
}
template <class F, class View>
[[nodiscard]] consteval ForceFault fault_of_form() {
  using T = typename ViewScalar<View>::type;
  if constexpr (std::is_member_pointer_v<F>) return ForceFault::member;
  else if constexpr (MotionLike<View>)
    return fault_of_arguments<F, T, FirstOf<View>&, FirstOf<View>&, FirstOf<View>&>();
  else if constexpr (FirstOrderLike<View>) return fault_of_arguments<F, T, FirstOf<View>&, FirstOf<View>&>();
  else return ForceFault::form;
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
  static_assert(
      fault != ForceFault::unused,
      "phistep: the force says uses_velocity = false or uses_time = false, and takes v or t: write f(r), f(y), or a "
      "struct with add(t, y, out)");
};

}}  // namespace phistep::PHISTEP_ABI

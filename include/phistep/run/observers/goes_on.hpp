/// @file
/// Calls what a user wants to happen at a time, and learns whether the run goes on.
#pragma once

#include <type_traits>
#include <utility>

#include "phistep/base/version.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// f is an observer that keeps what it sees, given as an lvalue where a copy is made: the copy would keep it.
template <class F>
inline constexpr bool copies_a_record = std::is_lvalue_reference_v<F>&& requires {
  typename std::remove_cvref_t<F>::KeepsStates;
};

/// f(args…); true where f returns nothing, or something true.
template <class F, class... Args>
[[nodiscard]] bool ask(F& f, Args&&... args) {
  if constexpr (std::is_void_v<std::invoke_result_t<F&, Args...>>) {
    f(std::forward<Args>(args)...);
    return true;
  } else {
    return static_cast<bool>(f(std::forward<Args>(args)...));
  }
}

/// The same for f(t, state), with a readable error.
template <class F, class Scalar, class S>
[[nodiscard]] bool goes_on(F& f, Scalar t, S& state) {
  static_assert(std::is_invocable_v<F&, Scalar, S&>,
                "phistep: this must be callable as f(t, state), returning nothing or false to end the run");
  if constexpr (!std::is_invocable_v<F&, Scalar, S&>) return false;
  else return ask(f, t, state);
}

}}  // namespace phistep::PHISTEP_ABI

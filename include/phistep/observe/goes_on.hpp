/// @file
/// Calls what a user wants to happen at a time, and learns whether the run goes on.
#pragma once

#include <type_traits>

#include "phistep/core/version.hpp"

namespace phistep::inline PHISTEP_ABI {

/// f(t, state); true where f returns nothing, or something true.
template <class F, class Scalar, class S>
[[nodiscard]] bool goes_on(F& f, Scalar t, S& state) {
  static_assert(std::is_invocable_v<F&, Scalar, S&>,
                "phistep: this must be callable as f(t, state), returning nothing or false to end the run");
  if constexpr (!std::is_invocable_v<F&, Scalar, S&>) {
    return false;
  } else if constexpr (std::is_void_v<std::invoke_result_t<F&, Scalar, S&>>) {
    f(t, state);
    return true;
  } else {
    return static_cast<bool>(f(t, state));
  }
}

}  // namespace phistep::inline PHISTEP_ABI

/// @file
/// The way back: what a stepper remembers of its history, and how it returns there.
#pragma once

#include <utility>

#include "phistep/core/version.hpp"

namespace phistep::inline PHISTEP_ABI {

template <class Stepper>
inline constexpr bool can_go_back = requires(Stepper& stepper) {
  stepper.restore(stepper.checkpoint());
};

/// Of a stepper that can't go back.
struct NoPast {};
template <class Stepper>
[[nodiscard]] auto past_of(const Stepper& stepper) {
  if constexpr (can_go_back<Stepper>) return stepper.checkpoint();
  else return NoPast{};
}
template <class Stepper>
using Past = decltype(past_of(std::declval<const Stepper&>()));

/// The stepper's history is again `past`, or starts anew. A past that is moved from makes it allocate nothing.
template <class Stepper, class PastOfIt>
void go_back(Stepper& stepper, [[maybe_unused]] PastOfIt&& past) {
  if constexpr (can_go_back<Stepper>) stepper.restore(std::forward<PastOfIt>(past));
  else if constexpr (requires { stepper.reset(); }) stepper.reset();
}

}  // namespace phistep::inline PHISTEP_ABI

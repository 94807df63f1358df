/// @file
/// One decision for all ranks that share a field: what one of them finds out by itself, an outcome, an exception, is told to all
/// before anything depends on it.
#pragma once

#include <exception>
#include <utility>

#include "phistep/core/outcome.hpp"
#include "phistep/core/version.hpp"
#include "phistep/state/blocks.hpp"

namespace phistep::inline PHISTEP_ABI {

/// The exception that a user's function has thrown on this rank. Its result there is NaN from then on, so that all ranks come
/// to the same end of the step, without a word more between them where all goes well. At that end it is thrown again, on this
/// rank; the others get Outcome::exception_elsewhere.
class HeldException {
 public:
  /// Runs f(); where it throws, now or in an earlier call, spoil().
  void run(auto&& f, auto&& spoil) noexcept {
    try {
      f();
    } catch (...) {
      if (!held_) held_ = std::current_exception();
    }
    if (held_) spoil();
  }
  [[nodiscard]] explicit operator bool() const { return static_cast<bool>(held_); }
  /// Throws what it holds, and holds it no more.
  void rethrow() {
    if (held_) std::rethrow_exception(std::exchange(held_, nullptr));
  }

 private:
  std::exception_ptr held_;
};

/// The largest of a number that every rank of a field's has; collective.
template <FieldState S>
[[nodiscard]] int most_of_ranks(const S& y, int mine) {
  const auto& first = std::get<0>(Blocks<S>::all(y));
  return std::remove_cvref_t<decltype(first)>::Ops::most(first.handle(), mine);
}
template <FieldState S>
[[nodiscard]] bool all_ranks(const S& y, bool mine) {
  return most_of_ranks(y, mine ? 0 : 1) == 0;
}

/// What all ranks make of what each of them found: the outcome that comes last in the enumeration.
template <FieldState S>
[[nodiscard]] Outcome agreed(const S& y, Outcome mine) {
  return static_cast<Outcome>(most_of_ranks(y, static_cast<int>(mine)));
}

}  // namespace phistep::inline PHISTEP_ABI

/// @file
/// One decision for all ranks that share a field: what one of them finds out by itself, an outcome, an exception, reaches all
/// before anything depends on it.
#pragma once

#include <algorithm>
#include <cmath>
#include <exception>
#include <limits>
#include <span>
#include <type_traits>
#include <utility>

#include "phistep/base/outcome/outcome.hpp"
#include "phistep/base/state/blocks.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// The exception that a user's function has thrown on this rank. Its result there is NaN from then on, so that all ranks come
/// to the same end of the step, without a word more between them where all goes well. At that end it is thrown again, on this
/// rank; the others get Outcome::exception_elsewhere. What a solver has failed with on this rank waits here likewise.
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
  /// A solver's outcome on this rank.
  void note(Outcome outcome) { noted_ = std::max(noted_, outcome); }
  /// What this rank knows that the others don't.
  [[nodiscard]] Outcome found() const { return held_ ? Outcome::exception_elsewhere : noted_; }
  /// All ranks know of it.
  void told() { noted_ = Outcome::success; }
  /// Throws what it holds, and holds it no more.
  void rethrow() {
    if (held_) std::rethrow_exception(std::exchange(held_, nullptr));
  }

 private:
  std::exception_ptr held_;
  Outcome noted_ = Outcome::success;
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

/// Each number becomes its sum over all ranks; collective.
template <FieldState S>
void total_of_ranks(const S& y, std::span<double> mine) {
  const auto& first = std::get<0>(Blocks<S>::all(y));
  std::remove_cvref_t<decltype(first)>::Ops::total(first.handle(), mine);
}

/// What all ranks make of what each of them found: the outcome that comes last in the enumeration.
template <FieldState S>
[[nodiscard]] Outcome agreed(const S& y, Outcome mine) {
  return static_cast<Outcome>(most_of_ranks(y, static_cast<int>(mine)));
}

/// On all ranks but the one where a function of the user's has thrown.
struct ThrownElsewhere {};

/// Whether f() is true on all ranks of a field's; collective. What it throws goes on, and on the other ranks ThrownElsewhere does.
template <State S>
[[nodiscard]] bool ask_all_ranks(const S& y, auto&& f) {
  if constexpr (!FieldState<S>) {
    return f();
  } else {
    bool mine = false;
    std::exception_ptr thrown;
    try {
      mine = f();
    } catch (...) {
      thrown = std::current_exception();
    }
    const int all = most_of_ranks(y, thrown ? 2 : mine ? 0 : 1);
    if (thrown) std::rethrow_exception(thrown);
    if (all == 2) throw ThrownElsewhere{};
    return all == 0;
  }
}
/// g(), a number that all ranks have alike: their largest, NaN where one of them is; collective, and throws likewise.
template <State S>
[[nodiscard]] auto same_on_ranks(const S& y, auto&& g) {
  if constexpr (!FieldState<S>) {
    return g();
  } else {
    decltype(g()) mine{};
    if (!ask_all_ranks(y, [&] { return !std::isnan(mine = g()); }))
      return std::numeric_limits<decltype(g())>::quiet_NaN();
    double all = static_cast<double>(mine);
    const auto& first = std::get<0>(Blocks<S>::all(y));
    std::remove_cvref_t<decltype(first)>::Ops::greatest(first.handle(), std::span<double>{&all, 1});
    return static_cast<decltype(g())>(all);
  }
}

}}  // namespace phistep::PHISTEP_ABI

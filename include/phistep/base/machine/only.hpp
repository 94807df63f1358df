/// @file
/// Members that a class has under a condition only.
#pragma once

#include <type_traits>

#include "phistep/base/version.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// Stands in for an absent member: takes any arguments of its constructor, and no space under [[no_unique_address]]. Two in
/// one object need different types for that: T and n tell them apart.
template <class T = void, int n = 0>
struct Absent {
  constexpr Absent() = default;
  constexpr explicit Absent(const auto&... /*any*/) {}
};

/// The type of a member: T if the condition holds.
///
///     [[no_unique_address]] Only<has_time, Rate> psi_t_;
template <bool condition, class T, int n = 0>
using Only = std::conditional_t<condition, T, Absent<T, n>>;

}}  // namespace phistep::PHISTEP_ABI

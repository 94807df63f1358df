/// @file
/// A workspace: what it holds from call to call saves work, and belongs to one owner.
#pragma once

#include "phistep/core/version.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// A T that is not copied along with its owner: the copy makes its own. Moving takes it along.
template <class T>
struct Scratch : T {
  Scratch() = default;
  Scratch(const Scratch&) : T{} {}
  Scratch(Scratch&&) noexcept = default;
  Scratch& operator=(const Scratch& other) {
    if (this != &other) static_cast<T&>(*this) = T{};
    return *this;
  }
  Scratch& operator=(Scratch&&) noexcept = default;
  ~Scratch() = default;
};

}}  // namespace phistep::PHISTEP_ABI

/// @file
/// What a norm says of an error: how large it is, and by which component.
#pragma once

#include <cmath>
#include <cstdint>

#include "phistep/base/version.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// A component of a state.
struct Component {
  std::int64_t block = -1, index = -1;
  friend bool operator==(const Component&, const Component&) = default;
};

/// A size, and the component that contributes most to it.
struct Measured {
  double square = 0;
  Component worst;
  [[nodiscard]] double size() const { return std::sqrt(square); }
};

}}  // namespace phistep::PHISTEP_ABI

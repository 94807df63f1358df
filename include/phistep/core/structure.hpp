/// @file
/// What couples to what in ∂Ψ/∂y: decides which matrix exists at all.
#pragma once

#include "phistep/core/version.hpp"

namespace phistep::inline PHISTEP_ABI {

/// Structure of a tangent, ordered so that the larger of two holds both.
enum class Structure {
  none,      ///< identically zero: a constant force
  diagonal,  ///< each component depends on itself only: linear drag
  dense,     ///< anything may depend on anything
  sparse,    ///< few entries a row: springs, grids
};

/// The structure of a sum.
[[nodiscard]] constexpr Structure combine(Structure a, Structure b) { return a < b ? b : a; }

}  // namespace phistep::inline PHISTEP_ABI

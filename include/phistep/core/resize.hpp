/// @file
/// Workspaces whose size changes a little from call to call.
#pragma once

#include <cstddef>

#include "phistep/core/version.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// v.resize(n), with 1/32 to spare where v needs other memory: by itself a vector takes twice as much as it had.
void resize_with_spare(auto& v, std::size_t n) {
  if (v.capacity() < n) v.reserve(n + n / 32);
  v.resize(n);
}

/// An empty v, whose memory others may have.
template <class V>
void release(V& v) {
  V{}.swap(v);
}

}}  // namespace phistep::PHISTEP_ABI

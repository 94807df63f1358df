/// @file
/// Serial numbers: what was made for one object is known by them not to belong to another.
#pragma once

#include <atomic>
#include <cstdint>

#include "phistep/base/version.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// A number that nothing else has had, whatever the thread.
[[nodiscard]] inline std::uint64_t next_serial() {
  static std::atomic<std::uint64_t> last{0};
  return ++last;
}

}}  // namespace phistep::PHISTEP_ABI

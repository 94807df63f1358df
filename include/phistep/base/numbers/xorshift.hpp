/// @file
/// Random directions and signs, the same on every machine: G. Marsaglia's xorshift (J. Stat. Softw. 8 (2003) 14).
#pragma once

#include <cstdint>

#include "phistep/base/version.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

class Xorshift {
 public:
  /// @param seed  not 0
  explicit Xorshift(std::uint64_t seed) : state_{seed} {}
  /// Uniform in [0, 1).
  [[nodiscard]] double number() { return static_cast<double>(next() >> 11) / 9007199254740992.0; }
  /// x or −x
  template <class Scalar>
  [[nodiscard]] Scalar sign(Scalar x) {
    return (next() & 1) != 0 ? x : -x;
  }

 private:
  std::uint64_t next() {
    state_ ^= state_ << 13, state_ ^= state_ >> 7, state_ ^= state_ << 17;
    return state_;
  }
  std::uint64_t state_;
};

}}  // namespace phistep::PHISTEP_ABI

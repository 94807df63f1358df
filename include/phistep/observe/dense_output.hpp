/// @file
/// The state between the two ends of a step, by Hermite's interpolation.
#pragma once

#include "phistep/core/version.hpp"
#include "phistep/state/blocks.hpp"

namespace phistep::inline PHISTEP_ABI {

/// The interpolant of one step. Slopes y' (blocks of S: for motion v and M⁻¹Ψ) are asked for once, at the first look.
template <State S>
class DenseOutput {
 public:
  using Scalar = ScalarOf<S>;
  using Plain = PlainState<S>;
  /// fill(self, slope at t0, slope at t1)
  struct Slopes {
    void* self = nullptr;
    void (*fill)(void*, Plain&, Plain&) = nullptr;
  };

  void begin(Scalar t0, Scalar dt, const Plain& start, const Plain& end, Slopes slopes) {
    t0_ = t0;
    dt_ = dt;
    start_ = &start;
    end_ = &end;
    slopes_ = slopes;
    known_ = false;
  }
  [[nodiscard]] const Plain& at(Scalar t);

 private:
  Scalar t0_{}, dt_{};
  const Plain* start_ = nullptr;
  const Plain* end_ = nullptr;
  Slopes slopes_;
  Plain slope0_, slope1_, value_;
  bool known_ = false;
};

}  // namespace phistep::inline PHISTEP_ABI

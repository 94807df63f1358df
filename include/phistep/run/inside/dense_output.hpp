/// @file
/// The state between the two ends of a step, by Hermite's interpolation (Hairer, Nørsett, Wanner I, II.6).
///
/// With x the fraction of the step h gone by, from y, y' at both ends (0 and 1), for every block
///
///     y(x) = y0 + x²(3−2x)(y1−y0) + h x(1−x)² y0' − h x²(1−x) y1'                        error ≤ h⁴ max|y⁗| / 384
///
/// and for the positions of a motion, where r, v = r' and a = v' are known,
///
///     r(x) = r0 + x³(10−15x+6x²)(r1−r0) + h x(1−x)³(1+3x) v0 − h x³(1−x)(4−3x) v1
///               + h² x²(1−x)³/2 a0 + h² x³(1−x)²/2 a1                                    error ≤ h⁶ max|r⁽⁶⁾| / 46080
///
/// Either is written from the nearer end, whose time differs from t without a rounding: so it meets both ends.
///
/// A scheme may be better than its interpolant: of higher order, or right where a stiff component makes of a small error a
/// large slope. Then a state inside is had by a step really done (run/inside/look_inside.hpp).
#pragma once

#include <functional>

#include "phistep/base/state/blocks.hpp"
#include "phistep/base/state/combination.hpp"
#include "phistep/base/state/unknowns.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// The interpolant of one step. Its slopes are asked for once, at the first time strictly inside. Allocates at most
/// then, and where sizes change.
template <State S>
class DenseOutput {
 public:
  using Scalar = ScalarOf<S>;
  using Plain = PlainState<S>;

  DenseOutput() {
    for (Plain* y : {&slope0_, &slope1_, &value_}) set_zero(Blocks<S>::all(*y));
  }

  /// The step from t0 to t0 + dt, whose end is called t1: on a grid t0 + nΔt that is not t0 + dt to the last bit. [time] Refers to
  /// all that it is given until the next one begins.
  /// @param slopes  slopes(y' at t0, y' at t0 + dt), shaped like the state, fills them. Of a motion's first block, the positions, y' is
  ///                neither asked nor used: that is v.
  template <class Slopes>
  void begin(Scalar t0, Scalar dt, Scalar t1, const Plain& start, const Plain& end, Slopes& slopes) {
    t0_ = t0;
    dt_ = dt;
    t1_ = t1;
    start_ = &start;
    end_ = &end;
    slopes_ = std::ref(slopes);
    known_ = false;
  }

  /// Strictly between the ends.
  [[nodiscard]] bool is_inside(Scalar t) const { return (t - t0_) / dt_ > 0 && (t1_ - t) / dt_ > 0; }
  /// The state at t; at the ends, and beyond, that of the end, bit for bit. Valid until the next call.
  [[nodiscard]] const Plain& at(Scalar t) {
    const Scalar from_start = (t - t0_) / dt_, to_end = (t1_ - t) / dt_;
    if (from_start <= 0) return *start_;
    if (to_end <= 0) return *end_;
    know_slopes();
    if (from_start <= to_end) interpolate(from_start, dt_, *start_, slope0_, *end_, slope1_);
    else interpolate(to_end, -dt_, *end_, slope1_, *start_, slope0_);  // the same step, run backward
    return value_;
  }

 private:
  void know_slopes() {
    if (known_) return;
    for (Plain* y : {&slope0_, &slope1_, &value_})
      for_each_block([](auto, auto& block, const auto& like) { set_shape_like(block, like); }, Blocks<S>::all(*y),
                     Blocks<S>::all(*start_));
    slopes_(slope0_, slope1_);
    known_ = true;
  }

  void interpolate(Scalar x, Scalar h, const Plain& from, const Plain& from_slope, const Plain& to,
                   const Plain& to_slope) {
    const Scalar z = 1 - x;
    const Scalar rise = x * x * (3 - 2 * x), near_rate = h * x * z * z, far_rate = -h * x * x * z;
    const auto y0 = in<S>(from), y1 = in<S>(to), d0 = in<S>(from_slope), d1 = in<S>(to_slope);
    assign_solved<S>(value_, y0 + rise * (y1 - y0) + near_rate * d0 + far_rate * d1);
    if constexpr (Blocks<S>::drifts) {
      const Scalar cube = x * x * x, drift = cube * (10 + x * (6 * x - 15));
      const Scalar near_drift = h * x * z * z * z * (1 + 3 * x), far_drift = -h * cube * z * (4 - 3 * x);
      const Scalar near_bend = h * h * x * x * z * z * z / 2, far_bend = h * h * cube * z * z / 2;
      const auto &r0 = position_of<S>(from), &r1 = position_of<S>(to), &v0 = velocity_of<S>(from),
                 &v1 = velocity_of<S>(to), &a0 = velocity_of<S>(from_slope), &a1 = velocity_of<S>(to_slope);
      position_of<S>(value_) =
          r0 + drift * (r1 - r0) + near_drift * v0 + far_drift * v1 + near_bend * a0 + far_bend * a1;
    }
  }

  Scalar t0_{}, dt_{}, t1_{};
  const Plain* start_ = nullptr;
  const Plain* end_ = nullptr;
  std::function<void(Plain&, Plain&)> slopes_;
  Plain slope0_, slope1_, value_;
  bool known_ = false;
};

}}  // namespace phistep::PHISTEP_ABI

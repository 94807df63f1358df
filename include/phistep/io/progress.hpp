/// @file
/// A progress line on a stream.
#pragma once

#include <chrono>
#include <cmath>
#include <ostream>

#include "phistep/core/version.hpp"

namespace phistep::inline PHISTEP_ABI {

/// An observer that writes the time reached, and with a known end the share done, a few times a second on one line.
class Progress {
 public:
  /// @param end  the run's t1 [time]; NaN if unknown
  explicit Progress(std::ostream& out, double end = std::nan("")) : out_{&out}, end_{end} {}

  template <class Scalar, class S>
  void operator()(Scalar t, const S& /*state*/) {
    const double now = static_cast<double>(t);
    const auto clock = std::chrono::steady_clock::now();
    const bool done = now == end_;
    if (first_) start_ = now, first_ = false;
    else if (!done && clock - shown_ < std::chrono::milliseconds(200)) return;
    shown_ = clock;
    *out_ << "\r  t = " << now;
    if (std::isfinite(end_) && end_ != start_)
      *out_ << "  " << std::lround(100 * (now - start_) / (end_ - start_)) << " %  ";
    if (done) *out_ << '\n';
    out_->flush();
  }

 private:
  std::ostream* out_;
  double end_, start_ = 0;
  std::chrono::steady_clock::time_point shown_;
  bool first_ = true;
};

/// `integrate(…, progress(std::cerr, t1))`
[[nodiscard]] inline Progress progress(std::ostream& out, double end = std::nan("")) { return Progress{out, end}; }

}  // namespace phistep::inline PHISTEP_ABI

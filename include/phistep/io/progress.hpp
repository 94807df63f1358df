/// @file
/// A progress line on a stream.
#pragma once

#include <algorithm>
#include <chrono>
#include <cmath>
#include <iostream>
#include <ostream>
#if __has_include(<unistd.h>)
#include <unistd.h>
#elif __has_include(<io.h>)
#include <io.h>
#endif

#include "phistep/core/version.hpp"

namespace phistep::inline PHISTEP_ABI {

/// Whether a stream is std::cout, std::cerr or std::clog and ends at a terminal: not in a file, a pipe, a job's log.
[[nodiscard]] inline bool is_terminal(const std::ostream& out) {
  const bool is_out = out.rdbuf() == std::cout.rdbuf();
  if (!is_out && out.rdbuf() != std::cerr.rdbuf() && out.rdbuf() != std::clog.rdbuf()) return false;
#if __has_include(<unistd.h>)
  return ::isatty(is_out ? 1 : 2) != 0;
#elif __has_include(<io.h>)
  return ::_isatty(is_out ? 1 : 2) != 0;
#else
  return false;
#endif
}

/// An observer that writes the time reached and, with a known end, the share done: on a terminal in one line that it
/// renews a few times a second; elsewhere a line for every tenth done, without a known end whenever the run has become twice
/// as old.
class Progress {
 public:
  /// @param end       the run's t1 [time]; NaN if unknown
  /// @param terminal  whether out is one
  explicit Progress(std::ostream& out, double end = std::nan("")) : Progress{out, end, is_terminal(out)} {}
  Progress(std::ostream& out, double end, bool terminal) : out_{&out}, end_{end}, terminal_{terminal} {}

  template <class Scalar, class S>
  void begin(Scalar /*t*/, const S& /*state*/) {
    first_ = true;
  }
  template <class Scalar, class S>
  void operator()(Scalar t, const S& /*state*/) {
    const double now = static_cast<double>(t);
    const auto clock = Clock::now();
    const bool done = now == end_;
    if (first_) start_ = now, began_ = clock, tenths_ = 0, due_ = clock;
    const double share = std::isfinite(end_) && end_ != start_ ? (now - start_) / (end_ - start_) : std::nan("");
    if (!first_ && !done && !is_due(share, clock)) return;
    first_ = false;
    tenths_ = std::floor(10 * share);
    due_ = terminal_ ? clock + std::chrono::milliseconds(200)
                     : clock + std::max<Clock::duration>(clock - began_, std::chrono::seconds(1));
    *out_ << (terminal_ ? "\r  t = " : "  t = ") << now;
    if (std::isfinite(share)) *out_ << "  " << std::lround(100 * share) << (terminal_ ? " %  " : " %");
    if (done || !terminal_) *out_ << '\n';
    out_->flush();
  }

 private:
  using Clock = std::chrono::steady_clock;

  [[nodiscard]] bool is_due(double share, Clock::time_point clock) const {
    return terminal_ || !std::isfinite(share) ? clock >= due_ : 10 * share >= tenths_ + 1;
  }

  std::ostream* out_;
  double end_, start_ = 0, tenths_ = 0;
  Clock::time_point began_, due_;
  bool terminal_, first_ = true;
};

/// `integrate(…, progress(std::cerr, t1))`
[[nodiscard]] inline Progress progress(std::ostream& out, double end = std::nan("")) { return Progress{out, end}; }

}  // namespace phistep::inline PHISTEP_ABI

/// @file
/// How far a run has come, on a terminal or in a log.
#pragma once

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <functional>
#include <iostream>
#include <ostream>
#include <string>
#include <utility>
#if __has_include(<unistd.h>)
#include <unistd.h>
#elif __has_include(<io.h>)
#include <io.h>
#endif

#include "phistep/base/version.hpp"
#include "phistep/io/text.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

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

/// Seconds as 0:07, 12:34 or 1:02:03.
[[nodiscard]] inline std::string clock_text(double seconds) {
  const auto whole = static_cast<long long>(std::clamp(seconds, 0.0, 1e15) + 0.5);
  const auto two = [](long long n) { return (n < 10 ? "0" : "") + std::to_string(n); };
  const std::string minutes =
      whole < 3600 ? std::to_string(whole / 60) : std::to_string(whole / 3600) + ':' + two(whole / 60 % 60);
  return minutes + ':' + two(whole % 60);
}

/// An observer that shows how far a run has come. With a known end, on a terminal, one line that is renewed five times a
/// second, and elsewhere (a file, a pipe, a job's log) ten lines, one for each tenth done:
///
///     [==========>             ]  43 %  t = 4.31  dt = 0.005  0:07 left
///
///     20 %  t = 2.005  dt = 0.005  0:10 left
///     30 %  t = 3  dt = 0.005  0:09 left
///     …
///     100 %  t = 10  dt = 0.005  took 0:13
///
/// The time left supposes that what remains is as much work for each unit of t as what is done. dt is how far t has come
/// since the last call: the step's length, where the observer is shown every step. Without a known end it writes the time
/// reached: on a terminal in one line, elsewhere whenever the run has become twice as old.
class Progress {
 public:
  using Clock = std::function<double()>;

  /// @param end  the run's t1 [time]; NaN if unknown
  explicit Progress(std::ostream& out, double end = std::nan("")) : Progress{out, end, is_terminal(out)} {}
  /// @param terminal  whether out is one
  /// @param clock     seconds since any moment; for tests
  Progress(std::ostream& out, double end, bool terminal, Clock clock = seconds)
      : out_{&out}, end_{end}, terminal_{terminal}, clock_{std::move(clock)} {}

  template <class Scalar, class S>
  void begin(Scalar /*t*/, const S& /*state*/) {
    first_ = true;
  }
  template <class Scalar, class S>
  void operator()(Scalar t, const S& /*state*/) {
    look(static_cast<double>(t), clock_());
  }

 private:
  [[nodiscard]] static double seconds() {
    return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
  }

  void look(double t, double clock) {
    if (first_) start_ = last_ = t, began_ = due_ = clock, tenths_ = 0, width_ = 0, is_done_ = false;
    const bool is_known = std::isfinite(end_) && end_ != start_;
    const double share = is_known ? (t - start_) / (end_ - start_) : 0, dt = t - last_;
    const bool done = is_known && share + rounding >= 1;
    if (done && std::exchange(is_done_, done)) return;
    last_ = t;
    const bool is_due = terminal_ || !is_known ? clock >= due_ : 10 * share + rounding >= tenths_ + 1;
    const bool is_first = std::exchange(first_, false);
    if (!is_due && !done) return;
    tenths_ = std::floor(10 * share + rounding);
    due_ = clock + (terminal_ ? 0.2 : std::max(clock - began_, 1.0));
    std::string line = is_known ? share_text(share) : "  t = " + number(t);
    if (is_known) {
      line += "  t = " + number(t);
      if (!is_first) line += "  dt = " + number(dt);
      if (done) line += "  took " + clock_text(clock - began_);
      else if (share > 0) line += "  " + clock_text((clock - began_) * (1 - share) / share) + " left";
    }
    write(line, done);
  }
  [[nodiscard]] std::string share_text(double share) const {
    const double s = std::clamp(share, 0.0, 1.0);
    const std::string percent = std::to_string(std::lround(std::floor(100 * s + rounding))) + " %";
    if (!terminal_) return "  " + percent;
    const auto full = static_cast<std::size_t>(static_cast<double>(bar) * s + rounding);
    std::string text = "  [" + std::string(full, '=') + (full < bar ? ">" : "");
    text.append(full < bar ? bar - full - 1 : 0, ' ');
    return text + "]" + std::string(percent.size() < 5 ? 6 - percent.size() : 1, ' ') + percent;
  }
  [[nodiscard]] static std::string number(double x) {
    std::string text;
    append_number(text, x, 6);
    return text;
  }
  /// A shorter line on a terminal covers the longer one before.
  void write(std::string line, bool done) {
    const std::size_t width = std::exchange(width_, line.size());
    if (terminal_) {
      line.append(line.size() < width ? width - line.size() : 0, ' ');
      line.insert(0, 1, '\r');
    }
    *out_ << line;
    if (done || !terminal_) *out_ << '\n';
    out_->flush();
  }

  static constexpr std::size_t bar = 24;
  static constexpr double rounding = 1e-9;  // a step that ends at a tenth may miss it by its last bits

  std::ostream* out_;
  double end_;
  bool terminal_, first_ = true, is_done_ = false;
  Clock clock_;
  double start_ = 0, last_ = 0, began_ = 0, due_ = 0, tenths_ = 0;
  std::size_t width_ = 0;
};

/// `integrate(…, progress(std::cerr, t1))`
[[nodiscard]] inline Progress progress(std::ostream& out, double end = std::nan("")) { return Progress{out, end}; }

}}  // namespace phistep::PHISTEP_ABI

#pragma once

#include <phistep/all.hpp>

#include <cmath>
#include <cstdio>

namespace answers {

inline int wrong = 0, asked = 0;

/// |value − expected| ≤ allowed, and no NaN.
inline void answer(const char* name, double value, double expected, double allowed) {
  const bool right = std::abs(value - expected) <= allowed;
  std::printf("%-44s %a\n", name, value);
  ++asked;
  if (right) return;
  ++wrong;
  std::fprintf(stderr, "WRONG %s: %.17g, not %.17g within %g\n", name, value, expected, allowed);
}
inline void answer(const char* name, bool value) { answer(name, value ? 1 : 0, 1, 0); }
/// A failed run must not pass for an inaccurate one.
inline phistep::Statistics good(const phistep::RunReport& report) {
  if (!report) std::fprintf(stderr, "%s\n", report.message().c_str()), ++wrong;
  return report.statistics;
}
[[nodiscard]] inline int result() {
  std::fprintf(stderr, "%d answers, %d wrong\n", asked, wrong);
  return wrong == 0 ? 0 : 1;
}

}  // namespace answers

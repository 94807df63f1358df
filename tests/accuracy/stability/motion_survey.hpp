#pragma once

// A survey of the atlas for motion: all cells of all subjects, and their limits.

#include <cmath>
#include <cstdint>
#include <cstdio>
#include <map>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "accuracy/stability/motion_subjects.hpp"
#include "accuracy/stability/report.hpp"
#include "support/catch.hpp"
#include "support/figures.hpp"

namespace stability::motion {

inline void survey(const std::vector<Entry>& subjects, const std::string& claim) {
  Tally all;
  std::int64_t different = 0;
  std::map<std::string, Tally> families;
  for (const auto& [family, a_most, subject] : subjects) {
    Tally mine = over_grid(subject, family == "pairs" ? 100 : 200, a_most);
    mine += over_decades(subject, 4, different);
    std::ostringstream line;
    line << subject.name << ": " << mine.cells << " cells, " << mine.within << " within their bounds (worst "
         << mine.worst << "; " << mine.roundings << " u)";
    if (subject.symplectic) line << ", area to " << mine.area;
    tell(mine, line);
    families[family] += mine;
    all += mine;
  }
  for (const auto& [family, tally] : families)
    figures::told(tally.roundings, "atlas, motion: " + family, "error in u max(1, |P|), zeta <= 2");
  tell(all, different, claim);
}

/// How far an undamped oscillation doesn't grow, by steps taken and by theory.
inline void read_off(const Subject& subject, double published = NAN) {
  Subject by_theory = subject;
  by_theory.step = [R = subject.R](double k, double c, int) {
    Step step;
    step.P = R(k, c);
    return step;
  };
  const double most = limit(subject), expected = limit(by_theory);
  std::printf("  %-36s undamped up to a = %9.6g, theory %9.6g\n", subject.name.c_str(), most, expected);
  CAPTURE(subject.name, most, expected);
  const auto near = [](double x, double y) {
    return std::isinf(y) ? std::isinf(x) : std::abs(x - y) <= 1e-3 * (y + 0.1);
  };
  if (subject.name.find("phi") == std::string::npos && !std::isinf(most))
    figures::told(most, "atlas, motion: " + subject.name, "largest omega dt without growth");
  CHECK(near(most, expected));
  if (!std::isnan(published)) CHECK(near(most, published));
}

}  // namespace stability::motion

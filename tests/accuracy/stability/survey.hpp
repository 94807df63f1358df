#pragma once

// A survey of the atlas, first order: all cells of all subjects, and what is read off the map.

#include <cmath>
#include <cstdint>
#include <cstdio>
#include <iostream>
#include <limits>
#include <map>
#include <sstream>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "accuracy/stability/amplification.hpp"
#include "accuracy/stability/report.hpp"
#include "accuracy/stability/subjects.hpp"
#include "support/catch.hpp"
#include "support/figures.hpp"

namespace stability {

inline void survey(const std::vector<Entry>& subjects, const std::string& claim) {
  Tally all;
  std::int64_t different = 0;
  std::map<std::string, Tally> families;
  for (const auto& [family, spacing, subject] : subjects) {
    Tally mine = over_grid(subject, 200, spacing);
    mine += over_decades(subject, 4, different);
    mine += around_poles(subject);
    std::ostringstream line;
    line << subject.name << ": " << mine.cells << " cells, " << mine.within << " within their bounds (worst "
         << mine.worst << "; " << mine.roundings << " u)";
    tell(mine, line);
    families[family] += mine;
    all += mine;
  }
  for (const auto& [family, tally] : families)
    figures::told(tally.roundings, "atlas: " + family, "error in u max(1, |R|), Re z <= 0");
  tell(all, different, claim);
}

/// What the literature says of a scheme; NaN: nothing.
struct Published {
  double alpha = NAN;     ///< of its A(α), in degrees
  double infinity = NAN;  ///< |R(∞)|
  double order = NAN;     ///< on y' = λy
};

/// Sector, far end, axes and order of a subject, found by taking steps, beside what its R gives in the same way, and beside
/// what is published.
inline void read_off(const Subject& subject, const Published& published = {}) {
  Subject by_theory = subject;
  by_theory.step = [R = subject.R](Point lambda, double) {
    const Complex z{lambda.real(), lambda.imag()};
    return Step{Outcome::success, R(z), true, {}};
  };
  const double alpha = sector(subject), infinity = at_infinity(subject), imaginary = reach(subject, 90),
               real = reach(subject, 0), order = order_seen(subject);
  std::printf("  %-36s alpha %8.4f  |R(inf)| %9.3g  imaginary axis %9.5g  real axis %9.5g  order %.2f\n",
              subject.name.c_str(), alpha, infinity, imaginary, real, order);
  const auto near = [](double x, double y, double by) {
    return std::isinf(y) ? std::isinf(x) : std::abs(x - y) <= by * (1 + std::abs(y));
  };
  CAPTURE(subject.name, alpha, infinity, imaginary, real, order);
  CHECK(near(alpha, sector(by_theory), 1e-4));
  CHECK(near(imaginary, reach(by_theory, 90), 0.01));
  CHECK(near(real, reach(by_theory, 0), 1e-6));
  CHECK(near(infinity, at_infinity(by_theory), 1e-9));
  if (!std::isnan(published.alpha)) CHECK(std::abs(alpha - published.alpha) <= 0.01);
  if (!std::isnan(published.infinity)) CHECK(near(infinity, published.infinity, 1e-9));
  if (!std::isnan(published.order)) CHECK(std::abs(order - published.order) <= 0.2);
}
[[nodiscard]] inline const Subject& named(const std::vector<Entry>& subjects, const std::string& name) {
  for (const Entry& entry : subjects)
    if (entry.subject.name == name) return entry.subject;
  throw std::invalid_argument("no subject " + name);
}

}  // namespace stability

#pragma once

// A figure is a measured number with its limit: a CHECK, a line on the terminal, and a row of the stress run's summary.

#include <cstdlib>
#include <fstream>
#include <iomanip>
#include <iostream>
#include <sstream>
#include <string>

#include "support/catch.hpp"

namespace figures {

/// One row "claim | quantity | measured | limit | verdict", also appended to the file that PHISTEP_FIGURES names.
inline void row(const std::string& claim, const std::string& quantity, const std::string& measured,
                const std::string& limit, bool holds) {
  const std::string line =
      claim + " | " + quantity + " | " + measured + " | " + limit + " | " + (holds ? "holds" : "BROKEN");
  std::cout << line << std::endl;
  if (const char* path = std::getenv("PHISTEP_FIGURES")) std::ofstream{path, std::ios::app} << line << '\n';
}

[[nodiscard]] inline std::string text(double x) {
  std::ostringstream out;
  out << std::setprecision(3) << x;
  return out.str();
}

/// measured ≤ limit, and no NaN.
inline void at_most(double limit, double measured, const std::string& claim, const std::string& quantity) {
  const bool holds = measured <= limit;
  row(claim, quantity, text(measured), "<= " + text(limit), holds);
  CAPTURE(claim, quantity, measured, limit);
  CHECK(holds);
}
/// low ≤ measured ≤ high.
inline void between(double low, double high, double measured, const std::string& claim, const std::string& quantity) {
  const bool holds = low <= measured && measured <= high;
  row(claim, quantity, text(measured), text(low) + " ... " + text(high), holds);
  CAPTURE(claim, quantity, measured, low, high);
  CHECK(holds);
}
/// A number worth telling that nothing is promised about.
inline void told(double measured, const std::string& claim, const std::string& quantity) {
  row(claim, quantity, text(measured), "-", true);
}
/// Progress of something long, on one line of its own.
inline void progress(const std::string& what) { std::cout << "  ... " << what << std::endl; }

}  // namespace figures

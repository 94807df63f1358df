/// @file
/// What a battery has found: check_scheme.hpp, check_state.hpp, check_pair_law.hpp.
#pragma once

#include <cstdio>
#include <ostream>
#include <string>
#include <vector>

#include "phistep/base/version.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// One line for each check. Contextually true where all hold.
struct BatteryReport {
  struct Line {
    bool holds;
    std::string text;  ///< what was checked, and the figures
  };
  std::vector<Line> lines{};  ///< in the order of the checks

  /// @param text  where there are figures, a format of printf for them
  void check(bool holds, const std::string& text, auto... figures) {
    if constexpr (sizeof...(figures) == 0) {
      lines.push_back({holds, text});
    } else {
      char line[200];
      std::snprintf(line, sizeof line, text.c_str(), figures...);
      lines.push_back({holds, line});
    }
  }
  [[nodiscard]] explicit operator bool() const {
    for (const Line& line : lines)
      if (!line.holds) return false;
    return !lines.empty();
  }
  friend std::ostream& operator<<(std::ostream& out, const BatteryReport& report) {
    for (const Line& line : report.lines) out << (line.holds ? "holds   " : "BROKEN  ") << line.text << '\n';
    return out;
  }
};

}}  // namespace phistep::PHISTEP_ABI

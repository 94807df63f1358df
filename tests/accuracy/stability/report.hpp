#pragma once

// What a survey of the atlas tells: of one subject a line, of all a claim's rows. Both maps have the same kind of tally.

#include <cstdint>
#include <sstream>
#include <string>

#include "support/catch.hpp"
#include "support/figures.hpp"

namespace stability {

void tell(const auto& subject, std::ostringstream& line) {
  for (const auto& [reason, count] : subject.explained) line << ", " << reason << " " << count;
  if (subject.unexplained > 0) line << ", UNEXPLAINED " << subject.unexplained << ": " << subject.first;
  figures::progress(line.str());
}

/// @param different  cells whose bits depend on the unit of time
void tell(const auto& all, std::int64_t different, const std::string& claim) {
  for (const auto& [reason, count] : all.explained)
    figures::told(static_cast<double>(count), claim, "cells explained: " + reason);
  figures::at_most(0, static_cast<double>(all.unexplained), claim,
                   "cells not explained, of " + std::to_string(all.cells));
  figures::at_most(0, static_cast<double>(all.harmed), claim, "states changed by a refused step");
  figures::at_most(0, static_cast<double>(different), claim, "cells whose bits depend on the unit of time");
  figures::at_most(1, all.worst, claim, "largest error / its bound");
  CAPTURE(all.first);
  CHECK(all.unexplained == 0);
}

}  // namespace stability

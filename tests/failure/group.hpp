#pragma once

// A group of scenarios, told as one: how many runs had a failure, and how often it went wrong.

#include <string>
#include <vector>

#include "failure/faults.hpp"
#include "support/figures.hpp"

namespace faults {

struct Group {
  std::string name;
  Tally all{};

  void add(const char* label, const Make& make, Site site, const std::vector<Kind>& kinds, const Promise& promise,
           long stride = 1) {
    figures::progress(label);
    const Tally one = every_call(label, make, site, kinds, promise, stride);
    INFO(one.first);
    CHECK(one.clean());
    all += one;
  }
  void tell() const {
    INFO(all.first);
    figures::told(static_cast<double>(all.runs), name + ": runs with a failure", "runs");
    figures::told(static_cast<double>(all.failures), name + ": steps that failed", "steps");
    figures::at_most(0, static_cast<double>(all.changed), name + ": state changed by a failed step", "runs");
    figures::at_most(0, static_cast<double>(all.untold), name + ": wrong outcome or no t, dt, advice", "runs");
    figures::at_most(0, static_cast<double>(all.stuck), name + ": could not go on", "runs");
    figures::at_most(0, static_cast<double>(all.otherwise), name + ": went on to another end", "runs");
  }
};

}  // namespace faults

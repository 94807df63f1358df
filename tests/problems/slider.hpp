#pragma once

#include <phistep/phistep.hpp>

#include <algorithm>

namespace problems {

/// A force with a history: slides where the pull is too strong.
struct Slider : phistep::ForceTerm {
  static constexpr const char* name = "slider";
  struct Memory {
    Eigen::VectorXd anchor;
    void archive(auto& ar) { ar(anchor); }
  };
  static constexpr bool uses_velocity = false, uses_time = false;
  static void begin(double, double, const auto& y, Memory& m) {
    if (m.anchor.size() == 0) m.anchor = y.r;
  }
  static void add(double, const auto& y, const Memory& m, auto& out) { out.force -= 30 * (y.r - m.anchor); }
  static void commit(double, const auto& y, Memory& m) {
    for (Eigen::Index i = 0; i < y.r.size(); ++i) m.anchor[i] = std::clamp(m.anchor[i], y.r[i] - 0.05, y.r[i] + 0.05);
  }
};

}  // namespace problems

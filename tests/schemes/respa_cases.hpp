#pragma once

// Slow terms with histories, for the quick and the full tests of them.
#include <phistep/force/seldom.hpp>
#include <phistep/phistep.hpp>
#include <phistep/schemes/respa.hpp>

#include <algorithm>

#include "contract/states.hpp"
#include "failure/faults.hpp"

namespace respa_cases {

using namespace phistep;
using Vec = Eigen::VectorXd;

/// Friction by an anchor that follows; tells what was done with it.
struct Slider : ForceTerm {
  static constexpr const char* name = "slider";
  struct Memory {
    Vec anchor;
    int begins = 0, commits = 0;
    double last_dt = 0, last_end = 0;
    void archive(auto& ar) {
      ar("anchor", anchor, "begins", begins, "commits", commits, "last_dt", last_dt, "last_end", last_end);
    }
  };
  static constexpr bool uses_velocity = false, uses_time = false;
  static void begin(double, double dt, const auto& y, Memory& m) {
    if (m.anchor.size() == 0) m.anchor = y.r;
    ++m.begins, m.last_dt = dt;
  }
  static void add(double, const auto& y, const Memory& m, auto& out) {
    out.force += faults::struck<Vec>(faults::Site::force, Vec(-30 * (y.r - m.anchor)));
  }
  static void commit(double t, const auto& y, Memory& m) {
    for (Eigen::Index i = 0; i < y.r.size(); ++i) m.anchor[i] = std::clamp(m.anchor[i], y.r[i] - 0.05, y.r[i] + 0.05);
    ++m.commits, m.last_end = t;
  }
};
/// A slow force that keeps a list, as pairs do: work saved, and no history.
struct Listed : ForceTerm {
  static constexpr const char* name = "listed";
  struct Memory {
    static constexpr bool is_cache = true;
    double since = 0, last_dt = 0;
    int age = 0;
    void archive(auto& ar) { ar("since", since, "last_dt", last_dt, "age", age); }
  };
  static constexpr bool uses_velocity = false, uses_time = false;
  static void begin(double t, double dt, const auto&, Memory& m) { m.since = t, m.last_dt = dt; }
  static void add(double, const auto& y, const Memory&, auto& out) {
    out.force += faults::struck<Vec>(faults::Site::force, Vec(-y.r.array().sin()));
  }
  static void commit(double, const auto&, Memory& m) { ++m.age; }
};
inline const auto six = [] { return states::SecondOrder<Vec>{}.state; };
inline Vec pull(const Vec& r) { return faults::struck<Vec>(faults::Site::force, Vec(-5 * r)); }
inline const auto sliding = [](const auto& y) {
  return PhiStepper{y, Slider{} + term(pull) + seldom(2, Listed{}) + seldom(4, pull), velocity_verlet};
};

}  // namespace respa_cases

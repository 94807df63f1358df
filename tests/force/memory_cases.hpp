// What memory.test.cpp and memory.full.cpp share.
#pragma once

#include <phistep/phistep.hpp>

#include <cmath>
#include <stdexcept>
#include <tuple>

#include "contract/states.hpp"
#include "support/catch.hpp"

using namespace phistep;
using states::Dynamic;

namespace memory_cases {

/// A slider: it pulls back to an anchor that follows once the stretch exceeds `slip`.
struct Slider : ForceTerm {
  struct Memory {
    Dynamic anchor;
    double begun_at = -1, begun_dt = 0;
    int begins = 0, commits = 0;
  };
  double k = 30, slip = 0.2, poison = HUGE_VAL;  // |r| beyond `poison` gives NaN
  bool armed = false;                            // to throw at the end of a step
  static constexpr bool uses_velocity = false, uses_time = false;

  void begin(double t, double dt, const auto& y, Memory& m) const {
    if (m.anchor.size() == 0) m.anchor = y.r;
    m.begun_at = t, m.begun_dt = dt, ++m.begins;
  }
  void add(double, const auto& y, const Memory& m, auto& out) const {
    out.force -= k * (y.r - m.anchor);
    if (y.r.cwiseAbs().maxCoeff() > poison) out.force[0] = std::nan("");
  }
  void commit(double, const auto& y, Memory& m) const {
    for (Eigen::Index i = 0; i < y.r.size(); ++i) m.anchor[i] = std::clamp(m.anchor[i], y.r[i] - slip, y.r[i] + slip);
    ++m.commits;
    if (armed) throw std::runtime_error("commit");
  }
};

using Vec = Eigen::Vector2d;
inline Motion<Vec> start() { return {Vec(0.1, 0.1), Vec(1.0, -2.0)}; }

/// After five steps.
inline void check_fifth(const char* name, const Slider::Memory& memory) {
  CAPTURE(name);
  CHECK(memory.begins == 5);
  CHECK(memory.commits == 5);
  CHECK(memory.begun_at == 0.4);
  CHECK(memory.begun_dt == 0.1);
}
inline void for_each_quick_scheme(auto&& f) { f("trapezoidal", trapezoidal), f("velocity_verlet", velocity_verlet); }
inline bool same(const Slider::Memory& a, const Slider::Memory& b) {
  return a.anchor == b.anchor && a.begins == b.begins && a.commits == b.commits && a.begun_at == b.begun_at;
}

}  // namespace memory_cases

#pragma once

// What the quick and the full half of step/step_doubling share.
#include <phistep/phistep.hpp>

#include <cmath>
#include <cstring>
#include <stdexcept>
#include <vector>

#include "contract/states.hpp"
#include "problems/forced.hpp"
#include "problems/march.hpp"
#include "support/catch.hpp"

using namespace phistep;
using problems::distance;
using states::numbers, states::same_bits;
using Flow = problems::ForcedFlow<>;
using Swing = problems::ForcedMotion<>;
using Vec = Eigen::Vector2d;

namespace step_doubling_cases {

inline const auto yes = [](const auto&...) { return true; };
inline const auto no = [](const auto&...) { return false; };

template <class S>
bool same_trace(const Trace<S>& a, const Trace<S>& b) {
  // What later steps read: `start` and `before` where they are known.
  if (a.knows_start != b.knows_start || a.dt_before != b.dt_before) return false;
  if (a.knows_start && !same_bits(numbers(a.start), numbers(b.start))) return false;
  return a.dt_before == 0 || same_bits(numbers(a.before), numbers(b.before));
}

/// A force with memory: it remembers the path length, and is weakened by it. It throws, or is no number, at a given call.
struct Worn {
  struct Memory {
    double length = 0;
    Vec last = Vec::Zero();
  };
  static constexpr bool uses_time = false;
  int* calls;
  int* fatal;
  bool* throws;
  void begin(double, double, const auto& y, Memory& m) const { m.last = y.y; }
  void add(double, const auto& y, const Memory& m, auto& out) const {
    if (++*calls == *fatal) {
      if (*throws) throw std::runtime_error("worn out");
      out.rate[0] += std::nan("");
    }
    out.rate += -y.y / (1 + m.length + (y.y - m.last).norm());
  }
  void commit(double, const auto& y, Memory& m) const {
    m.length += (y.y - m.last).norm();
    m.last = y.y;
  }
};

}  // namespace step_doubling_cases

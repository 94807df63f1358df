#pragma once

// What the quick and the full half of step/halving share.
#include <phistep/phistep.hpp>

#include <cmath>
#include <sstream>
#include <stdexcept>
#include <vector>

#include "contract/states.hpp"
#include "problems/march.hpp"
#include "support/catch.hpp"

using namespace phistep;
using Vec = Eigen::VectorXd;

namespace halving_cases {

/// A stepper that moves the state by dt, and fails where `bad(t, dt)` says so.
template <class Bad>
struct Picky {
  Bad bad;
  Outcome with = Outcome::newton_diverged;
  std::vector<double> done{};  // t, dt of every step that succeeded
  Statistics counts{};
  Failure last{};
  StepReport step(Vec& y, double t, double dt) {
    if (bad(t, dt)) {
      ++counts.failed_steps;
      last.outcome = with, last.t = t, last.dt = dt;
      return {with, 3, &last};
    }
    ++counts.steps;
    done.insert(done.end(), {t, dt});
    y.array() += dt;
    return {Outcome::success, 2, nullptr};
  }
  [[nodiscard]] const Statistics& statistics() const { return counts; }
  [[nodiscard]] static int order() { return 1; }
  void reset() {}
};
template <class Bad>
Picky(Bad) -> Picky<Bad>;
template <class Bad>
Picky(Bad, Outcome) -> Picky<Bad>;

/// Sticks where it has moved to; throws or gives a NaN when told, beyond a time.
struct Sticky : ForceTerm {
  struct Memory {
    Vec anchor;
    int commits = 0;
  };
  const double* nan_after;
  const double* throw_after;
  static constexpr bool uses_velocity = false;
  Sticky(const double* a, const double* b) : nan_after(a), throw_after(b) {}
  void begin(double, double, const auto& y, Memory& m) const {
    if (m.anchor.size() == 0) m.anchor = y.r;
  }
  void add(double t, const auto& y, const Memory& m, auto& out) const {
    if (t > *throw_after) throw std::runtime_error("sticky");
    out.force -= 10 * (y.r - m.anchor);
    if (t > *nan_after) out.force[0] = std::nan("");
  }
  void commit(double, const auto& y, Memory& m) const {
    m.anchor = y.r;
    ++m.commits;
  }
};

}  // namespace halving_cases

#pragma once

// What the quick and the full half of run/stepper/halving share.
#include <phistep/phistep.hpp>

#include <cmath>
#include <stdexcept>

#include "contract/states.hpp"
#include "problems/march.hpp"
#include "support/catch.hpp"

using namespace phistep;
using Vec = Eigen::VectorXd;

namespace halving_cases {

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

template <class V>
void check_final_failure(Motion<V> y) {
  double nan_after = HUGE_VAL, throw_after = HUGE_VAL;
  Halving stepper{PhiStepper{y, Sticky{&nan_after, &throw_after}, trapezoidal}, 3};
  problems::step(stepper, y, 0.0, 0.1);
  const Eigen::VectorXd before = states::numbers(y);
  const auto memory = stepper.stepper().memory();
  const auto unharmed = [&] {
    return states::same_bits(states::numbers(y), before) && stepper.stepper().memory().anchor == memory.anchor &&
           stepper.stepper().memory().commits == memory.commits;
  };

  nan_after = 0.16;  // the first half of 0.1 … 0.2 goes well
  const StepReport report = stepper.step(y, 0.1, 0.1);
  CHECK(report.outcome() == Outcome::non_finite_force);
  CHECK(report.failure().dt == Approx(0.1 / 8));
  CHECK(unharmed());
  const Statistics inner = stepper.stepper().statistics();
  CHECK(inner.steps > 1);  // some parts did succeed, and were taken back
  CHECK(stepper.statistics().steps == 1);
  CHECK(stepper.statistics().halvings == 0);

  nan_after = 0.19, throw_after = 0.17;
  CHECK_THROWS_AS(stepper.step(y, 0.1, 0.1), std::runtime_error);
  CHECK(unharmed());
  nan_after = throw_after = HUGE_VAL;

  // From there it goes on as one that never failed.
  auto z = y;
  PhiStepper fresh{z, Sticky{&nan_after, &throw_after}, trapezoidal};
  fresh.set_memory(memory);
  problems::step(stepper, y, 0.1, 0.1);
  problems::step(fresh, z, 0.1, 0.1);
  CHECK(problems::distance(y, z) <= 1e-15);
}

}  // namespace halving_cases

// What memory.test.cpp and memory.full.cpp share.
#pragma once

#include "failure/hunger.hpp"

using namespace hunger;
using Vec = Eigen::VectorXd;

namespace memory_cases {

struct Damped {
  Vec operator()(const Vec& r, const Vec& v, double t) const { return states::DampedPull{}(r, v, t); }
};
struct Still {
  Vec operator()(const Vec& r) const { return states::Pull{}(r); }
};
inline const auto motion = [] { return states::SecondOrder<Vec>{}.state; };
inline const auto verlet = [](auto& y) { return PhiStepper{y, Damped{}, velocity_verlet}; };
inline void check(const Tally& tally) {
  INFO(tally.first);
  CHECK(tally.runs > 100);
  CHECK(tally.changed == 0);
  CHECK(tally.untold == 0);
  CHECK(tally.stuck == 0);
  CHECK(tally.otherwise == 0);
}

}  // namespace memory_cases

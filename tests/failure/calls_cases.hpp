// What calls.test.cpp and calls.full.cpp share.
#pragma once

#include <phistep/phistep.hpp>

#include <vector>

#include "failure/faults.hpp"

using namespace faults;
using Vec = Eigen::VectorXd;

namespace calls_cases {

inline const auto motion = [] { return states::SecondOrder<Vec>{}.state; };
inline const auto flow = [] { return states::FirstOrder<Vec>{}.state; };
inline const std::vector<Kind> kinds{Kind::nan, Kind::exception};

struct Pull {
  Vec operator()(const Vec& r) const { return struck<Vec>(Site::force, states::Pull{}(r)); }
};
struct Driven {
  Vec operator()(const Vec& y, double t) const { return struck<Vec>(Site::force, states::DrivenPull{}(y, t)); }
};
inline auto with(auto f, auto... more) {
  return [=](auto& y) { return PhiStepper{y, f, more...}; };
}
inline void check(const Tally& tally) {
  INFO(tally.first);
  CHECK(tally.changed == 0);
  CHECK(tally.untold == 0);
  CHECK(tally.stuck == 0);
  CHECK(tally.otherwise == 0);
}

/// The state seen, and bounces where r_0 passes a wall.
struct Bounces {
  static auto make() {
    return std::tuple{event(
                          [](const auto& y) {
                            const double g = y.r[0] - 0.35;
                            return fault.strikes(Site::event) ? fault.bad() : g;
                          },
                          {},
                          [](double, auto& y) {
                            y.v[0] *= -0.9;
                            static_cast<void>(fault.strikes(Site::handler));
                          }),
                      [](double, const auto&) { static_cast<void>(fault.strikes(Site::observer)); }};
  }
};

}  // namespace calls_cases

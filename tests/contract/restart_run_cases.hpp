#pragma once

// Problems that the restarted runs share, quick and full.

#include <phistep/phistep.hpp>

#include <sstream>
#include <string>

#include "contract/restart_run.hpp"
#include "problems/hires.hpp"
#include "problems/slider.hpp"
#include "problems/van_der_pol.hpp"
#include "support/catch.hpp"
#include "support/shared_force.hpp"

namespace restart_run {

using problems::Slider;
using Vec = Eigen::VectorXd;

inline const auto hires = [] { return problems::Hires::start(); };
inline const auto pol = [] { return problems::VanDerPol::start(); };
inline const shared_force::OfState<Vec> decay = [](const Vec& y) -> Vec { return -2 * y - y.cwiseProduct(y); };
inline const auto positive = [] { return Vec(Vec::LinSpaced(3, 0.5, 2)); };

inline Motion<Vec> pair() { return {Vec::Constant(2, 0.1), Eigen::Vector2d(1.0, -2.0)}; }

/// Three who wait for times, and an event.
inline const auto watchers = [](std::vector<double>& log) {
  const auto note = [&log](double t, const auto& y) { log.insert(log.end(), {t, y.r[0], y.v[0]}); };
  return std::tuple{every(0.3, note), at_times({0.5, 1.25, 3.0}, note), sampled(0.4, note),
                    event([](const auto& y) { return y.r[0]; }, {},
                          [&log](double t, auto& y) {
                            log.push_back(t);
                            y.v *= 0.9;
                          })};
};

/// A state that is edited after a restart: the run goes on as the one that was not restarted does.
inline void check_edit(auto start, const auto& force) {
  const auto run = [&](bool restarts, bool all_the_way) {
    auto y = start();
    PhiStepper stepper{y, force, tr_bdf2};
    const tolerance control{.rtol = 1e-3};
    Run first{stepper, y, {0, 1}, control};
    for (int k = 0; k < 5; ++k) REQUIRE(first.advance());
    const std::string saved = restart::saved(first);
    const auto go_on = [&](auto& by, auto& state) {
      state[0] *= 1.5;
      if (all_the_way) static_cast<void>(by.finish());
      while (by.advance()) {
      }
      return restart::bytes(state);
    };
    if (!restarts) return go_on(first, y);
    auto z = start();
    PhiStepper other{z, force, tr_bdf2};
    Run second{other, z, {0, 1}, control};
    std::istringstream in(saved);
    load_checkpoint(in, second);
    return go_on(second, z);
  };
  const std::string looked_at = run(false, false);
  CHECK(run(true, false) == looked_at);
  CHECK(run(true, true) == looked_at);
  CHECK(run(false, true) == looked_at);
}

}  // namespace restart_run

// Controlled runs, restarted anywhere: the lengths of the steps go on as they would have, to the bit.
#include <phistep/phistep.hpp>
#include <phistep/sparse.hpp>

#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "contract/restart_run.hpp"
#include "contract/states.hpp"
#include "problems/hires.hpp"
#include "problems/spring_net.hpp"
#include "problems/van_der_pol.hpp"

using namespace phistep;
using problems::SpringNet;
using restart_run::check;
using restart_run::nobody;
using restart_run::steps;
using Vec = Eigen::VectorXd;

namespace {

const auto hires = [] { return problems::Hires::start(); };
const auto pol = [] { return problems::VanDerPol::start(); };
const auto decay = [](const Vec& y) -> Vec { return -2 * y - y.cwiseProduct(y); };
const auto positive = [] { return Vec(Vec::LinSpaced(3, 0.5, 2)); };

/// Slides where the pull is too strong.
struct Slider : ForceTerm {
  struct Memory {
    Vec anchor;
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
Motion<Vec> pair() { return {Vec::Constant(2, 0.1), Eigen::Vector2d(1.0, -2.0)}; }

}  // namespace

TEST_CASE("runs controlled by their error restart to the same bits") {
  const tolerance control{.rtol = 1e-3, .atol = 1e-6};
  CHECK(check(hires, steps(problems::Hires{}, tr_bdf2), 50, control) > 10);
  check(hires, steps(problems::Hires{}, trapezoidal), 50, control);
  check(hires, steps(problems::Hires{}, backward_euler), 5, control);
  check(pol, steps(problems::VanDerPol{}, velocity_verlet), 8, control);
  check(pol, steps(problems::VanDerPol{}, trapezoidal), 8, tolerance{.rtol = 1e-4});
  check(positive, steps(decay, forward_euler), 1, control);
  check(positive, steps(decay, phi_stage(0.7)), 1, control);  // by doubling
  check(positive, steps(decay, rannacher(2)), 1, control);
}

TEST_CASE("factors, predictors and rates that live on from step to step") {
  const auto net = [] { return SpringNet::start(); };
  const auto masses = mass(SpringNet::masses());
  for (const double rtol : {1e-2, 1e-4}) {
    check(net, steps(SpringNet::damped(), tr_bdf2, masses), 0.5, tolerance{.rtol = rtol});
    check(net, steps(SpringNet::elastic(), trapezoidal, masses), 0.5, tolerance{.rtol = rtol, .norm = Norm::particle});
  }
  check(positive, steps(linear(Eigen::MatrixXd(-3 * Eigen::MatrixXd::Identity(3, 3))), trapezoidal), 2, tolerance{});
}

TEST_CASE("other controls restart to the same bits") {
  const auto solver = fixed_point({.depth = 0});
  const iteration_control iterations{.first_step = 0.01, .order = 1, .max_step = 0.1};
  check(positive, steps(decay, trapezoidal, solver), 1, iterations);
  check(positive, steps(decay, trapezoidal, solver), 1, smaller_of(tolerance{.rtol = 1e-3}, iterations));
  check(positive, steps(decay, tr_bdf2), 1, fixed(0.03));
  check(pol, steps(problems::VanDerPol{}, velocity_verlet), 1, fixed(0.03));
}

TEST_CASE("other scalars, borrowed states, forces with memory, halving") {
  const auto single = [] { return Eigen::VectorXf(positive().cast<float>()); };
  const auto gentle = [](const Eigen::VectorXf& y) -> Eigen::VectorXf { return -2 * y; };
  check(single, steps(gentle, tr_bdf2), 1, tolerance{.rtol = 1e-2});
  const auto wide = [] { return Eigen::Vector<long double, 3>(positive().cast<long double>()); };
  const auto wide_decay = [](const Eigen::Vector<long double, 3>& y) -> Eigen::Vector<long double, 3> {
    return -2 * y - y.cwiseProduct(y);
  };
  check(wide, steps(wide_decay, trapezoidal), 1, tolerance{.rtol = 1e-5});
  std::vector<std::unique_ptr<states::Home<states::Mapped>>> homes;
  const auto mapped = [&homes] {
    homes.push_back(std::make_unique<states::Home<states::Mapped>>());
    return homes.back()->block(states::positions);
  };
  check(mapped, steps([](const Vec& y) -> Vec { return -2 * y; }, tr_bdf2), 1, tolerance{});
  check(pair, steps(Slider{}, tr_bdf2), 2, tolerance{.rtol = 1e-3});
  check(pair, steps(Slider{}, velocity_verlet), 2, tolerance{.rtol = 1e-3});
  check(
      positive,
      [](auto& y) {
        return Halving{PhiStepper{y, decay, trapezoidal}, 3};
      },
      1, fixed(0.05));
}

TEST_CASE("observers that wait for times, and events, go on as they would have") {
  const auto watchers = [](std::vector<double>& log) {
    const auto note = [&log](double t, const auto& y) { log.insert(log.end(), {t, y.r[0], y.v[0]}); };
    return std::tuple{every(0.3, note), at_times({0.5, 1.25, 3.0}, note), sampled(0.4, note),
                      event([](const auto& y) { return y.r[0]; }, {},
                            [&log](double t, auto& y) {
                              log.push_back(t);
                              y.v *= 0.9;
                            })};
  };
  check(pol, steps(problems::VanDerPol{}, tr_bdf2), 6, tolerance{.rtol = 1e-3}, watchers);
  check(pol, steps(problems::VanDerPol{}, velocity_verlet), 6, tolerance{.rtol = 1e-3}, watchers);
  check(pol, steps(problems::VanDerPol{}, trapezoidal), 6, fixed(0.05), watchers);
}

TEST_CASE("a recorder and a ledger go on with what they have") {
  struct Program {
    Motion<Vec> y = SpringNet::start();
    decltype(steps(SpringNet::damped(), trapezoidal, mass(SpringNet::masses()))(y)) stepper =
        steps(SpringNet::damped(), trapezoidal, mass(SpringNet::masses()))(y);
    EnergyLedger<decltype(stepper)> ledger{stepper};
    Recorder<Motion<Vec>> recorder;
    Run<decltype(stepper), Motion<Vec>, tolerance, decltype(ledger)&, decltype(recorder)&> run{
        stepper, y, {0, 0.5}, tolerance{.rtol = 1e-3}, ledger, recorder};
  };
  Program unbroken;
  for (int k = 0; k < 9; ++k) REQUIRE(unbroken.run.advance());
  const std::string half_way = restart::bytes(unbroken.run);
  REQUIRE(unbroken.run.finish());
  Program again;
  std::istringstream in(half_way);
  load_checkpoint(in, again.run);
  CHECK(restart::bytes(again.run) == half_way);
  REQUIRE(again.run.finish());
  CHECK(restart::bytes(again.ledger, again.recorder) == restart::bytes(unbroken.ledger, unbroken.recorder));
  CHECK(again.recorder.times() == unbroken.recorder.times());
  CHECK(again.recorder.position() == unbroken.recorder.position());
  CHECK(again.ledger.force_calls() == unbroken.ledger.force_calls());
  CHECK(again.ledger.closure() == unbroken.ledger.closure());
}

TEST_CASE("a state that is edited after a restart is noticed") {
  const auto run = [](bool restarts, bool all_the_way) {
    auto y = positive();
    PhiStepper stepper{y, decay, tr_bdf2};
    const tolerance control{.rtol = 1e-3};
    Run first{stepper, y, {0, 1}, control};
    for (int k = 0; k < 5; ++k) REQUIRE(first.advance());
    const auto go_on = [&](auto& by, Vec& state) {
      state[0] *= 1.5;
      if (all_the_way) static_cast<void>(by.finish());
      while (by.advance()) {
      }
      return restart::bytes(state);
    };
    if (!restarts) return go_on(first, y);
    auto z = positive();
    PhiStepper other{z, decay, tr_bdf2};
    Run second{other, z, {0, 1}, control};
    std::istringstream in(restart::bytes(first));
    load_checkpoint(in, second);
    return go_on(second, z);
  };
  const std::string looked_at = run(false, false);
  CHECK(run(true, false) == looked_at);
  CHECK(run(true, true) == looked_at);
  CHECK(run(false, true) == looked_at);
}

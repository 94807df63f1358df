// run, every scheme: edits between steps. In short: run.test.cpp.
#include "run/run_cases.hpp"

using namespace run_cases;

// Edits. Whatever is carried (slopes, Ψ, factors, the estimator's past) must not survive them.
namespace {

/// How far a run whose state is edited at t = 1 is from one that starts there, and the second run's own error.
template <class S>
void check_edits(auto scheme, auto psi, S start, auto&& edit) {
  const tolerance control{.rtol = 1e-5};
  S by_observer = start, by_caller = start, by_finish = start, afresh = start;
  const auto stepper_for = [&](const S& y) { return PhiStepper{y, psi, scheme}; };
  {
    auto stepper = stepper_for(by_observer);
    REQUIRE(integrate(stepper, by_observer, {0, 2}, control, at_times({1.0}, [&](double, S& y) { edit(y); })));
  }
  {
    auto stepper = stepper_for(by_caller);
    auto stop = at_times({1.0}, [](double, const S&) {});
    Run run{stepper, by_caller, {0.0, 2.0}, control, stop};
    while (run.advance())
      if (run.time() == 1) edit(by_caller);
    REQUIRE(run.report());
  }
  {
    // … and the rest in one go, with nobody looking.
    auto stepper = stepper_for(by_finish);
    Run run{stepper, by_finish, {0.0, 2.0}, tolerance{.rtol = 1e-5, .first_step = 0.125 / 64, .max_step = 0.0625}};
    double t = 0;
    for (int n = 0; n < 30; ++n) REQUIRE(run.advance());
    t = run.time();
    edit(by_finish);
    S same = by_finish;
    REQUIRE(run.finish());
    auto other = stepper_for(same);
    REQUIRE(integrate(other, same, {t, 2}, control));
    CHECK(distance(by_finish, same) <= 1e-4);
  }
  {
    auto first = stepper_for(afresh);
    REQUIRE(integrate(first, afresh, {0, 1}, control));
    edit(afresh);
    auto second = stepper_for(afresh);
    REQUIRE(integrate(second, afresh, {1, 2}, control));
  }
  // Both are within about 10·rtol of the truth (tests/tolerance); the edits are of order one.
  CHECK(distance(by_observer, afresh) <= 2e-4);
  CHECK(distance(by_caller, afresh) <= 2e-4);
}

}  // namespace

TEST_CASE("after an edit nothing stale is used") {
  const auto flow = [](const Vec& y, double t) -> Vec { return Vec(-40 * (y[0] - std::cos(t)), y[0] - y[1] * y[1]); };
  const auto swing = [](const Vec& r, const Vec& v, double t) -> Vec {
    return Vec(-9 * r - 0.2 * v + Vec(std::sin(t), 0));
  };
  const auto still = [](const Vec& r) -> Vec { return -9 * r - r.squaredNorm() * r; };
  const auto jump = [](Vec& y) { y = Vec(3, -0.2); };
  const auto bounce = [](Moving& y) { y.r[0] += 1, y.v = -y.v + Vec(0, 2); };
  const auto kick = [](Moving& y) { y.v *= -3; };
  for_each_scheme([&](const char* name, auto scheme) {
    CAPTURE(name);
    if constexpr (!std::is_same_v<decltype(scheme), std::remove_const_t<decltype(forward_euler)>> &&
                  !std::is_same_v<decltype(scheme), std::remove_const_t<decltype(backward_euler)>>) {
      check_edits<Vec>(scheme, flow, Vec(1, 0.5), jump);
      check_edits<Moving>(scheme, swing, Moving{Vec(1, 0), Vec(0, 1)}, bounce);
    }
  });
  check_edits<Moving>(velocity_verlet, swing, Moving{Vec(1, 0), Vec(0, 1)}, bounce);
  check_edits<Moving>(velocity_verlet, still, Moving{Vec(1, 0), Vec(0, 1)}, bounce);
  check_edits<Moving>(velocity_verlet, still, Moving{Vec(1, 0), Vec(0, 1)}, kick);
}

TEST_CASE("an edit costs the force call that makes the slope anew, and no more") {
  const auto calls = [](auto&& edit) {
    Vec y(1, 2);
    PhiStepper stepper{y, decay, forward_euler};
    Run run{stepper, y, {0.0, 1.0}, tolerance{.rtol = 1e-3, .atol = 1e-3}};
    while (run.advance()) edit(y);
    return run.report().statistics;
  };
  // Two for the first length, one at the end of each try; one at the start of each step whose start isn't known.
  const Statistics kept = calls([](Vec&) {}), edited = calls([](Vec&y) { y[0] = std::nextafter(y[0], 0); });
  CHECK(kept.force_calls == 2 + kept.steps + kept.rejections + 1);
  CHECK(edited.force_calls == 2 + edited.steps + edited.rejections + edited.steps);
}

TEST_CASE("a force that is changed between steps is asked anew") {
  struct Pull {
    double to;
    Vec operator()(const Vec& y) const { return Vec(to - y[0], to - y[1]); }
  };
  for_each_scheme([](const char* name, auto scheme) {
    CAPTURE(name);
    Vec y(1, 1);
    PhiStepper stepper{y, Pull{1}, scheme};
    REQUIRE(integrate(stepper, y, {0, 2}, tolerance{.rtol = 1e-4, .max_step = 0.5},
                      at_times({1.0}, [&](double, const Vec&) { stepper.force().to = -5; })));
    CHECK(y[0] == Approx(-5 + 6 * std::exp(-1)).epsilon(1e-3));
  });
}

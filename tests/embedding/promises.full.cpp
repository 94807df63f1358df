// What docs/embedding.md says of each scheme: how often it calls the force, what goes on from r, v and t alone, and which
// schemes never call it with a state that isn't finite.
#include "embedding/promises_cases.hpp"
//
#include <phistep/io.hpp>
#include <phistep/krylov.hpp>

#include <sstream>

using namespace promises_cases;

TEST_CASE("calls a step: one for the Eulers and Verlet, and one more in Verlet's first") {
  CHECK(calls_of_steps<Anchored>(forward_euler) == steps_of(1, 1));
  CHECK(calls_of_steps<Anchored>(symplectic_euler) == steps_of(1, 1));
  CHECK(calls_of_steps<Anchored>(symplectic_euler_adjoint) == steps_of(1, 1));
  CHECK(calls_of_steps<Anchored>(velocity_verlet) == steps_of(2, 1));
  CHECK(calls_of_steps<Damped>(forward_euler) == steps_of(1, 1));
  CHECK(calls_of_steps<Damped>(symplectic_euler) == steps_of(1, 1));
  CHECK(calls_of_steps<Driven>(velocity_verlet) == steps_of(2, 1));
}

TEST_CASE(
    "a force that reads the state that the program steps, not its argument, is wrong with midpoint, and told on "
    "request") {
  Y y = start, right = start;
  const auto own = [&y](const Vec&) -> Vec { return -4 * y.r; };
  CHECK(!check_force(own, y).sees_state());
  PhiStepper stepper{y, own, midpoint, fixed_point()};
  PhiStepper other{right, [](const Vec& r) -> Vec { return -4 * r; }, midpoint, fixed_point()};
  const auto energy = [](const Y& at) { return at.v.squaredNorm() / 2 + 2 * at.r.squaredNorm(); };
  for (int n = 0; n < 400; ++n) REQUIRE((stepper.step(y, 0.05 * n, 0.05) && other.step(right, 0.05 * n, 0.05)));
  CHECK(energy(right) == Approx(energy(start)).epsilon(1e-12));
  CHECK(energy(y) > 1.5 * energy(start));
}

TEST_CASE("calls a step: compositions and Nystrom pairs") {
  CHECK(calls_of_steps<Anchored>(srkn6b) == steps_of(7, 6));
  CHECK(calls_of_steps<Anchored>(srkn11b) == steps_of(12, 11));
  CHECK(calls_of_steps<Anchored>(composed(velocity_verlet)) == steps_of(18, 17));
  CHECK(calls_of_steps<Anchored>(rkn86) == steps_of(9, 8));
  CHECK(calls_of_steps<Anchored>(tsit5) == steps_of(6, 6));
  CHECK(calls_of_steps<Anchored>(dop853) == steps_of(12, 12));
  CHECK(calls_of_steps<Anchored>(rkn1210) == steps_of(17, 17));
}

namespace {
/// A Jacobian that is right.
struct Pendulums {
  Diary* diary;
  Vec operator()(const Vec& r) const {
    ++diary->calls;
    return -r.array().sin();
  }
  [[nodiscard]] static Eigen::Matrix3d jacobian(const Vec& r) {
    return Eigen::Matrix3d((-r.array().cos()).matrix().asDiagonal());
  }
};
/// … that a force which swings comes with.
struct DrivenPendulums : Pendulums {
  Vec operator()(const Vec& r, const Vec&, double t) const { return Pendulums::operator()(r).array() + std::sin(t); }
  [[nodiscard]] static MotionJacobian<Eigen::Matrix3d> jacobian(const Vec& r, const Vec&, double) {
    return {Pendulums::jacobian(r), Eigen::Matrix3d::Zero()};
  }
};
}  // namespace

TEST_CASE("calls a step: linear stages, with a Jacobian by three differences or supplied, and checked at 1, 2, 4, 8") {
  CHECK(calls_of_steps<Anchored>(rodas4) == steps_of(6 + 3, 6 + 3));
  CHECK(calls_of_steps<Anchored>(rodas5p) == steps_of(8 + 3, 8 + 3));
  CHECK(calls_of_steps<Pendulums>(rodas4) == std::vector{7, 7, 6, 7, 6, 6, 6, 7, 6, 6, 6, 6});
  CHECK(calls_of_steps<Pendulums>(rodas5p) == std::vector{9, 9, 8, 9, 8, 8, 8, 9, 8, 8, 8, 8});
  CHECK(calls_of_steps<DrivenPendulums>(rodas4) == std::vector{9, 9, 8, 9, 8, 8, 8, 9, 8, 8, 8, 8});
}

TEST_CASE("calls a step: Newton's, one an iteration, three a Jacobian by differences; a supplied one is not checked") {
  const auto check = [](auto scheme, int before, auto force, int differences) {
    Diary diary;
    Y y = start;
    PhiStepper stepper{y, decltype(force){&diary}, scheme};
    for (int n = 0; n < 12; ++n) REQUIRE(stepper.step(y, 0.1 * n, 0.1));
    const Statistics s = stepper.statistics();
    CHECK(s.checks == 0);
    CHECK(diary.calls == 12 * before + s.iterations + differences * s.jacobians);
  };
  check(backward_euler, 0, Anchored{}, 3);
  check(midpoint, 0, Anchored{}, 3);
  check(trapezoidal, 1, Anchored{}, 3);
  check(backward_euler, 0, Pendulums{}, 0);
  check(midpoint, 0, Pendulums{}, 0);
}

namespace {
int calls_of_run(auto scheme, const auto& control, auto&&... observers) {
  Diary diary;
  Y y = start;
  PhiStepper stepper{y, Anchored{&diary}, scheme};
  const RunReport report = integrate(stepper, y, {0, 1}, control, observers...);
  REQUIRE(report);
  CHECK(report.statistics.force_calls == diary.calls);
  return diary.calls;
}
int calls_of_first_step(const auto& control) {
  Diary diary;
  Y y = start;
  PhiStepper stepper{y, Anchored{&diary}, rkn86};
  Run run{stepper, y, {0, 1}, control};
  REQUIRE(run.advance());
  return diary.calls;
}
}  // namespace

TEST_CASE(
    "calls of a run: two to find its first step; looks inside steps cost two a step, where the scheme leaves no "
    "slopes") {
  CHECK(calls_of_first_step(tolerance{.rtol = 1e-6, .first_step = 0.01}) == 9);
  CHECK(calls_of_first_step(tolerance{.rtol = 1e-6}) == 9 + 2);
  CHECK(calls_of_run(velocity_verlet, fixed(0.1)) == 11);
  CHECK(calls_of_run(velocity_verlet, fixed(0.1), [](double, const Y&) {}) == 11);
  CHECK(calls_of_run(velocity_verlet, fixed(0.1), sampled(0.03, [](double, const Y&) {})) == 11 + 20);
  auto never = event([](const Y& y) { return y.r[0] - 5; }, {}, [](double, Y&) {});
  CHECK(calls_of_run(velocity_verlet, fixed(0.1), never) == 11 + 20);
}

TEST_CASE(
    "a look inside of the steps of a scheme that solves or has a high order copies the stepper, and the force with "
    "it") {
  struct Copied : Anchored {
    int* copies;
    Copied(Diary* d, int* c) : Anchored{d}, copies{c} {}
    Copied(const Copied& o) : Anchored{o}, copies{o.copies} { ++*copies; }
    Copied& operator=(const Copied& o) {
      ++*o.copies;
      return *this;
    }
    Copied(Copied&&) noexcept = default;
    Copied& operator=(Copied&&) noexcept = default;
    ~Copied() = default;
  };
  Diary diary;
  int copies = 0;
  const auto run = [&](auto scheme, auto force) {
    Y y = start;
    PhiStepper stepper{y, force, scheme};
    const int before = copies;
    REQUIRE(integrate(stepper, y, {0, 1}, fixed(0.1), sampled(0.03, [](double, const Y&) {})));
    return copies - before;
  };
  Copied force{&diary, &copies};
  CHECK(run(velocity_verlet, force) == 0);
  CHECK(run(backward_euler, force) == 10);
  CHECK(run(rkn86, force) == 10);
  CHECK(run(backward_euler, std::ref(force)) == 0);
}

TEST_CASE("from r, v and t alone, with the same bits: schemes that iterate nothing from step to step") {
  check_same_bits(forward_euler);
  check_same_bits(symplectic_euler);
  check_same_bits(symplectic_euler_adjoint);
  check_same_bits(velocity_verlet);
  check_same_bits<Damped>(symplectic_euler);
  check_same_bits(srkn6b);
  check_same_bits(srkn11b);
  check_same_bits(composed(velocity_verlet));
  check_same_bits(rkn86);
  check_same_bits(rkn1210);
  check_same_bits(rodas4);
  check_same_bits(rodas5p);
  check_same_bits(radau);
}

TEST_CASE("from r, v and t alone, with the same bits: by fixed_point, without a matrix, by one correction") {
  check_same_bits(backward_euler, fixed_point());
  check_same_bits(midpoint, fixed_point());
  check_same_bits(trapezoidal, fixed_point());
  check_same_bits(backward_euler, newton<MatrixFree<Eigen::BiCGSTAB>>());
  check_same_bits(backward_euler, linearly_implicit());
}

TEST_CASE(
    "from r, v and t alone, to rounding; with reset() where it is saved to the bit: Newton's schemes, and phi > 1/2") {
  check_rounding(backward_euler);
  check_rounding(midpoint);
  check_rounding(trapezoidal);
  check_rounding(phi(0.7));
  check_rounding(tr_bdf2);
  check_rounding(phi(0.7), fixed_point());
}

TEST_CASE("from r, v and t alone, Rannacher's scheme begins anew with its two half steps: another solution") {
  CHECK(continued<Anchored>(0.0625, 12, false, rannacher).apart > 1e-4);
  CHECK(continued<Anchored>(0.0625, 12, true, rannacher).same_bits == 28);  // reset() begins anew, too
}

TEST_CASE("from r, v and t alone, a run under a tolerance ends elsewhere, within it; save_checkpoint keeps its bits") {
  const auto check = [](auto scheme, double apart) {
    const tolerance control{.rtol = 1e-6, .atol = 1e-9};
    Diary diary;
    Y a = start;
    PhiStepper goes_on{a, Anchored{&diary}, scheme};
    Run run{goes_on, a, {0, 10}, control};
    for (int k = 0; k < 20; ++k) REQUIRE(run.advance());
    const double t = run.time();
    std::stringstream file;
    save_checkpoint(file, run);
    Y b = a, c = start;
    REQUIRE(run.finish());

    PhiStepper fresh{b, Anchored{&diary}, scheme};
    REQUIRE(integrate(fresh, b, {t, 10}, control));
    CHECK(!same(a, b));
    CHECK(distance(a, b) < apart);

    PhiStepper loading{c, Anchored{&diary}, scheme};
    Run loaded{loading, c, {0, 10}, control};
    load_checkpoint(file, loaded);
    REQUIRE(loaded.finish());
    CHECK(same(a, c));
  };
  check(velocity_verlet, 1e-5), check(rkn86, 1e-5), check(rodas5p, 1e-5), check(radau, 1e-5);
}

TEST_CASE("no force is called with a state that isn't finite: explicit schemes, Newton's, fixed-point iteration") {
  check_never_called_with_nan<Anchored>(forward_euler);
  check_never_called_with_nan<Anchored>(symplectic_euler);
  check_never_called_with_nan<Damped>(symplectic_euler);
  check_never_called_with_nan<Anchored>(symplectic_euler_adjoint);
  check_never_called_with_nan<Anchored>(velocity_verlet);
  check_never_called_with_nan<Damped>(velocity_verlet);
  check_never_called_with_nan<Anchored>(srkn6b);
  check_never_called_with_nan<Anchored>(srkn11b);
  check_never_called_with_nan<Anchored>(composed(velocity_verlet));
  check_never_called_with_nan<Anchored>(rkn86);
  check_never_called_with_nan<Anchored>(rkn1210);
  check_never_called_with_nan<Anchored>(tsit5);
  check_never_called_with_nan<Damped>(dop853);
  check_never_called_with_nan<Anchored>(backward_euler);
  check_never_called_with_nan<Damped>(backward_euler);
  check_never_called_with_nan<Anchored>(midpoint);
  check_never_called_with_nan<Anchored>(trapezoidal);
  check_never_called_with_nan<Anchored>(phi(0.7));
  check_never_called_with_nan<Anchored>(tr_bdf2);
  check_never_called_with_nan<Anchored>(backward_euler, fixed_point());
  check_never_called_with_nan<Anchored>(midpoint, fixed_point());
  check_never_called_with_nan<Damped>(midpoint, fixed_point());
}

TEST_CASE("no force is called with a state that isn't finite: runs under a tolerance") {
  check_runs_never_call_with_nan<Anchored>(forward_euler);
  check_runs_never_call_with_nan<Anchored>(velocity_verlet);
  check_runs_never_call_with_nan<Damped>(velocity_verlet);
  check_runs_never_call_with_nan<Anchored>(symplectic_euler);
  check_runs_never_call_with_nan<Anchored>(rkn86);
  check_runs_never_call_with_nan<Damped>(tsit5);
  check_runs_never_call_with_nan<Anchored>(dop853);
  check_runs_never_call_with_nan<Anchored>(backward_euler);
  check_runs_never_call_with_nan<Damped>(trapezoidal);
  check_runs_never_call_with_nan<Anchored>(midpoint);
}

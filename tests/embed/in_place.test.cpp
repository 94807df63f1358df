#include <phistep/in_place.hpp>
#include <phistep/krylov.hpp>
#include <unsupported/Eigen/IterativeSolvers>

#include <catch2/catch.hpp>

#include <cstdint>
#include <stdexcept>
#include <utility>
#include <vector>

#include "embed/layouts.hpp"

using namespace layouts;

namespace {
constexpr double dt = 0.01;

template <class Code>
auto in_place(Code& code) {
  return phistep::MotionInPlace{code.positions(), code.velocities(), code.rates()};
}
/// Ψ(r, t) of a force that copied_force gives as Ψ(r, v, t).
template <class Code>
auto copied_force_of_r(Code& scratch) {
  return [force = copied_force(scratch)](const Eigen::Matrix3Xd& r) {
    return force(r, Eigen::Matrix3Xd::Zero(3, r.cols()), 0.0);
  };
}

/// Steps in place and of an owned copy of the state: the same bits and the same calls, with `step` and with `integrate`.
template <class Code, class Scheme>
void same_as_owned(Scheme scheme, auto solver) {
  Code code(300), scratch(300);  // more than two pieces
  auto y = owned(code);
  phistep::PhiStepper other{y, copied_force_of_r(scratch), scheme, phistep::mass(2.0), solver};
  auto state = in_place(code);
  phistep::PhiStepper stepper{state, state.force_of_r([&code] { code.forces(); }), scheme, phistep::mass(2.0), solver};
  for (int n = 0; n < 20; ++n) {
    REQUIRE(stepper.step(state, n * dt, dt));
    REQUIRE(other.step(y, n * dt, dt));
    if (n % 7 == 3) {  // an edit
      code.x(5, 1) += 0.125;
      y.r(1, 5) += 0.125;
    }
    REQUIRE(code.state() == numbers_of(y));
    REQUIRE(stepper.statistics().force_calls == other.statistics().force_calls);
    REQUIRE(code.calls == stepper.statistics().force_calls);
  }
  REQUIRE(phistep::integrate(stepper, state, {0.2, 0.5}, phistep::fixed(dt)));
  REQUIRE(phistep::integrate(other, y, {0.2, 0.5}, phistep::fixed(dt)));
  CHECK(code.state() == numbers_of(y));
  CHECK(code.calls == other.statistics().force_calls);
  CHECK(stepper.statistics().steps == 50);
}

/// A fault in each call of a short run: everything is put back, the next try goes on as if nothing had been.
template <class Code, class Scheme>
void faults_leave_nothing(Scheme scheme, auto solver, bool velocities, bool nan_is_fatal = true) {
  const auto run = [&](Code& code, int steps, bool may_fail) {
    auto state = in_place(code);
    int failures = 0;
    const auto go = [&](auto force) {
      phistep::PhiStepper stepper{state, force, scheme, phistep::mass(2.0), solver};
      for (int n = 0; n < steps; ++n) {
        const auto before = code.numbers();
        bool done = false;
        try {
          done = static_cast<bool>(stepper.step(state, n * dt, dt));
        } catch (const Thrown&) {
        }
        if (done) continue;
        REQUIRE(may_fail);
        ++failures;
        REQUIRE(code.numbers().size() == before.size());
        REQUIRE(std::equal(before.begin(), before.end(), code.numbers().begin()));
        --n;
      }
    };
    if (velocities) go(state.force_of_rv([&code](double t) { code.forces(t); }));
    else go(state.force_of_r([&code] { code.forces(); }));
    return failures;
  };
  Code good(200);
  good.drag = velocities ? 0.3 : 0;
  run(good, 4, false);
  for (const auto kind : {Fault::Kind::nan, Fault::Kind::thrown}) {
    if (kind == Fault::Kind::nan && !nan_is_fatal) continue;
    for (int call = 1; call <= good.calls; ++call) {
      CAPTURE(call, static_cast<int>(kind), scheme.name());
      Code code(200);
      code.drag = good.drag;
      code.fault = {kind, call};
      REQUIRE(run(code, 4, true) == 1);
      REQUIRE(code.state() == good.state());
    }
  }
}
}  // namespace

TEMPLATE_TEST_CASE("in place: a step gives the bits and the calls of a state that the library owns", "[embed]", Structs,
                   Rows, Components, Vectors) {
  same_as_owned<TestType>(phistep::forward_euler, phistep::newton());
  same_as_owned<TestType>(phistep::symplectic_euler, phistep::newton());
  same_as_owned<TestType>(phistep::velocity_verlet, phistep::newton());
  same_as_owned<TestType>(phistep::srkn6b, phistep::newton());
  same_as_owned<TestType>(phistep::midpoint, phistep::fixed_point());
}

TEMPLATE_TEST_CASE("in place: a fault in any call of the routine leaves every bit", "[embed]", Structs, Components) {
  faults_leave_nothing<TestType>(phistep::forward_euler, phistep::newton(), false);
  faults_leave_nothing<TestType>(phistep::velocity_verlet, phistep::newton(), false);
  faults_leave_nothing<TestType>(phistep::symplectic_euler, phistep::newton(), true);
  faults_leave_nothing<TestType>(phistep::velocity_verlet, phistep::fixed_point(), true);
  faults_leave_nothing<TestType>(phistep::midpoint, phistep::fixed_point(), true);
  // GMRES ends at a product that is not finite, and the next correction mends what that left.
  faults_leave_nothing<TestType>(phistep::midpoint, phistep::newton<phistep::MatrixFree<Eigen::GMRES>>(), true, false);
}

TEST_CASE("in place: edits of positions are noticed, of velocities and forces they do no harm", "[embed]") {
  Structs code(20);
  auto state = in_place(code);
  phistep::PhiStepper stepper{state, state.force_of_r([&code] { code.forces(); }), phistep::velocity_verlet};
  REQUIRE(stepper.step(state, 0, dt));
  CHECK(code.calls == 2);
  REQUIRE(stepper.step(state, dt, dt));
  CHECK(code.calls == 3);
  code.v(3, 0) += 1;
  REQUIRE(stepper.step(state, 2 * dt, dt));
  CHECK(code.calls == 4);
  code.x(3, 0) += 0.1;
  REQUIRE(stepper.step(state, 3 * dt, dt));
  CHECK(code.calls == 6);
  code.f(19, 2) = 1e3;  // Ψ is what the routine has computed there
  REQUIRE(stepper.step(state, 4 * dt, dt));
  CHECK(code.calls == 7);
  CHECK(std::abs(code.f(19, 2)) < 1e2);
  static_cast<void>(stepper.force());  // it may be another force now
  REQUIRE(stepper.step(state, 5 * dt, dt));
  CHECK(code.calls == 9);
}

TEST_CASE("in place: particles may come and go between steps", "[embed]") {
  Structs code(40), few(30);
  for (auto& bead : code.beads) bead.m = 1 + 0.1 * bead.x[0];
  auto state = in_place(code);
  phistep::PhiStepper stepper{state, state.force_of_r([&code] { code.forces(); }), phistep::velocity_verlet,
                              phistep::mass(phistep::places(code.beads, &Structs::Bead::m))};
  for (int n = 0; n < 5; ++n) REQUIRE(stepper.step(state, n * dt, dt));
  code.beads.erase(code.beads.begin() + 3, code.beads.begin() + 13);
  few.beads = code.beads;
  auto fresh_state = in_place(few);
  phistep::PhiStepper fresh{fresh_state, fresh_state.force_of_r([&few] { few.forces(); }), phistep::velocity_verlet,
                            phistep::mass(phistep::places(few.beads, &Structs::Bead::m))};
  for (int n = 5; n < 10; ++n) {
    REQUIRE(stepper.step(state, n * dt, dt));
    REQUIRE(fresh.step(fresh_state, n * dt, dt));
  }
  CHECK(code.numbers() == few.numbers());
  code.beads.resize(60, code.beads.back());  // more than there were
  REQUIRE(stepper.step(state, 10 * dt, dt));
}

TEST_CASE("in place: tolerances and events", "[embed]") {
  Rows code(12), scratch(12);
  auto y = owned(code);
  auto state = in_place(code);
  phistep::PhiStepper stepper{state, state.force_of_r([&code] { code.forces(); }), phistep::velocity_verlet};
  phistep::PhiStepper other{y, copied_force_of_r(scratch), phistep::velocity_verlet};
  auto crossing = phistep::event([](const auto& now) { return now.v(2, 7); });
  auto other_crossing = phistep::event([](const auto& now) { return now.v(2, 7); });
  const phistep::tolerance pace{.rtol = 1e-6, .atol = 1e-6};
  REQUIRE(phistep::integrate(stepper, state, {0.0, 1.0}, pace, crossing));
  REQUIRE(phistep::integrate(other, y, {0.0, 1.0}, pace, other_crossing));
  CHECK(code.state() == numbers_of(y));
  CHECK(!crossing.times().empty());
  CHECK(crossing.times() == other_crossing.times());
  CHECK(code.calls == scratch.calls);
}

TEST_CASE("in place: a routine is a term among others, and a stepper one among wrappers", "[embed]") {
  Structs code(30), alone(30), halved(30);
  auto state = in_place(code), other = in_place(alone), third = in_place(halved);
  const auto falling = [&alone] {
    alone.forces();
    for (auto& bead : alone.beads) bead.f[2] += 2.0 * -9.81;
  };
  phistep::PhiStepper stepper{
      state, state.force_of_r([&code] { code.forces(); }) + phistep::Gravity{Eigen::Vector3d(0, 0, -9.81)},
      phistep::velocity_verlet, phistep::mass(2.0)};
  phistep::PhiStepper one{other, other.force_of_r(falling), phistep::velocity_verlet, phistep::mass(2.0)};
  REQUIRE(phistep::integrate(stepper, state, {0.0, 0.2}, phistep::fixed(dt)));
  REQUIRE(phistep::integrate(one, other, {0.0, 0.2}, phistep::fixed(dt)));
  CHECK(code.state() == alone.state());
  CHECK(code.calls == alone.calls);

  phistep::Halving halving{
      phistep::PhiStepper{third, third.force_of_r([&halved] { halved.forces(); }), phistep::velocity_verlet}};
  halved.fault = {Fault::Kind::nan, 3};  // in the second step, which is then done as two
  for (int n = 0; n < 4; ++n) REQUIRE(halving.step(third, n * dt, dt));
  CHECK(halved.calls > 6);
}

TEST_CASE("in place: the message of a step that fails names the particle", "[embed]") {
  Rows code(30);
  auto state = in_place(code);
  phistep::PhiStepper stepper{state, state.force_of_r([&code] { code.forces(); }), phistep::velocity_verlet};
  code.fault = {Fault::Kind::nan, 2};
  CHECK(stepper.step(state, 0, dt).message().find("particle 15, row 1") != std::string::npos);
  code.v(3, 0) = 1.5e308;
  code.f(3, 0) = 0;
  const auto report = stepper.step(state, 0, 10.0);
  CHECK(report.outcome() == phistep::Outcome::non_finite_state);
  CHECK(report.message().find("particle 3, row 0") != std::string::npos);
  CHECK(code.v(3, 0) == 1.5e308);
}

TEST_CASE("in place: outside of steps a call puts the arrays back", "[embed]") {
  Structs code(10);
  auto state = in_place(code);
  phistep::PhiStepper stepper{state, state.force_of_r([&code] { code.forces(); }), phistep::velocity_verlet};
  auto elsewhere = owned(code), slope = elsewhere;
  elsewhere.r.array() += 0.25;
  const auto before = code.numbers();
  REQUIRE(stepper.slope(0.0, elsewhere, slope));
  CHECK(code.numbers() == before);
  CHECK(code.calls == 1);
}

TEST_CASE("in place: a routine that moves the particles is told so", "[embed]") {
  for (const bool moves_v : {false, true}) {
    Structs code(10);
    auto state = in_place(code);
    const auto before = code.numbers();
    phistep::PhiStepper stepper{state, state.force_of_r([&] {
                                  code.forces();
                                  (moves_v ? code.v(9, 2) : code.x(9, 2)) += 1;
                                }),
                                phistep::forward_euler};
    CHECK_THROWS_AS(stepper.step(state, 0, dt), std::logic_error);
    CHECK(code.numbers() == before);
  }
}

TEST_CASE("in place: arrays that share memory or differ in length are refused", "[embed]") {
  std::vector<double> a(30), b(30), c(27);
  const auto of = [](std::vector<double>& x) {
    return phistep::places<3>(x.data(), static_cast<phistep::Index>(x.size() / 3), 3);
  };
  CHECK_THROWS_AS((phistep::MotionInPlace{of(a), of(a), of(b)}), std::invalid_argument);
  CHECK_THROWS_AS((phistep::MotionInPlace{of(a), of(b), of(a)}), std::invalid_argument);
  CHECK_THROWS_AS((phistep::MotionInPlace{of(a), of(b), of(c)}), std::invalid_argument);
  CHECK_THROWS_AS((phistep::VectorInPlace{phistep::places(a), phistep::places(a)}), std::invalid_argument);
}

TEST_CASE("in place: a field and its rates, float and long double", "[embed]") {
  const auto heat = [](auto zero, auto scheme, auto solver) {
    using Scalar = decltype(zero);
    std::vector<Scalar> u(500), rate(500);
    for (std::size_t i = 0; i < u.size(); ++i) u[i] = static_cast<Scalar>(std::sin(0.05 * static_cast<double>(i)));
    Eigen::Matrix<Scalar, Eigen::Dynamic, 1> y = Eigen::Map<Eigen::Matrix<Scalar, Eigen::Dynamic, 1>>(u.data(), 500);
    int calls = 0;
    const auto diffuse = [&calls](const auto& from, auto& to) {
      ++calls;
      for (Eigen::Index i = 0; i < 500; ++i)
        to[i] = (i > 0 ? from[i - 1] : 0) - 2 * from[i] + (i < 499 ? from[i + 1] : 0);
    };
    Scalar* const at = u.data();
    Scalar* const to = rate.data();
    phistep::VectorInPlace state{phistep::places(at, 500), phistep::places(rate)};
    phistep::PhiStepper stepper{state, state.force([&, at, to]() mutable { diffuse(at, to); }), scheme, solver};
    phistep::PhiStepper other{y,
                              [&diffuse](const Eigen::Matrix<Scalar, Eigen::Dynamic, 1>& now) {
                                Eigen::Matrix<Scalar, Eigen::Dynamic, 1> f(500);
                                diffuse(now, f);
                                return f;
                              },
                              scheme, solver};
    for (int n = 0; n < 10; ++n) {
      REQUIRE(stepper.step(state, static_cast<Scalar>(n), Scalar{0.25}));
      REQUIRE(other.step(y, static_cast<Scalar>(n), Scalar{0.25}));
    }
    CHECK(std::equal(u.begin(), u.end(), y.data()));
    CHECK(stepper.statistics().force_calls == other.statistics().force_calls);
  };
  heat(1.0, phistep::forward_euler, phistep::newton());
  heat(1.0F, phistep::forward_euler, phistep::newton());
  heat(1.0L, phistep::forward_euler, phistep::newton());
  heat(1.0, phistep::backward_euler, phistep::fixed_point());
  heat(1.0, phistep::trapezoidal, phistep::newton<phistep::MatrixFree<Eigen::GMRES>>());
}

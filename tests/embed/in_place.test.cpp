// States in the arrays of a code. The other layouts with the other schemes: the stress tier.
#include <phistep/in_place.hpp>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdint>
#include <stdexcept>
#include <utility>
#include <vector>

#include "embed/layouts.hpp"
#include "support/shared_force.hpp"
#if PHISTEP_STRESS
#include <phistep/krylov.hpp>

#endif

namespace in_place_cases {

using namespace layouts;
inline constexpr double dt = 0.01;

template <class Code>
auto in_place(Code& code) {
  return phistep::MotionInPlace{code.positions(), code.velocities(), code.rates()};
}
/// The code's routine as a force of r: one type for each layout.
template <class Code>
auto force_of(auto& state, Code& code) {
  return state.force_of_r([&code] { code.forces(); });
}
using Copied = shared_force::OfState<Eigen::Matrix3Xd>;
/// Ψ(r) of a force that copied_force gives as Ψ(r, v, t): one type for all layouts.
template <class Code>
Copied copied_force_of_r(Code& scratch) {
  return [force = copied_force(scratch)](const Eigen::Matrix3Xd& r) -> Eigen::Matrix3Xd {
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
  phistep::PhiStepper stepper{state, force_of(state, code), scheme, phistep::mass(2.0), solver};
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
template <class Code, bool velocities>
void faults_leave_nothing(auto scheme, auto solver, bool nan_is_fatal = true) {
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
    if constexpr (velocities) go(state.force_of_rv([&code](double t) { code.forces(t); }));
    else go(force_of(state, code));
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

/// A diffusion in the arrays of a code and in a vector of the library's: the same bits and calls.
template <class Scalar>
void same_heat(auto scheme, auto solver) {
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
}

}  // namespace in_place_cases

using namespace in_place_cases;

#if PHISTEP_FULL

TEST_CASE("in place: a step gives the bits and the calls of a state that the library owns", "[embed]") {
  same_as_owned<Structs>(phistep::forward_euler, phistep::newton());
  same_as_owned<Structs>(phistep::symplectic_euler, phistep::newton());
  same_as_owned<Structs>(phistep::velocity_verlet, phistep::newton());
  same_as_owned<Structs>(phistep::srkn6b, phistep::newton());
  same_as_owned<Structs>(phistep::midpoint, phistep::fixed_point());
  same_as_owned<Rows>(phistep::velocity_verlet, phistep::newton());
  same_as_owned<Components>(phistep::velocity_verlet, phistep::newton());
  same_as_owned<Vectors>(phistep::velocity_verlet, phistep::newton());
}

TEST_CASE("in place: a fault in any call of the routine leaves every bit", "[embed]") {
  faults_leave_nothing<Structs, false>(phistep::velocity_verlet, phistep::newton());
  faults_leave_nothing<Structs, true>(phistep::symplectic_euler, phistep::newton());
  faults_leave_nothing<Structs, true>(phistep::midpoint, phistep::fixed_point());
  faults_leave_nothing<Components, false>(phistep::velocity_verlet, phistep::newton());
}

TEST_CASE("in place: edits of positions are noticed, of velocities and forces they do no harm", "[embed]") {
  Structs code(20);
  auto state = in_place(code);
  phistep::PhiStepper stepper{state, force_of(state, code), phistep::velocity_verlet};
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
  phistep::PhiStepper stepper{state, force_of(state, code), phistep::velocity_verlet,
                              phistep::mass(phistep::places(code.beads, &Structs::Bead::m))};
  for (int n = 0; n < 5; ++n) REQUIRE(stepper.step(state, n * dt, dt));
  code.beads.erase(code.beads.begin() + 3, code.beads.begin() + 13);
  few.beads = code.beads;
  auto fresh_state = in_place(few);
  phistep::PhiStepper fresh{fresh_state, force_of(fresh_state, few), phistep::velocity_verlet,
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
  phistep::PhiStepper stepper{state, force_of(state, code), phistep::velocity_verlet};
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

TEST_CASE("in place: samples are in the arrays while they are shown, and nothing is left of them", "[embed]") {
  Rows code(12), scratch(12), plain(12);
  auto y = owned(scratch);
  auto state = in_place(code), unobserved = in_place(plain);
  phistep::PhiStepper stepper{state, force_of(state, code), phistep::velocity_verlet};
  phistep::PhiStepper other{y, copied_force_of_r(scratch), phistep::velocity_verlet};
  phistep::PhiStepper third{unobserved, force_of(unobserved, plain), phistep::velocity_verlet};
  std::vector<std::vector<double>> samples, expected;
  // From the first on f is given the state itself.
  const auto look = [&](double, const decltype(state)& now) {
    CHECK(&now == &state);
    samples.push_back(code.state());
  };
  const auto look_at_own = [&](double, const auto& now) { expected.push_back(numbers_of(now)); };
  REQUIRE(phistep::integrate(stepper, state, {0.0, 1.0}, phistep::fixed(0.03), phistep::sampled(0.25, look)));
  REQUIRE(phistep::integrate(other, y, {0.0, 1.0}, phistep::fixed(0.03), phistep::sampled(0.25, look_at_own)));
  REQUIRE(phistep::integrate(third, unobserved, {0.0, 1.0}, phistep::fixed(0.03)));
  CHECK(samples.size() == 5);
  CHECK(samples == expected);
  CHECK(code.numbers() == plain.numbers());
}

TEST_CASE("in place: a routine is a term among others, and a stepper one among wrappers", "[embed]") {
  Structs code(30), alone(30), halved(30);
  auto state = in_place(code), other = in_place(alone), third = in_place(halved);
  const auto falling = [&alone] {
    alone.forces();
    for (auto& bead : alone.beads) bead.f[2] += 2.0 * -9.81;
  };
  phistep::PhiStepper stepper{state, force_of(state, code) + phistep::Gravity{Eigen::Vector3d(0, 0, -9.81)},
                              phistep::velocity_verlet, phistep::mass(2.0)};
  phistep::PhiStepper one{other, other.force_of_r(falling), phistep::velocity_verlet, phistep::mass(2.0)};
  REQUIRE(phistep::integrate(stepper, state, {0.0, 0.2}, phistep::fixed(dt)));
  REQUIRE(phistep::integrate(one, other, {0.0, 0.2}, phistep::fixed(dt)));
  CHECK(code.state() == alone.state());
  CHECK(code.calls == alone.calls);

  phistep::Halving halving{phistep::PhiStepper{third, force_of(third, halved), phistep::velocity_verlet}};
  halved.fault = {Fault::Kind::nan, 3};  // in the second step, which is then done as two
  for (int n = 0; n < 4; ++n) REQUIRE(halving.step(third, n * dt, dt));
  CHECK(halved.calls > 6);
}

TEST_CASE("in place: the message of a step that fails names the particle", "[embed]") {
  Rows code(30);
  auto state = in_place(code);
  phistep::PhiStepper stepper{state, force_of(state, code), phistep::velocity_verlet};
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
  phistep::PhiStepper stepper{state, force_of(state, code), phistep::velocity_verlet};
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
  same_heat<double>(phistep::forward_euler, phistep::newton());
  same_heat<float>(phistep::forward_euler, phistep::newton());
  same_heat<long double>(phistep::forward_euler, phistep::newton());
  same_heat<double>(phistep::backward_euler, phistep::fixed_point());
}

#elif PHISTEP_STRESS
// States in the arrays of a code: the layouts with the schemes that in_place.test leaves out.

TEMPLATE_TEST_CASE("in place: a step gives the bits and the calls of a state that the library owns", "[embed]", Rows,
                   Components, Vectors) {
  same_as_owned<TestType>(phistep::forward_euler, phistep::newton());
  same_as_owned<TestType>(phistep::symplectic_euler, phistep::newton());
  same_as_owned<TestType>(phistep::srkn6b, phistep::newton());
  same_as_owned<TestType>(phistep::midpoint, phistep::fixed_point());
}

TEST_CASE("in place: a fault in any call of the routine leaves every bit", "[embed]") {
  faults_leave_nothing<Structs, false>(phistep::forward_euler, phistep::newton());
  faults_leave_nothing<Structs, true>(phistep::velocity_verlet, phistep::fixed_point());
  faults_leave_nothing<Components, false>(phistep::forward_euler, phistep::newton());
  faults_leave_nothing<Components, true>(phistep::symplectic_euler, phistep::newton());
  faults_leave_nothing<Components, true>(phistep::velocity_verlet, phistep::fixed_point());
  faults_leave_nothing<Components, true>(phistep::midpoint, phistep::fixed_point());
  // GMRES ends at a product that is not finite, and the next correction mends what that left.
  const auto gmres = phistep::newton<phistep::MatrixFree<phistep::KrylovMethod::gmres>>();
  faults_leave_nothing<Structs, true>(phistep::midpoint, gmres, false);
  faults_leave_nothing<Components, true>(phistep::midpoint, gmres, false);
}

TEST_CASE("in place: a field and its rates, float and long double", "[embed]") {
  same_heat<double>(phistep::trapezoidal, phistep::newton<phistep::MatrixFree<phistep::KrylovMethod::gmres>>());
}

#endif

#pragma once

// What the quick and the full tests of states in place share.
#include <phistep/in_place.hpp>

#include <catch2/catch.hpp>

#include <algorithm>
#include <cmath>
#include <vector>

#include "embed/layouts.hpp"
#include "support/shared_force.hpp"

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

#include <phistep/in_place.hpp>

#include <catch2/catch.hpp>

#include <cstdint>
#include <random>
#include <vector>

#include "embed/layouts.hpp"

using namespace layouts;

namespace {
/// A history drawn at random: steps and runs of drawn lengths, edits of positions, velocities and forces, faults. In place and
/// on a state of the library's own it is the same to the bit, and a failed step leaves every bit, forces included where nobody
/// has written to them.
template <class Code, class Scheme>
void same_history(std::uint32_t seed, Scheme scheme, auto solver) {
  std::mt19937 random(seed);
  const auto draw = [&random](std::uint32_t n) { return random() % n; };
  constexpr std::size_t sizes[] = {1, 2, 3, 127, 128, 129, 300};
  const std::size_t n = sizes[draw(7)];
  CAPTURE(seed, n, scheme.name());
  Code code(n), scratch(n);
  auto y = owned(code);
  phistep::MotionInPlace state{code.positions(), code.velocities(), code.rates()};
  const Eigen::VectorXd m = Eigen::VectorXd::LinSpaced(static_cast<Eigen::Index>(n), 0.5, 2.5);
  phistep::PhiStepper stepper{state, state.force_of_r([&code] { code.forces(); }), scheme, phistep::mass(m), solver};
  phistep::PhiStepper other{y,
                            [force = copied_force(scratch)](const Eigen::Matrix3Xd& r) {
                              return force(r, Eigen::Matrix3Xd::Zero(3, r.cols()), 0.0);
                            },
                            scheme, phistep::mass(m), solver};
  double t = 0;
  bool wrote_forces = false;
  for (int k = 0; k < 25; ++k) {
    const std::size_t i = draw(static_cast<std::uint32_t>(n)), d = draw(3);
    const double by = 0.125 * (1 + static_cast<double>(draw(8)));
    const auto row = static_cast<Eigen::Index>(d), column = static_cast<Eigen::Index>(i);
    switch (draw(8)) {
      case 0:
        code.x(i, d) += by, y.r(row, column) += by;
        break;
      case 1:
        code.v(i, d) -= by, y.v(row, column) -= by;
        break;
      case 2:
        code.f(i, d) = by, wrote_forces = true;
        break;
      case 3: {
        const double t1 = t + 0.01 * (1 + static_cast<double>(draw(5)));
        REQUIRE(phistep::integrate(stepper, state, {t, t1}, phistep::fixed(0.01)));
        REQUIRE(phistep::integrate(other, y, {t, t1}, phistep::fixed(0.01)));
        t = t1, wrote_forces = false;
        break;
      }
      case 4: {
        const auto before = code.numbers(), before_state = code.state();
        const auto kind = draw(2) == 0 ? Fault::Kind::nan : Fault::Kind::thrown;
        code.fault = {kind, code.calls + 1 + static_cast<int>(draw(2))};
        const int calls = code.calls;
        bool done = false;
        try {
          done = static_cast<bool>(stepper.step(state, t, 0.01));
        } catch (const Thrown&) {
        }
        code.fault = {};
        if (done) {
          REQUIRE(other.step(y, t, 0.01));
          t += 0.01, wrote_forces = false;
        } else {
          REQUIRE(code.state() == before_state);
          if (!wrote_forces) REQUIRE(code.numbers() == before);
          other.reset();  // it fails nowhere, and asks again
        }
        REQUIRE(code.calls > calls);
        break;
      }
      default: {
        const double dt = 0.005 * (1 + static_cast<double>(draw(3)));
        REQUIRE(stepper.step(state, t, dt));
        REQUIRE(other.step(y, t, dt));
        t += dt, wrote_forces = false;
      }
    }
    REQUIRE(code.state() == numbers_of(y));
  }
}
}  // namespace

TEMPLATE_TEST_CASE("in place: any history gives the bits of a state that the library owns", "[embed]", Structs, Rows,
                   Components, Vectors) {
  for (std::uint32_t seed = 1; seed <= 40; ++seed) {
    same_history<TestType>(seed, phistep::forward_euler, phistep::newton());
    same_history<TestType>(seed, phistep::symplectic_euler, phistep::newton());
    same_history<TestType>(seed, phistep::velocity_verlet, phistep::newton());
    same_history<TestType>(seed, phistep::srkn6b, phistep::newton());
  }
}

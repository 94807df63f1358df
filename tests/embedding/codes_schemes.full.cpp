// Three existing codes with other schemes than their loops': implicit ones, tolerances, events, states of their own library.
#include <phistep/krylov.hpp>

#include "embedding/codes_cases.hpp"

using namespace codes_cases;
using phistep::fixed_point, phistep::newton, phistep::MatrixFree;

namespace {

/// The code's state at t1, from steps of dt.
template <class Code>
Numbers at_end(Code& code, double t1, double dt, auto scheme, auto... solver) {
  in_place(code, [&](auto& state, auto force) {
    const auto go = [&](auto&&... more) {
      phistep::PhiStepper stepper{state, force, scheme, more...};
      const auto report = phistep::integrate(stepper, state, {0, t1}, phistep::fixed(dt));
      INFO(report.message());
      REQUIRE(report);
    };
    if constexpr (requires { mass_of(code); }) go(mass_of(code), solver...);
    else go(solver...);
  });
  return state_of(code);
}
/// How much of its error at dt a method has at dt/2: 2^order.
template <class Code>
double gain(int n, const Numbers& right, double t1, double dt, auto scheme, auto... solver) {
  Code whole(n), half(n);
  const double error = distance(at_end(whole, t1, dt, scheme, solver...), right);
  return error / distance(at_end(half, t1, dt / 2, scheme, solver...), right);
}

}  // namespace

TEST_CASE("masses on springs: implicit schemes") {
  const double t1 = 0.032, dt = 1e-3;
  before::Cloth fine(36);
  fine.run_verlet(3200, t1 / 3200);
  const Numbers right = state_of(fine);
  // The reference's own error is below 1 % of what is measured; the rest is of higher order in dt.
  const double second = gain<after::Cloth>(36, right, t1, dt / 4, phistep::midpoint, fixed_point());
  CHECK(second > 3.6);
  CHECK(second < 4.4);
  const auto krylov = newton<MatrixFree<>>();
  const double first = gain<after::Cloth>(36, right, t1, dt / 8, phistep::backward_euler, krylov);
  CHECK(first > 1.6);
  CHECK(first < 2.4);
}

TEST_CASE("masses on springs: steps too long for Verlet") {
  constexpr double dt = 0.01;  // Verlet is stable up to about 2/√(8 k/m) = 0.003
  after::Cloth cloth(36), lost(36);
  const double energy = cloth.energy();
  at_end(cloth, 0.5, dt, phistep::backward_euler, newton<MatrixFree<>>({.rtol = 1e-6}));
  CHECK(cloth.energy() < energy);
  at_end(lost, 0.5, dt, phistep::velocity_verlet);
  CHECK(lost.energy() > 100 * std::abs(energy));
}

TEST_CASE("molecular dynamics: implicit schemes") {
  const double t1 = 0.064;
  before::MolecularDynamics fine(64);
  fine.run(6400, t1 / 6400);
  const Numbers right = state_of(fine);
  const double second = gain<after::MolecularDynamics>(64, right, t1, 0.002, phistep::trapezoidal, fixed_point());
  CHECK(second > 3.6);
  CHECK(second < 4.4);
}

TEST_CASE("heat: implicit schemes, and steps a hundred times longer than forward Euler's") {
  before::HeatPlate fine(100);
  const double t1 = 0.2, stable = fine.largest_stable_step();
  fine.run(20000, t1 / 20000);
  const Numbers right = state_of(fine);
  const auto krylov = newton<MatrixFree<>>();
  const double first = gain<after::HeatPlate>(100, right, t1, 0.01, phistep::backward_euler, krylov);
  CHECK(first > 1.6);
  CHECK(first < 2.4);
  after::HeatPlate by_long_steps(100);
  CHECK(distance(at_end(by_long_steps, 2000 * stable, 100 * stable, phistep::tr_bdf2, krylov), right) < 1);
  CHECK(by_long_steps.largest_rate() < 1e-3);
}

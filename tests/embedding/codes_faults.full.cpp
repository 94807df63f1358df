// A fault in every call of an existing code's force routine: its arrays keep every bit, and the run goes on from them.
#include "embedding/codes_cases.hpp"

#include <memory>

using namespace codes_cases;

namespace {

/// Whether step n does; exceptions are the fault's own.
bool stands(Trouble trouble, auto step, int n) {
  try {
    return step(n);
  } catch (const Struck&) {
    CHECK(trouble == Trouble::exception);
    return false;
  }
}

/// Step by step with one stepper. `loop(code, body)` calls body(step), where step(n) does step n and says if it stood.
void every_call(auto make, auto loop, int steps) {
  const auto good = make();
  loop(*good, [&](auto step) {
    for (int n = 0; n < steps; ++n) REQUIRE(step(n));
  });
  const long calls = good->force_calls;
  REQUIRE(calls >= steps);
  for (long at = 1; at <= calls; ++at)
    for (const Trouble trouble : {Trouble::nan, Trouble::infinity, Trouble::exception}) {
      CAPTURE(at, static_cast<int>(trouble));
      const auto code = make();
      strike(*code, at, trouble);
      int failures = 0;
      loop(*code, [&](auto step) {
        for (int n = 0; n < steps; ++n) {
          const Numbers state = state_of(*code), forces = forces_of(*code);
          if (stands(trouble, step, n)) continue;
          ++failures;
          CHECK(same_bits(state_of(*code), state));
          CHECK(same_bits(forces_of(*code), forces));
          REQUIRE(step(n));
        }
      });
      CHECK(failures == 1);
      CHECK(same_bits(state_of(*code), state_of(*good)));
      CHECK(same_bits(forces_of(*code), forces_of(*good)));
    }
}

/// The code's own run: stopped by a fault it has done the steps before it, every bit of them, and can go on.
template <class Loop>
void every_call_of_a_run(auto make, int steps, long calls_before_a_step) {
  std::vector<Numbers> good;
  {
    const auto code = make();
    for (int n = 0; n <= steps; ++n) {
      good.push_back(state_of(*code));
      Loop::run(*code, 1);
    }
  }
  for (long at = 1; at <= steps + calls_before_a_step; ++at)
    for (const Trouble trouble : {Trouble::nan, Trouble::exception}) {
      CAPTURE(at, static_cast<int>(trouble));
      const auto code = make();
      strike(*code, at, trouble);
      CHECK_THROWS_AS(Loop::run(*code, steps), std::runtime_error);
      const auto done = static_cast<std::size_t>(std::max(at - 1 - calls_before_a_step, 0L));
      CHECK(same_bits(state_of(*code), good[done]));
      Loop::run(*code, steps - static_cast<int>(done));
      CHECK(same_bits(state_of(*code), good[static_cast<std::size_t>(steps)]));
    }
}

/// A stepper that outlives its failures.
constexpr auto by = [](auto scheme, double dt) {
  return [=](auto& code, auto body) {
    in_place(code, [&](auto& state, auto force) {
      const auto go = [&](auto&&... mass) {
        phistep::PhiStepper stepper{state, force, scheme, mass...};
        body([&](int n) { return static_cast<bool>(stepper.step(state, n * dt, dt)); });
      };
      if constexpr (requires { mass_of(code); }) go(mass_of(code));
      else go();
    });
  };
};
constexpr auto cloth = [] { return std::make_unique<after::Cloth>(25); };
constexpr auto atoms = [] { return std::make_unique<after::MolecularDynamics>(64); };
constexpr auto plate = [] { return std::make_unique<after::HeatPlate>(100); };

}  // namespace

TEST_CASE("a fault in any call: the code's arrays keep every bit, and its run goes on") {
  every_call(cloth, by(phistep::symplectic_euler, Euler::dt), 5);
  every_call(cloth, by(phistep::velocity_verlet, Verlet::dt), 5);
  every_call(atoms, by(phistep::velocity_verlet, Atoms::dt), 5);
  every_call(plate, by(phistep::forward_euler, Heat::dt), 5);
}

TEST_CASE("a fault in any call of a code's own run leaves it where the last good step ended") {
  every_call_of_a_run<Euler>(cloth, 5, 0);
  every_call_of_a_run<Verlet>(cloth, 5, 1);
  every_call_of_a_run<Atoms>(atoms, 5, 1);
  every_call_of_a_run<Heat>(plate, 5, 0);
}

// First-order problems, restarted anywhere: every scheme and the ways to solve. All products: restart*.full.cpp.
#include <memory>
#include <utility>
#include <vector>

#include "contract/restart.hpp"
#include "contract/restart_cases.hpp"
#include "contract/states.hpp"
#include "support/catch.hpp"
#if PHISTEP_QUICK
#include <phistep/phistep.hpp>
#endif
#if PHISTEP_FULL
#include <phistep/autodiff.hpp>
#endif

using namespace phistep;
using namespace restart_cases;

#if PHISTEP_QUICK

// One more scheme on the same state, force and solver is cheap to compile; anything else is not.
TEST_CASE("explicit and implicit schemes restart to the same bits") {
  states::for_each_first_order_scheme([](const char* name, auto scheme) {
    CAPTURE(name);
    check(uneven, start, steps(chain, scheme));
  });
}

TEST_CASE("Jacobians that are kept to rounding survive a restart") {
  // A near start for a slow run: θ ≤ 1e-3.
  const Statistics s = check({1e-3}, start, steps(chain, trapezoidal));
  CHECK(s.jacobians < 10);
}

TEST_CASE("Jacobians and scaled factors that are kept to a tolerance survive a restart") {
  const auto s = check(loosely(uneven), start, steps(chain, tr_bdf2, tolerant()));
  CHECK(s.jacobians < s.steps);
  CHECK(s.factorizations < s.steps);  // of 60 lengths, two resolves each
}

TEST_CASE("Rannacher's start goes on where it was") { check(even, start, steps(chain, rannacher(3))); }

TEST_CASE("banded and sparse systems restart to the same bits") {
  check(loosely(uneven), start, steps(banded(chain, 1, 1), tr_bdf2, tolerant()));
}

TEST_CASE("affine forces go on with their factors and their checks") {
  const Statistics dense = check(even, start, steps(linear(tangent(start())), trapezoidal));
  CHECK(dense.jacobians == 1);
  CHECK(dense.factorizations == 1);
}

TEST_CASE("iterations without a matrix restart to the same bits") {
  check(uneven, start, steps(chain, tr_bdf2, fixed_point()));
}

TEST_CASE("states that live in somebody's own memory") {
  // The unbroken run and each restart have a home of their own.
  std::vector<std::unique_ptr<states::Home<states::Strided>>> homes;
  const auto strided = [&homes] {
    homes.push_back(std::make_unique<states::Home<states::Strided>>());
    return homes.back()->block(states::positions);
  };
  check(uneven, strided, steps(chain, forward_euler));
}

TEST_CASE("halving goes on with its counts") {
  // Newton may take two iterations: long steps stall, and are halved.
  const shared_force::OfState<Vec> stiff = [](const Vec& y) -> Vec { return (-20 * y.array().cube() + 10).matrix(); };
  const auto make = [&](const auto& y) {
    return Halving{PhiStepper{y, stiff, phi(0.7), newton({.max_iterations = 6})}, 8};
  };
  const Statistics s = check({0.2, false, 20}, start, make);
  CHECK(s.halvings > 0);
}

TEST_CASE("a stepper that is moved takes its factors along, whatever the solver") {
  check_moved(steps(chain, tr_bdf2, tolerant()));
}

#elif PHISTEP_FULL
// First-order problems, restarted anywhere: every scheme, dense and without a matrix.

TEST_CASE("explicit and implicit schemes restart to the same bits") {
  states::for_each_first_order_scheme([](const char* name, auto scheme) {
    CAPTURE(name);
    check(even, start, steps(chain, scheme));
    check(uneven, start, steps(states::DrivenPull{}, scheme));
  });
}

TEST_CASE("a carried force") {
  // φ > ½ and TR-BDF2 recover Ψ from the resolve: by a fixed point, it goes on over a restart; where a Jacobian is to be
  // made anew, so is Ψ.
  const Statistics s = check(even, start, steps(chain, phi(0.7), fixed_point()));
  CHECK(s.force_calls == s.iterations - 59);  // each step's first is there already, but that of the first step
  check(loosely(uneven), start, steps(WithJacobian{}, tr_bdf2));
  check(even, start, steps(chain, phi(0.7), linearly_implicit()));
}

TEST_CASE("Jacobians that are kept to rounding survive a restart") {
  // A near start for a slow run: θ ≤ 1e-3.
  const Steps slow{1e-3};
  const Statistics s = check(slow, start, steps(chain, trapezoidal));
  CHECK(s.jacobians < 10);
  check(slow, start, steps(WithJacobian{}, trapezoidal));
  check({1e-3, false}, start, steps(autodiff(Chain{}), backward_euler));
}

TEST_CASE("Jacobians and scaled factors that are kept to a tolerance survive a restart") {
  const auto differences = check(loosely(uneven), start, steps(chain, tr_bdf2, tolerant()));
  const auto analytic = check(loosely(uneven), start, steps(WithJacobian{}, tr_bdf2, tolerant()));
  const auto automatic = check(loosely(uneven), start, steps(autodiff(Chain{}), tr_bdf2, tolerant()));
  for (const Statistics& s : {differences, analytic, automatic}) {
    CHECK(s.jacobians < s.steps);
    CHECK(s.factorizations < s.steps);  // of 60 lengths, two resolves each
  }
}

TEST_CASE("Rannacher's start goes on where it was") {
  check(even, start, steps(chain, rannacher(3)));
  check(loosely(uneven), start, steps(WithJacobian{}, rannacher(2), tolerant()));
}

TEST_CASE("states that live in somebody's own memory") {
  // The unbroken run and each restart have a home of their own.
  std::vector<std::unique_ptr<states::Home<states::Mapped>>> homes;
  const auto mapped = [&homes] {
    homes.push_back(std::make_unique<states::Home<states::Mapped>>());
    return homes.back()->block(states::positions);
  };
  const auto force = [](const Vec& y) -> Vec { return Chain{}(y); };
  check(loosely(uneven), mapped, steps(force, tr_bdf2, tolerant()));
  std::vector<std::unique_ptr<states::Home<states::Strided>>> strided_homes;
  const auto strided = [&strided_homes] {
    strided_homes.push_back(std::make_unique<states::Home<states::Strided>>());
    return strided_homes.back()->block(states::positions);
  };
  check(uneven, strided, steps(force, phi(0.7)));
  check(
      uneven,
      [] {
        return states::RowMajor{{0.1, -0.4}, {0.9, 0.3}, {-0.7, 0.2}};
      },
      steps(states::Pull{}, tr_bdf2));
}

TEST_CASE("halving goes on with its counts") {
  // Newton may take two iterations: long steps stall, and are halved.
  const auto stiff = [](const Vec& y) -> Vec { return (-20 * y.array().cube() + 10).matrix(); };
  const auto make = [&](const auto& y) {
    return Halving{PhiStepper{y, stiff, phi(0.7), newton({.max_iterations = 6})}, 8};
  };
  const Statistics s = check({0.2, false, 20}, start, make);
  CHECK(s.halvings > 0);
}

#endif

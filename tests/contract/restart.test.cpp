// First-order problems, restarted anywhere: every scheme and the ways to solve. All products: restart*.full.cpp.
#include <phistep/phistep.hpp>

#include <memory>
#include <utility>
#include <vector>

#include "contract/restart.hpp"
#include "contract/restart_cases.hpp"
#include "contract/states.hpp"
#include "support/catch.hpp"

using namespace phistep;
using namespace restart_cases;

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

// No heap allocation of ours in `step` after construction. Counts every allocation that Eigen or the library could
// make. In short: one scheme of each kind, one solver of each kind. All of them: step*.full.cpp.
#define EIGEN_RUNTIME_NO_MALLOC  // a second, independent witness: Eigen asserts where it allocates
#include <phistep/in_place.hpp>

#include <array>
#include <vector>

#include "allocation/step_watched.hpp"

#if PHISTEP_TEST_COUNTS_MALLOC
TEST_CASE("the counter counts") {
  static Dynamic* volatile kept;  // or the compiler removes the pair
  heap::count = 0, heap::counting = true;
  kept = new Dynamic(100);
  heap::counting = false;
  delete kept;
  CHECK(heap::count == 2);
}
#endif

TEST_CASE("every scheme, dynamic motion, Newton by differences: nothing") {
  check_none(motion(30), Chain{}, forward_euler);
  check_none(motion(30), Chain{}, trapezoidal);
  check_none(motion(150), Chain{}, trapezoidal);
  check_none(motion(30), Chain{}, backward_euler);
  check_none(motion(30), Chain{}, velocity_verlet);
}
TEST_CASE("schemes of high order, dynamic: nothing") {
  check_none(motion(30), Chain{}, rkn86);
  check_none(motion(30), Chain{}, tsit5);
}
TEST_CASE("velocities, masses of every kind, a sum, a tolerance: nothing") {
  check_none(motion(30), Chain{}, trapezoidal, newton({.rtol = 1e-6, .atol = 1e-9}));
}
TEST_CASE("fixed-point iteration, plain and accelerated: nothing") {
  check_none(motion(30), Chain{}, trapezoidal, fixed_point({.depth = 0}));
  check_none(motion(30), Chain{}, trapezoidal, fixed_point({.depth = 5}));
}
TEST_CASE("views, matrices, arrays of structs: nothing") {
  states::SecondOrder<states::Columns> columns;
  PhiStepper stepper{columns.state, Chain{}, velocity_verlet};
  CHECK(allocations(columns.state, stepper) == 0);
}
TEST_CASE("states in place: nothing") {
  std::vector<std::array<double, 3>> r(50), v(50), f(50);
  MotionInPlace state{places(r), places(v), places(f)};
  const auto force = [&] {
    for (std::size_t i = 0; i < r.size(); ++i)
      for (std::size_t d = 0; d < 3; ++d) f[i][d] = 1 - r[i][d];
  };
  const auto check = [&](auto scheme, auto solver) {
    PhiStepper stepper{state, state.force_of_r(force), scheme, solver};
    CHECK(allocations(state, stepper) == 0);
  };
  check(forward_euler, newton());
  check(velocity_verlet, newton());
  check(srkn6b, newton());
}
TEST_CASE("springs by Verlet: nothing") {
  check_none(motion(30), spring_network<3>({{0, 1, 5, 0.1}, {1, 2, 5, 0.1}}), velocity_verlet);
}
TEST_CASE("split terms, Rannacher's start, a step around a step: nothing") {
  auto y = motion(30);
  Halving halving{PhiStepper{y, Chain{}, trapezoidal}};
  CHECK(allocations(y, halving) == 0);
}
TEST_CASE("a step that fails: nothing") {
  auto y = motion(30);
  PhiStepper stepper{y, Chain{}, trapezoidal};
  REQUIRE(stepper.step(y, 0, 0.1));
  y.r[3] = std::nan("");
  heap::count = 0, heap::counting = true;
  const StepReport report = stepper.step(y, 0, 0.1);
  heap::counting = false;
  CHECK_FALSE(report);
  CHECK(heap::count == 0);
}
TEST_CASE("bands, blocks and differences by colour: nothing after the first step, which finds the band") {
  Dynamic y = Dynamic::LinSpaced(500, -1, 1);
  PhiStepper stepper{y, BandedChain{}, tr_bdf2};
  CHECK(allocations(y, stepper, 1) == 0);
  CHECK(stepper.statistics().factorizations >= 11);
}
TEST_CASE("watched, rejected and doubled steps: nothing") {
  check_none_watched(motion(30), Chain{}, trapezoidal);      // doubled
  check_none_watched(motion(30), Chain{}, velocity_verlet);  // estimates by itself
}
TEST_CASE("controlled runs, after their first steps: nothing") {
  for (const auto filter : {StepFilter::automatic, StepFilter::predictive})
    check_none_run(motion(30), Chain{}, velocity_verlet, tolerance{.rtol = 1e-4, .filter = filter});
}
TEST_CASE("sampled runs, after their first steps: nothing") {
  check_none_sampled(motion(30), Chain{}, velocity_verlet, tolerance{.rtol = 1e-5}, 0.0002);
  check_none_sampled(motion(30), Chain{}, trapezoidal, fixed(0.05), 0.002);
}

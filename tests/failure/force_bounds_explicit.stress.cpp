// Forces that are NaN beyond a bound, under explicit schemes. The members are those of force_bounds.hpp.
#include "failure/force_bounds.hpp"

using namespace force_bounds;

// Counts that may flip with a rounding have some room.
constexpr int members = 600, known_blind = 146;

namespace {

const Batteries& bounds() {
  static const Batteries all{"force bounds, explicit",
                             {
                                 subject<Flow>("forward_euler", forward_euler, 3, false),
                                 subject<Flow>("tsit5", tsit5, 9, false),
                                 subject<Flow>("dop853", dop853, 9, false),
                             },
                             members};
  return all;
}

/// dop853 where the solution rests near to its bound, at loose tolerances.
const battery::Tally& near_logarithms() {
  static const battery::Tally counted = [] {
    battery::Tally tally{"force bounds, dop853 near to a logarithm's end"};
    const Subject<Flow> scheme = subject<Flow>("dop853", dop853);
    for (const double tol : {1e-2, 1e-3, 1e-4})
      for (int n = 0; n <= 80; ++n) {
        Flow problem = near_a_logarithm(1, 0.1 + 0.0025 * n);
        bool refused = false;
        const std::string found = verdict(problem, scheme, {.is_fixed = false, .rtol = tol, .atol = tol}, refused);
        tally.count(found.empty(), problem.name + ", rtol and atol " + figures::text(tol) + ": " + found);
      }
    return tally;
  }();
  return counted;
}

}  // namespace

TEST_CASE("force bounds, explicit, a tolerance: none is wrong") {
  battery::at_most(0, bounds().touching());
  battery::at_most(0, bounds().inside());
  battery::at_most(0, near_logarithms());
}
TEST_CASE("force bounds, explicit, fixed steps: no more are wrong than known") {
  battery::at_most(known_blind, bounds().blind_steps());
}
TEST_CASE("force bounds, explicit, fixed steps: none is wrong", "[!shouldfail][48]") {
  battery::none(bounds().blind_steps());
}

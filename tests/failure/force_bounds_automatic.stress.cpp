// Forces that are NaN beyond a bound, where the library chooses the scheme. The members are those of force_bounds.hpp.
#include <phistep/automatic.hpp>

#include "failure/force_bounds.hpp"

using namespace force_bounds;

constexpr int members = 400;

namespace {

const Batteries& bounds() {
  static const Batteries all{"force bounds, automatic",
                             {{"automatic",
                               [](Flow& problem, const Control& control) {
                                 tolerance tol{.rtol = control.rtol, .max_steps = 50000};
                                 if (control.atol >= 0) tol.atol = control.atol;
                                 return integrate(problem.y, problem.force, {0, problem.t1}, tol);
                               }}},
                             members};
  return all;
}

}  // namespace

TEST_CASE("force bounds, automatic, touched: none is wrong") { battery::at_most(0, bounds().touching()); }
TEST_CASE("force bounds, automatic, inside: none is wrong") { battery::at_most(0, bounds().inside()); }

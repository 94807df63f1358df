// Forces that are NaN beyond a bound, under stiff schemes. The members are those of force_bounds.hpp.
#include "failure/force_bounds.hpp"

using namespace force_bounds;

#if PHISTEP_STRESS
constexpr int members = 600;
#elif PHISTEP_FULL
constexpr int members = 90;
#endif

namespace {

const Batteries& bounds() {
  static const Batteries all{"force bounds, stiff",
                             {
                                 subject<Flow>("rodas5p", rodas5p),
                                 subject<Flow>("radau", radau),
#if PHISTEP_STRESS
                                 subject<Flow>("rodas4p2", rodas4p2),
                                 subject<Flow>("radau(3)", radau(3)),
#endif
                             },
                             members};
  return all;
}

}  // namespace

TEST_CASE("force bounds, stiff, touched under a tolerance: none is wrong") { battery::at_most(0, bounds().touching()); }
TEST_CASE("force bounds, stiff, inside under a tolerance: none is wrong") { battery::at_most(0, bounds().inside()); }
TEST_CASE("force bounds, stiff, fixed steps: none is wrong") { battery::at_most(0, bounds().fixed_steps()); }

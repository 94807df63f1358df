// A tolerance means what it says: on ten problems, stiff and not, flows and motions, the error at the end follows rtol
// over six decades and stays within what the problem itself makes of an error of that size. All ten, by each scheme:
// tolerance*.full.cpp; here two, whose κ is given, as it was found there.

#include "acceptance/tolerance_cases.hpp"

TEST_CASE("the error is proportional to the tolerance, and no larger than the problem makes it") {
  using problems::Case;
  using problems::Kepler;
  using problems::Robertson;
  const Case robertson{"Robertson", Robertson{}, Robertson::start(), Robertson::exact(), Robertson::end, 1e-6, true};
  check(robertson, "Robertson, TR-BDF2", phistep::tr_bdf2, 1.447);
  check(robertson, "Robertson, Rodas5P", phistep::rodas5p, 1.447, high_order);
  const Kepler kepler;
  const double end = 2 * Kepler::period;
  check(Case{"Kepler, e = 0.6, two periods", kepler, kepler.start(), kepler.exact(end), end, 1.0, false},
        "Kepler, velocity Verlet", phistep::velocity_verlet, 3476.);
}

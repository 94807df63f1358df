// Failures around the schemes: of events, handlers and observers, of stages, of a solver's analysis, of half a rejected
// step. The long version of this is runs.stress.cpp.
#include "failure/calls_cases.hpp"

using namespace calls_cases;

TEST_CASE("an event's g, its handler, an observer that fail at any call: a step stands or it doesn't") {
  const Make make = machine(motion, with(Pull{}, velocity_verlet), 0.5, fixed(0.1), &Bounces::make);
  // A new run from an event on has another grid of steps.
  const Promise behind{.same_end = 1e-13, .renewed = 1e-3, .moves_on = true};
  check(every_call("force", make, Site::force, kinds, behind));  // slopes for the interpolant
  check(every_call("event", make, Site::event, kinds, behind));
  check(every_call("handler", make, Site::handler, {Kind::exception}, behind));
  check(every_call("observer", make, Site::observer, {Kind::exception}, behind));
}

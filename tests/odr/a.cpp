#include <phistep/all.hpp>

#include "step.hpp"

double step_in_a(double dt) { return step_once(dt); }

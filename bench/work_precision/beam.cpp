#include "problems/beam.hpp"

#include "driven.hpp"

work_precision::Table work_precision::beam() {
  return driven_stiff<problems::Beam>("beam", "Beam: 40 joints, pulled by a force, to t = 5", 1.0);
}

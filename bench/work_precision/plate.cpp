#include "problems/plate.hpp"

#include "driven.hpp"

work_precision::Table work_precision::plate() {
  return driven_stiff<problems::Plate>("plate", "Plate: 8 x 5 points under a car, to t = 7", 1e-3);
}

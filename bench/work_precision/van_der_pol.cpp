#include "problems/relaxation.hpp"

#include "small.hpp"

work_precision::Table work_precision::van_der_pol() {
  using problems::Relaxation;
  return small_stiff("van_der_pol", "Van der Pol, epsilon = 1e-6, to t = 2", Relaxation::start(), Relaxation{},
                     Relaxation::end, Relaxation::exact(), 1.0, 64, 262144);
}

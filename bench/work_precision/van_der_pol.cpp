#include "problems/relaxation.hpp"

#include "small.hpp"

work_precision::Table work_precision::van_der_pol() {
  using P = problems::Relaxation;
  return small_stiff<P>("van_der_pol", "Van der Pol, epsilon = 1e-6, to t = 2", P::end, P::exact(), 1.0, 2.3, 6);
}

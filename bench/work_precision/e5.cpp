#include "problems/e5.hpp"

#include "small.hpp"

work_precision::Table work_precision::e5() {
  using P = problems::E5;
  return small_stiff<P>("e5", "E5 to t = 1e5", 1e5, P::at_1e5(), 1e-12, 0, 6);
}
/// From y2' = y3' + y4' on, rounding decides: no code gets beyond 1e-6 or so.
work_precision::Table work_precision::e5_late() {
  using P = problems::E5;
  return small_stiff<P>("e5_late", "E5 to t = 1e11", 1e11, P::at_1e11(), 1e-22, 0, 12);
}

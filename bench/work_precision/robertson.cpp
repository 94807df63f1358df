#include "problems/robertson.hpp"

#include "small.hpp"

work_precision::Table work_precision::robertson() {
  using P = problems::Robertson;
  return small_stiff<P>("robertson", "Robertson's three reactions to t = 40", P::end, P::exact(), 1e-6, 1.5, 7);
}

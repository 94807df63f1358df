#include "problems/robertson.hpp"

#include "small.hpp"

work_precision::Table work_precision::robertson_late() {
  using P = problems::Robertson;
  return small_stiff<P>("robertson_late", "Robertson's three reactions to t = 1e11", P::late, P::exact_late(), 1e-8,
                        1.4, 16);
}

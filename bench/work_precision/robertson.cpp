#include "problems/robertson.hpp"

#include "small.hpp"

work_precision::Table work_precision::robertson() {
  using problems::Robertson;
  return small_stiff("robertson", "Robertson's three reactions to t = 40", Robertson::start(), Robertson{},
                     Robertson::end, Robertson::exact(), 1e-6, 16, 65536);
}

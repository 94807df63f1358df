#include "problems/hires.hpp"

#include "small.hpp"

work_precision::Table work_precision::hires() {
  using problems::Hires;
  return small_stiff("hires", "HIRES, eight reactions", Hires::start(), Hires{}, Hires::end, Hires::exact(), 1e-4, 64,
                     65536);
}

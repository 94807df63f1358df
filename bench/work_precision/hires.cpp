#include "problems/hires.hpp"

#include "small.hpp"

work_precision::Table work_precision::hires() {
  using P = problems::Hires;
  return small_stiff<P>("hires", "HIRES, eight reactions", P::end, P::exact(), 1e-4, 92, 6);
}

#include "problems/oregonator.hpp"

#include "small.hpp"

work_precision::Table work_precision::oregonator() {
  using P = problems::Oregonator;
  return small_stiff<P>("oregonator", "Oregonator to t = 360", P::end, P::exact(), 1e-6, 6.9, 6);
}

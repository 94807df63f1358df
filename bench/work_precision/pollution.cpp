#include "problems/pollution.hpp"

#include "small.hpp"

work_precision::Table work_precision::pollution() {
  using P = problems::Pollution;
  return small_stiff<P>("pollution", "Pollution, 20 species", P::end, P::exact(), 1e-4, 0, 7);
}

#include "problems/detest/single.hpp"

#include "rows.hpp"

std::vector<work_precision::Table> work_precision::smooth::single_equations() {
  using namespace problems::detest;
  return tables_of(A1{}, A2{}, A3{}, A4{}, A5{});
}

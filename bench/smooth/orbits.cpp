#include "problems/detest/orbits.hpp"

#include "rows.hpp"

std::vector<work_precision::Table> work_precision::smooth::orbits() {
  using namespace problems::detest;
  return tables_of(D1{}, D2{}, D3{}, D4{}, D5{});
}

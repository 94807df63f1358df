#include "problems/detest/small.hpp"

#include "rows.hpp"

std::vector<work_precision::Table> work_precision::smooth::small_systems() {
  using namespace problems::detest;
  return tables_of(B1{}, B2{}, B3{}, B4{}, B5{});
}

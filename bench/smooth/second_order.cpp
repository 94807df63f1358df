#include "problems/detest/second_order.hpp"

#include "rows.hpp"

std::vector<work_precision::Table> work_precision::smooth::second_order() {
  using namespace problems::detest;
  return tables_of(E1{}, E2{}, E3{}, E4{}, E5{});
}

#include "problems/detest/moderate.hpp"

#include "rows.hpp"

std::vector<work_precision::Table> work_precision::smooth::moderate_systems() {
  using namespace problems::detest;
  return tables_of(C1{}, C2{}, C3{}, C4{}, C5{});
}

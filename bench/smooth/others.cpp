#include "problems/smooth.hpp"

#include "rows.hpp"

std::vector<work_precision::Table> work_precision::smooth::others() {
  using namespace problems::smooth;
  return tables_of(LotkaVolterra{}, RigidBody{}, Brusselator{}, Arenstorf{}, Lorenz{}, Satellite{});
}

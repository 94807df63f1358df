/// @file
/// Stiff problems of many unknowns, banded or sparse.
#pragma once

#include "first_order.hpp"
#include "phistep_rows.hpp"
#include "truth.hpp"

namespace work_precision {

/// phistep's schemes for large stiff problems.
void add_large(auto& rows, double tightest) {
  rows.controlled("TR-BDF2", phistep::tr_bdf2, tightest);
  rows.controlled("trapezoidal", phistep::trapezoidal, tightest);
}

}  // namespace work_precision

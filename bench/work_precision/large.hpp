/// @file
/// Stiff problems of many unknowns, banded or sparse.
#pragma once

#include <phistep/schemes/radau/radau.hpp>
#include <phistep/schemes/rosenbrock.hpp>

#include "accuracy/truth/extrapolation.hpp"
#include "first_order.hpp"
#include "phistep_rows.hpp"

namespace work_precision {

/// phistep's schemes for large stiff problems.
void add_large(auto& rows, double tightest) {
  rows.controlled("TR-BDF2", phistep::tr_bdf2, tightest);
  rows.controlled("trapezoidal", phistep::trapezoidal, tightest);
  rows.controlled("Rodas4", phistep::rodas4);
  rows.controlled("Rodas4P2", phistep::rodas4p2);
  rows.controlled("Rodas5P", phistep::rodas5p);
  rows.controlled("Radau", phistep::radau);
  rows.estimate_kappa(phistep::radau, 1e-8);
}

}  // namespace work_precision

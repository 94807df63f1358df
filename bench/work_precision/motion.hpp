/// @file
/// Conservative motions of a few bodies.
#pragma once

#include <utility>
#include <vector>

#include "accuracy/truth/extrapolation.hpp"
#include "first_order.hpp"
#include "phistep_rows.hpp"

namespace work_precision {

/// phistep's schemes for conservative motions.
void add_motion(auto& rows) {
  rows.controlled("velocity Verlet", phistep::velocity_verlet, -7);
  rows.controlled("RKN 8(6)", phistep::rkn86);
  rows.controlled("RKN 12(10)", phistep::rkn1210);
}

template <class Force, class Vector>
[[nodiscard]] Table small_motion(const char* name, const char* title, const phistep::Motion<Vector>& start, double end,
                                 const phistep::Motion<Vector>& exact, double a, double kappa, double decades) {
  using State = phistep::Motion<Vector>;
  constexpr int n = Vector::RowsAtCompileTime;
  Table table{name,  title,  stacked(exact), system_of(Shape::explicit_, a, end, FirstOrder<State, Force>{start, {}}),
              kappa, decades};
  using Rows = truth::MotionRows<Force, n>;
  truth::tell(table, truth::Path<Rows>{{{end, Rows{}}}, a, 1e-17L}, stacked(start).template cast<truth::Real>());
  PhistepRows rows{table, start, [](const auto& y, auto scheme, std::size_t) {
                     return phistep::PhiStepper{y, Force{}, scheme};
                   }};
  add_motion(rows);
  return table;
}

}  // namespace work_precision

/// @file
/// Conservative motions of a few bodies.
#pragma once

#include <utility>
#include <vector>

#include "first_order.hpp"
#include "phistep_rows.hpp"
#include "truth.hpp"

namespace work_precision {

/// phistep's schemes for conservative motions.
void add_motion(auto& rows) { rows.controlled("velocity Verlet", phistep::velocity_verlet, -9); }

template <class Force, class Vector>
[[nodiscard]] Table small_motion(const char* name, const char* title, const phistep::Motion<Vector>& start, double end,
                                 const phistep::Motion<Vector>& exact, double a, double kappa, double decades) {
  using State = phistep::Motion<Vector>;
  constexpr int n = Vector::RowsAtCompileTime;
  Table table{name,  title,  stacked(exact), system_of(Shape::explicit_, a, end, FirstOrder<State, Force>{start, {}}),
              kappa, decades};
  table.truth = [start, a, end](const std::vector<double>& times) {
    using Rows = truth::MotionRows<Force, n>;
    return truth::film<Rows>({{end, Rows{}}}, stacked(start).template cast<truth::Real>(), a, 1e-18L, times);
  };
  PhistepRows rows{table, start, [](const auto& y, auto scheme, std::size_t) {
                     return phistep::PhiStepper{y, Force{}, scheme};
                   }};
  add_motion(rows);
  return table;
}

}  // namespace work_precision

/// @file
/// A few stiff unknowns: dense LU for everybody, fixed-size states for phistep.
#pragma once

#include <phistep/schemes/radau/radau.hpp>
#include <phistep/schemes/rosenbrock.hpp>

#include <type_traits>
#include <utility>
#include <vector>

#include "accuracy/truth/extrapolation.hpp"
#include "first_order.hpp"
#include "phistep_rows.hpp"

namespace work_precision {

/// phistep's schemes for stiff problems of a few unknowns.
void add_stiff(auto& rows) {
  rows.controlled("TR-BDF2", phistep::tr_bdf2, -7);
  rows.controlled("Rodas4", phistep::rodas4);
  rows.controlled("Rodas4P2", phistep::rodas4p2);
  rows.controlled("Rodas5P", phistep::rodas5p);
  rows.controlled("Radau", phistep::radau);
}

/// The problem, with the pattern of its Jacobian for the library to use where it pays.
template <class Problem>
struct WithPattern : Problem {
  static constexpr auto jacobian_pattern = phistep::pattern_of<Problem::State::RowsAtCompileTime>(
      [](const auto& y, auto&& put) { Problem::entries(y, put); });
};

template <class Problem>
[[nodiscard]] Table small_stiff(const char* name, const char* title, double end, const typename Problem::State& exact,
                                double a, double kappa, double decades) {
  using State = typename Problem::State;
  const State start = Problem::start();
  Table table{name,  title,  exact, system_of(Shape::dense, a, end, FirstOrder<State, Problem>{start, {}}),
              kappa, decades};
  using Rows = truth::StiffRows<truth::Dense<Problem>>;
  truth::tell(table, truth::Path<Rows>{{{end, Rows{}}}, a, 1e-14L}, start.template cast<truth::Real>());
  PhistepRows rows{table, start, [](const auto& y, auto scheme, std::size_t) {
                     // Radau factorizes complex matrices, without the pattern.
                     if constexpr (std::is_same_v<decltype(scheme), phistep::Radau>)
                       return phistep::PhiStepper{y, Problem{}, scheme};
                     else return phistep::PhiStepper{y, WithPattern<Problem>{}, scheme};
                   }};
  add_stiff(rows);
  rows.estimate_kappa(phistep::rodas5p);
  return table;
}

}  // namespace work_precision

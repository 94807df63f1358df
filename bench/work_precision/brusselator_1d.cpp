#include "problems/brusselator_1d.hpp"

#include "first_order.hpp"
#include "phistep_rows.hpp"
#include "sundials_rows.hpp"

work_precision::Table work_precision::brusselator_1d() {
  using problems::Brusselator1D;
  const Brusselator1D force;
  const auto start = Brusselator1D::start();
  constexpr double end = Brusselator1D::end;
  Table table{"brusselator_1d", "Brusselator with diffusion, 500 points in one dimension", Brusselator1D::exact(), 1.0};
  table.samples = Brusselator1D::samples();
  PhistepRows rows{table, start, end, [=](const auto& y, auto scheme) {
                     return phistep::PhiStepper{y, force, scheme};
                   }};
  rows.fixed("backward Euler", phistep::backward_euler, 32, 4096);
  rows.fixed("trapezoidal", phistep::trapezoidal, 32, 4096);
  rows.fixed("TR-BDF2", phistep::tr_bdf2, 16, 2048);
  rows.controlled("TR-BDF2", phistep::tr_bdf2, -5);
  rows.controlled("trapezoidal", phistep::trapezoidal, -5);
#ifdef BENCH_HAS_SUNDIALS_SOLVERS
  const FirstOrder<Brusselator1D::State, Brusselator1D> problem{start, force};
  sundials::add_implicit(table, problem, end, "band", sundials::Band{2, 2});
#endif
  return table;
}

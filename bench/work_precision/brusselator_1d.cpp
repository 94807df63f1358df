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
  const auto fixed = [&](const char* name, auto scheme, int from, int to) {
    table.methods.push_back(fixed_steps(std::string(name) + ", fixed dt", start, end, steps(end, from, to),
                                        [=](const auto& y) { return phistep::PhiStepper{y, force, scheme}; }));
  };
  fixed("backward Euler", phistep::backward_euler, 32, 4096);
  fixed("trapezoidal", phistep::trapezoidal, 32, 4096);
  fixed("TR-BDF2", phistep::tr_bdf2, 16, 2048);
#ifdef BENCH_HAS_SUNDIALS_SOLVERS
  const FirstOrder<Brusselator1D::State, Brusselator1D> problem{start, force};
  sundials::add_implicit(table, problem, end, "band", sundials::Band{2, 2});
#endif
  return table;
}

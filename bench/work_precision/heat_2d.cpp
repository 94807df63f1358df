#include <phistep/sparse.hpp>

#include "problems/heat_2d.hpp"

#include "first_order.hpp"
#include "phistep_rows.hpp"
#include "sundials_rows.hpp"

work_precision::Table work_precision::heat_2d() {
  using problems::Heat2D;
  const Heat2D force;
  const auto start = Heat2D::exact(0);
  constexpr double end = Heat2D::end;
  Table table{"heat_2d", "Heat on 64 x 64 points in two dimensions", Heat2D::exact(end), 0.1};
  const auto fixed = [&](const char* name, auto scheme, int from, int to) {
    table.methods.push_back(fixed_steps(std::string(name) + ", fixed dt", start, end, steps(end, from, to),
                                        [=](const auto& y) { return phistep::PhiStepper{y, force, scheme}; }));
  };
  fixed("backward Euler", phistep::backward_euler, 16, 2048);
  fixed("trapezoidal", phistep::trapezoidal, 8, 512);
  fixed("TR-BDF2", phistep::tr_bdf2, 8, 512);
#ifdef BENCH_HAS_SUNDIALS_SOLVERS
  const FirstOrder<Heat2D::State, Heat2D> problem{start, force};
  sundials::add_implicit(table, problem, end, "KLU", sundials::Klu{problem}, -5);
  sundials::add_implicit(table, problem, end, "GMRES", sundials::Gmres{}, -5, {3});
#endif
  return table;
}

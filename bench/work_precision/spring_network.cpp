#include <phistep/sparse.hpp>

#include "problems/drum.hpp"

#include "first_order.hpp"
#include "phistep_rows.hpp"
#include "sundials_rows.hpp"

work_precision::Table work_precision::spring_network() {
  using problems::Drum;
  const auto force = Drum::force();
  const auto start = Drum::start();
  constexpr double end = Drum::end;
  Table table{"spring_network", "A stretched net of 20 x 20 masses on stiff, damped springs", Drum::exact(), 1.0};
  table.samples = Drum::samples();
  const auto fixed = [&](const char* name, auto scheme, int from, int to) {
    table.methods.push_back(fixed_steps(std::string(name) + ", fixed dt", start, end, steps(end, from, to),
                                        [=](const auto& y) { return phistep::PhiStepper{y, force, scheme, phistep::mass(Drum::masses())}; }));
  };
  fixed("backward Euler", phistep::backward_euler, 128, 1024);
  fixed("trapezoidal", phistep::trapezoidal, 64, 1024);
  fixed("TR-BDF2", phistep::tr_bdf2, 64, 512);
#ifdef BENCH_HAS_SUNDIALS_SOLVERS
  const FirstOrder<Drum::State, decltype(Drum::force())> problem{start, force, Drum::masses()};
  sundials::add_implicit(table, problem, end, "KLU", sundials::Klu{problem}, -5);
  sundials::add_implicit(table, problem, end, "GMRES", sundials::Gmres{}, -4, {3});
#endif
  return table;
}

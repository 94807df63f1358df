/// @file
/// CVODE's rows: variable order and step; BDF with Newton, or Adams-Moulton with fixed-point iteration.
#ifdef BENCH_HAS_SUNDIALS_SOLVERS
#include <cvode/cvode.h>
#include <sunnonlinsol/sunnonlinsol_fixedpoint.h>

#include "sundials.hpp"

namespace work_precision {
namespace {
using namespace sundials;

Answer run(const System& system, const Places* places, double rtol, Film* film) {
  Handles h(system);
  const Memory<CVodeFree> memory{CVodeCreate(places ? CV_BDF : CV_ADAMS, h.context.get())};
  void* const cv = memory.get();
  Data data{system, places, system.legs.front().self.get()};
  data.values.resize(system.pattern.size());
  CVodeInit(cv, rate, 0, h.y.get());
#if SUNDIALS_VERSION_MAJOR < 7
  CVodeSetErrHandlerFn(cv, ignore, nullptr);
#endif
  CVodeSStolerances(cv, rtol, system.a * rtol);
  CVodeSetUserData(cv, &data);
  CVodeSetMaxNumSteps(cv, system.most_steps());
  Handle<std::remove_pointer_t<SUNNonlinearSolver>, SUNNonlinSolFree> iteration;
  if (places) {
    h.make_solver(system, *places);
    CVodeSetLinearSolver(cv, h.solver.get(), h.J.get());
    if (h.J) CVodeSetJacFn(cv, jacobian);
  } else {
    iteration.reset(SUNNonlinSol_FixedPoint(h.y.get(), 0, h.context.get()));
    CVodeSetNonlinearSolver(cv, iteration.get());
  }
  Answer answer;
  const auto count = [&] {
    long steps = 0, jacobians = 0, factorizations = 0;
    CVodeGetNumSteps(cv, &steps);
    if (h.J) {
      CVodeGetNumLinSolvSetups(cv, &factorizations);
      CVodeGetNumJacEvals(cv, &jacobians);
    }
    answer.steps += steps, answer.jacobians += jacobians, answer.factorizations += factorizations;
  };
  const auto restart = [&](double t) {
    count();
    CVodeReInit(cv, t, h.y.get());
  };
  const auto advance = [&](double to, double stop) {
    sunrealtype t = 0;
    CVodeSetStopTime(cv, stop);
    return CVode(cv, to, h.y.get(), &t, CV_NORMAL) >= 0 && t == to;
  };
  if (!go(data, h.y.get(), film, restart, advance)) return {};
  count();
  answer.y = view(h.y.get());
  answer.force_calls = data.calls;
  return answer;
}

}  // namespace

void cvode(Table& table) {
  for (const Linear linear : linear_solvers_for(table.system))
    table.add("CVODE", std::string("BDF, ") + name(linear), tolerances(),
              [system = table.system, places = Places(table.system, linear)](double rtol, Film* film) {
                return run(system, &places, rtol, film);
              });
  if (table.system.shape == Shape::explicit_)
    table.add("CVODE", "Adams", tolerances(),
              [system = table.system](double rtol, Film* film) { return run(system, nullptr, rtol, film); });
}

}  // namespace work_precision
#endif

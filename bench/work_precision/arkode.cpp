/// @file
/// ARKODE's rows: Runge-Kutta methods of a fixed order, diagonally implicit or explicit.
#ifdef BENCH_HAS_SUNDIALS_SOLVERS
#include <arkode/arkode_arkstep.h>
#include <arkode/arkode_erkstep.h>

#include "sundials.hpp"

#if SUNDIALS_VERSION_MAJOR > 7 || (SUNDIALS_VERSION_MAJOR == 7 && SUNDIALS_VERSION_MINOR >= 1)
#define BENCH_ARK(function) ARKode##function
#define BENCH_ERK(function) ARKode##function
#else
#define BENCH_ARK(function) ARKStep##function
#define BENCH_ERK(function) ERKStep##function
#endif

namespace work_precision {
namespace {
using namespace sundials;

/// With the settings that make it work: Newton's error kept below the step's, slopes recovered from the stage equation,
/// stages predicted by extrapolation.
Answer implicit(const System& system, const Places& places, int order, double rtol, Film* film) {
  Handles h(system);
  const Memory<BENCH_ARK(Free)> memory{ARKStepCreate(nullptr, rate, 0, h.y.get(), h.context.get())};
  void* const ark = memory.get();
  Data data{system, &places, system.legs.front().self.get()};
  data.values.resize(system.pattern.size());
#if SUNDIALS_VERSION_MAJOR < 7
  ARKStepSetErrHandlerFn(ark, ignore, nullptr);
#endif
  BENCH_ARK(SStolerances)(ark, rtol, system.a * rtol);
  BENCH_ARK(SetOrder)(ark, order);
  BENCH_ARK(SetMaxNumSteps)(ark, system.most_steps());
  BENCH_ARK(SetUserData)(ark, &data);
  h.make_solver(system, places);
  BENCH_ARK(SetLinearSolver)(ark, h.solver.get(), h.J.get());
  if (h.J) BENCH_ARK(SetJacFn)(ark, jacobian);
  BENCH_ARK(SetNonlinConvCoef)(ark, 1e-2);
  BENCH_ARK(SetMaxNonlinIters)(ark, 8);
  BENCH_ARK(SetDeduceImplicitRhs)(ark, 1);
  BENCH_ARK(SetPredictorMethod)(ark, 1);
  Answer answer;
  const auto count = [&] {
    long steps = 0, jacobians = 0, factorizations = 0;
    BENCH_ARK(GetNumSteps)(ark, &steps);
    if (h.J) {
      BENCH_ARK(GetNumJacEvals)(ark, &jacobians);
      BENCH_ARK(GetNumLinSolvSetups)(ark, &factorizations);
    }
    answer.steps += steps, answer.jacobians += jacobians, answer.factorizations += factorizations;
  };
  const auto restart = [&](double t) {
    count();
    ARKStepReInit(ark, nullptr, rate, t, h.y.get());
  };
  const auto advance = [&](double to, double stop) {
    sunrealtype t = 0;
    BENCH_ARK(SetStopTime)(ark, stop);
    return BENCH_ARK(Evolve)(ark, to, h.y.get(), &t, ARK_NORMAL) >= 0 && t == to;
  };
  if (!go(data, h.y.get(), film, restart, advance)) return {};
  count();
  answer.y = view(h.y.get());
  answer.force_calls = data.calls;
  return answer;
}

Answer explicit_(const System& system, int order, double rtol, Film* film) {
  Handles h(system);
  const Memory<BENCH_ERK(Free)> memory{ERKStepCreate(rate, 0, h.y.get(), h.context.get())};
  void* const erk = memory.get();
  Data data{system, nullptr, system.legs.front().self.get()};
#if SUNDIALS_VERSION_MAJOR < 7
  ERKStepSetErrHandlerFn(erk, ignore, nullptr);
#endif
  BENCH_ERK(SStolerances)(erk, rtol, system.a * rtol);
  BENCH_ERK(SetOrder)(erk, order);
  BENCH_ERK(SetMaxNumSteps)(erk, system.most_steps());
  BENCH_ERK(SetUserData)(erk, &data);
  const auto restart = [&](double t) { ERKStepReInit(erk, rate, t, h.y.get()); };  // the counts begin again, too
  const auto advance = [&](double to, double stop) {
    sunrealtype t = 0;
    BENCH_ERK(SetStopTime)(erk, stop);
    return BENCH_ERK(Evolve)(erk, to, h.y.get(), &t, ARK_NORMAL) >= 0 && t == to;
  };
  if (!go(data, h.y.get(), film, restart, advance)) return {};
  long steps = 0;
  BENCH_ERK(GetNumSteps)(erk, &steps);
  return {view(h.y.get()), steps, data.calls};
}

}  // namespace

void arkode(Table& table) {
  for (const Linear linear : linear_solvers_for(table.system))
    for (const int order : {3, 4, 5})
      table.add("ARKODE", "DIRK" + std::to_string(order) + ", " + name(linear), tolerances(-1, -10),
                [system = table.system, places = Places(table.system, linear), order](double rtol, Film* film) {
                  return implicit(system, places, order, rtol, film);
                });
  if (table.system.shape == Shape::explicit_)
    for (const int order : {4, 5, 8})
      table.add(
          "ARKODE", "ERK" + std::to_string(order), tolerances(),
          [system = table.system, order](double rtol, Film* film) { return explicit_(system, order, rtol, film); });
}

}  // namespace work_precision

#undef BENCH_ARK
#undef BENCH_ERK
#endif

#pragma once

// A solution by SUNDIALS' ARKODE: Runge-Kutta methods of fixed order and variable step, diagonally implicit with dense
// Newton, or explicit.

#include <arkode/arkode_arkstep.h>
#if SUNDIALS_VERSION_MAJOR > 7 || (SUNDIALS_VERSION_MAJOR == 7 && SUNDIALS_VERSION_MINOR >= 1)
#include <arkode/arkode.h>
#define REFERENCE_ARKODE(function) ARKode##function
#else
#define REFERENCE_ARKODE(function) ARKStep##function
#endif

#include <stdexcept>
#include <string>

#include "accuracy/reference/sundials.hpp"

namespace reference {

enum class RungeKutta { diagonally_implicit, explicit_ };

/// How ARKODE is run.
struct ArkodeOptions {
  RungeKutta method = RungeKutta::diagonally_implicit;
  int order = 4;  ///< implicit 2 … 5, explicit 2 … 8
  /// ARKODE's own settings as they come. They leave Newton's error as large as the step's, and take the stage's slope from
  /// a call of f: on stiff problems (Robertson, OREGO) the error estimate then sees little else and the step collapses. Otherwise Newton
  /// goes on to 1e-3 of the tolerance, the slope is recovered from the stage equation, and stages are predicted by
  /// extrapolation.
  bool as_it_comes = false;
  JacobianFunction jacobian{};  ///< left out: ARKODE's own differences
  long most_steps = 500000;
};

/// y' = f(t, y), y(0) = y0, to t1 at rtol and the given atol per component.
/// @throws std::runtime_error where any call of ARKODE's reports a failure
[[nodiscard]] inline Run arkode_run(const RightHandSide& f, const Vector& y0, double t1, double rtol,
                                    const Vector& atol, const ArkodeOptions& options = {}) {
  using namespace detail;
  const Context context = make_context();
  const auto n = static_cast<sunindextype>(y0.size());
  const State y = check(State{N_VNew_Serial(n, context.get())}, "N_VNew_Serial");
  const State tolerance = check(State{N_VNew_Serial(n, context.get())}, "N_VNew_Serial");
  view(y.get()) = y0;
  view(tolerance.get()) = atol;

  Problem problem{f, options.jacobian};
  const bool implicit = options.method == RungeKutta::diagonally_implicit;
  const auto memory =
      check(Memory<REFERENCE_ARKODE(Free)>{ARKStepCreate(implicit ? nullptr : evaluate, implicit ? evaluate : nullptr,
                                                         0, y.get(), context.get())},
            "ARKStepCreate");
  void* const ark = memory.get();
#if SUNDIALS_VERSION_MAJOR < 7
  ARKStepSetErrHandlerFn(ark, ignore, nullptr);
#endif
  check(REFERENCE_ARKODE(SVtolerances)(ark, rtol, tolerance.get()), "SVtolerances");
  check(REFERENCE_ARKODE(SetUserData)(ark, &problem), "SetUserData");
  check(REFERENCE_ARKODE(SetOrder)(ark, options.order), "SetOrder");
  check(REFERENCE_ARKODE(SetMaxNumSteps)(ark, options.most_steps), "SetMaxNumSteps");
  check(REFERENCE_ARKODE(SetStopTime)(ark, t1), "SetStopTime");  // no interpolation at the end
  Matrix matrix;
  LinearSolver solver;
  if (implicit) {
    matrix = check(Matrix{SUNDenseMatrix(n, n, context.get())}, "SUNDenseMatrix");
    solver = check(LinearSolver{SUNLinSol_Dense(y.get(), matrix.get(), context.get())}, "SUNLinSol_Dense");
    check(REFERENCE_ARKODE(SetLinearSolver)(ark, solver.get(), matrix.get()), "SetLinearSolver");
    if (options.jacobian) check(REFERENCE_ARKODE(SetJacFn)(ark, evaluate_jacobian), "SetJacFn");
    if (!options.as_it_comes) {
      check(REFERENCE_ARKODE(SetNonlinConvCoef)(ark, 1e-3), "SetNonlinConvCoef");
      check(REFERENCE_ARKODE(SetMaxNonlinIters)(ark, 8), "SetMaxNonlinIters");
      check(REFERENCE_ARKODE(SetDeduceImplicitRhs)(ark, 1), "SetDeduceImplicitRhs");
      check(REFERENCE_ARKODE(SetPredictorMethod)(ark, 1), "SetPredictorMethod");
    }
  }

  Run run{.times = {0}, .y = {}};
  sunrealtype t = 0;
  const int flag = REFERENCE_ARKODE(Evolve)(ark, t1, y.get(), &t, ARK_NORMAL);
  if (problem.thrown) std::rethrow_exception(problem.thrown);
  check(flag, "Evolve");
  if (t != t1) throw std::runtime_error("ARKODE stopped at t = " + std::to_string(t));
  run.times.push_back(t);
  run.y = view(y.get());
  run.force_calls = problem.calls;
  check(REFERENCE_ARKODE(GetNumSteps)(ark, &run.steps), "GetNumSteps");
  if (implicit) {
    check(REFERENCE_ARKODE(GetNumJacEvals)(ark, &run.jacobians), "GetNumJacEvals");
    check(REFERENCE_ARKODE(GetNumLinSolvSetups)(ark, &run.factorizations), "GetNumLinSolvSetups");
    check(REFERENCE_ARKODE(GetNumNonlinSolvIters)(ark, &run.iterations), "GetNumNonlinSolvIters");
  }
  return run;
}

}  // namespace reference

#undef REFERENCE_ARKODE

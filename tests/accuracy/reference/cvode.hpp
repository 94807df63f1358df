#pragma once

// An independent solution by SUNDIALS' CVODE: BDF of variable order and step, dense Newton, at the tightest tolerance
// that it keeps.

#include <cvode/cvode.h>
#include <sunnonlinsol/sunnonlinsol_fixedpoint.h>

#include <phistep/phistep.hpp>

#include <string>
#include <type_traits>
#include <vector>

#include "accuracy/reference/sundials.hpp"

namespace reference {

/// How CVODE is run.
struct CvodeOptions {
  bool every_step = false;      ///< tell where each step ended
  bool adams = false;           ///< Adams-Moulton with fixed-point iteration, instead of BDF with dense Newton
  JacobianFunction jacobian{};  ///< left out: CVODE's own differences
  long most_steps = 5000000;
};

/// y' = f(t, y), y(0) = y0, to t1, at rtol and the given atol per component.
/// @throws std::runtime_error where any call of CVODE's reports a failure
[[nodiscard]] inline Run cvode_run(const RightHandSide& f, const Vector& y0, double t1, double rtol, const Vector& atol,
                                   const CvodeOptions& options = {}) {
  using namespace detail;
  const Context context = make_context();
  const auto n = static_cast<sunindextype>(y0.size());
  const State y = check(State{N_VNew_Serial(n, context.get())}, "N_VNew_Serial");
  const State tolerance = check(State{N_VNew_Serial(n, context.get())}, "N_VNew_Serial");
  view(y.get()) = y0;
  view(tolerance.get()) = atol;

  Problem problem{f, options.jacobian};
  const auto memory =
      check(Memory<CVodeFree>{CVodeCreate(options.adams ? CV_ADAMS : CV_BDF, context.get())}, "CVodeCreate");
  check(CVodeInit(memory.get(), evaluate, 0, y.get()), "CVodeInit");
#if SUNDIALS_VERSION_MAJOR < 7
  CVodeSetErrHandlerFn(memory.get(), ignore, nullptr);
#endif
  check(CVodeSVtolerances(memory.get(), rtol, tolerance.get()), "CVodeSVtolerances");
  check(CVodeSetUserData(memory.get(), &problem), "CVodeSetUserData");
  check(CVodeSetMaxNumSteps(memory.get(), options.most_steps), "CVodeSetMaxNumSteps");
  check(CVodeSetStopTime(memory.get(), t1), "CVodeSetStopTime");  // no interpolation at the end
  Matrix matrix;
  LinearSolver solver;
  Handle<std::remove_pointer_t<SUNNonlinearSolver>, SUNNonlinSolFree> iteration;
  if (options.adams) {
    iteration.reset(SUNNonlinSol_FixedPoint(y.get(), 0, context.get()));
    check(CVodeSetNonlinearSolver(memory.get(), iteration.get()), "CVodeSetNonlinearSolver");
  } else {
    matrix = check(Matrix{SUNDenseMatrix(n, n, context.get())}, "SUNDenseMatrix");
    solver = check(LinearSolver{SUNLinSol_Dense(y.get(), matrix.get(), context.get())}, "SUNLinSol_Dense");
    check(CVodeSetLinearSolver(memory.get(), solver.get(), matrix.get()), "CVodeSetLinearSolver");
    if (options.jacobian) check(CVodeSetJacFn(memory.get(), evaluate_jacobian), "CVodeSetJacFn");
  }

  Run run{.times = {0}, .y = {}};
  for (sunrealtype t = 0; t != t1;) {
    const int flag = CVode(memory.get(), t1, y.get(), &t, options.every_step ? CV_ONE_STEP : CV_NORMAL);
    if (problem.thrown) std::rethrow_exception(problem.thrown);
    check(flag, "CVode");
    run.times.push_back(t);
    if (!options.every_step && t != t1) throw std::runtime_error("CVode stopped at t = " + std::to_string(t));
  }
  run.y = view(y.get());
  run.force_calls = problem.calls;
  check(CVodeGetNumSteps(memory.get(), &run.steps), "CVodeGetNumSteps");
  if (!options.adams) {
    check(CVodeGetNumJacEvals(memory.get(), &run.jacobians), "CVodeGetNumJacEvals");
    check(CVodeGetNumLinSolvSetups(memory.get(), &run.factorizations), "CVodeGetNumLinSolvSetups");
  }
  check(CVodeGetNumNonlinSolvIters(memory.get(), &run.iterations), "CVodeGetNumNonlinSolvIters");
  return run;
}

/// y(t1) at rtol = 1e-12.
[[nodiscard]] inline Vector cvode(const RightHandSide& f, const Vector& y0, double t1, const Vector& atol) {
  return cvode_run(f, y0, t1, 1e-12, atol).y;
}

/// The same for m r'' = force(state), a state of r and v.
template <class V, class Force>
[[nodiscard]] phistep::Motion<V> cvode(const phistep::Motion<V>& start, Force&& force, const Vector& mass, double t1,
                                       double atol) {
  const auto n = start.r.size();
  phistep::Motion<V> y = start;
  const RightHandSide f = [&](double, const Vector& x) {
    y.r = x.head(n);
    y.v = x.tail(n);
    Vector rate(2 * n);
    rate << y.v, force(y).cwiseQuotient(mass);
    return rate;
  };
  Vector y0(2 * n);
  y0 << start.r, start.v;
  const Vector reached = cvode(f, y0, t1, Vector::Constant(2 * n, atol));
  y.r = reached.head(n);
  y.v = reached.tail(n);
  return y;
}

}  // namespace reference

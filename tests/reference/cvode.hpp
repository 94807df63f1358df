#pragma once

// An independent solution by SUNDIALS' CVODE: BDF of variable order and step, dense Newton, at the tightest tolerance
// that it keeps. For SUNDIALS 6 and 7.

#include <cvode/cvode.h>
#include <nvector/nvector_serial.h>
#include <sundials/sundials_config.h>
#include <sunlinsol/sunlinsol_dense.h>
#include <sunmatrix/sunmatrix_dense.h>
#include <Eigen/Core>

#include <phistep/phistep.hpp>

#include <exception>
#include <functional>
#include <memory>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <vector>

namespace reference {

using Vector = Eigen::VectorXd;
using RightHandSide = std::function<Vector(double, const Vector&)>;

namespace detail {

/// Owns a SUNDIALS object. Release: a function that takes the handle or its address.
template <auto release>
struct Release {
  template <class Pointer>
  void operator()(Pointer p) const {
    if constexpr (std::is_invocable_v<decltype(release), Pointer>) release(p);
    else release(&p);
  }
};
template <class Object, auto release>
using Handle = std::unique_ptr<Object, Release<release>>;

using Context = Handle<std::remove_pointer_t<SUNContext>, SUNContext_Free>;
using State = Handle<std::remove_pointer_t<N_Vector>, N_VDestroy>;
using Matrix = Handle<std::remove_pointer_t<SUNMatrix>, SUNMatDestroy>;
using LinearSolver = Handle<std::remove_pointer_t<SUNLinearSolver>, SUNLinSolFree>;

/// CVODE's memory is a void*, of which unique_ptr can't be the owner by type alone.
struct ReleaseMemory {
  void operator()(void* memory) const { CVodeFree(&memory); }
};
using Memory = std::unique_ptr<void, ReleaseMemory>;

inline Context make_context() {
  SUNContext context = nullptr;
#if SUNDIALS_VERSION_MAJOR >= 7
  const int flag = SUNContext_Create(SUN_COMM_NULL, &context);
#else
  const int flag = SUNContext_Create(nullptr, &context);
#endif
  if (flag != 0) throw std::runtime_error("SUNContext_Create failed");
  return Context{context};
}

inline void check(int flag, const char* call) {
  if (flag < 0) throw std::runtime_error(std::string(call) + " failed with flag " + std::to_string(flag));
}
template <class Owner>
Owner check(Owner owner, const char* call) {
  if (!owner) throw std::runtime_error(std::string(call) + " returned nothing");
  return owner;
}

inline Eigen::Map<Vector> view(N_Vector x) { return {N_VGetArrayPointer(x), N_VGetLength(x)}; }

/// What the callback needs. An exception must not pass through C: it is kept, and thrown again outside.
struct Problem {
  const RightHandSide& f;
  std::exception_ptr thrown;
};
inline int evaluate(sunrealtype t, N_Vector y, N_Vector rate, void* user) {
  auto& problem = *static_cast<Problem*>(user);
  try {
    view(rate) = problem.f(t, view(y));
    return 0;
  } catch (...) {
    problem.thrown = std::current_exception();
    return -1;  // unrecoverable
  }
}

}  // namespace detail

/// A run of CVODE's at a tolerance: where its steps ended, and what they took.
struct Run {
  std::vector<double> times;  ///< t = 0 and the end of every step
  Vector y;
  long jacobians = 0, factorizations = 0, iterations = 0;
};

/// y' = f(t, y), y(0) = y0, to t1 with a dense Newton solver, at rtol and the given atol per component.
/// @throws std::runtime_error where any call of CVODE's reports a failure
[[nodiscard]] inline Run cvode_run(const RightHandSide& f, const Vector& y0, double t1, double rtol, const Vector& atol,
                                   bool every_step) {
  using namespace detail;
  const Context context = make_context();
  const auto n = static_cast<sunindextype>(y0.size());
  const State y = check(State{N_VNew_Serial(n, context.get())}, "N_VNew_Serial");
  const State tolerance = check(State{N_VNew_Serial(n, context.get())}, "N_VNew_Serial");
  view(y.get()) = y0;
  view(tolerance.get()) = atol;

  Problem problem{f, nullptr};
  const Memory memory = check(Memory{CVodeCreate(CV_BDF, context.get())}, "CVodeCreate");
  check(CVodeInit(memory.get(), evaluate, 0, y.get()), "CVodeInit");
  check(CVodeSVtolerances(memory.get(), rtol, tolerance.get()), "CVodeSVtolerances");
  check(CVodeSetUserData(memory.get(), &problem), "CVodeSetUserData");
  check(CVodeSetMaxNumSteps(memory.get(), 5000000), "CVodeSetMaxNumSteps");
  check(CVodeSetStopTime(memory.get(), t1), "CVodeSetStopTime");  // no interpolation at the end
  const Matrix matrix = check(Matrix{SUNDenseMatrix(n, n, context.get())}, "SUNDenseMatrix");
  const LinearSolver solver =
      check(LinearSolver{SUNLinSol_Dense(y.get(), matrix.get(), context.get())}, "SUNLinSol_Dense");
  check(CVodeSetLinearSolver(memory.get(), solver.get(), matrix.get()), "CVodeSetLinearSolver");

  Run run{{0}, {}};
  for (sunrealtype t = 0; t != t1;) {
    const int flag = CVode(memory.get(), t1, y.get(), &t, every_step ? CV_ONE_STEP : CV_NORMAL);
    if (problem.thrown) std::rethrow_exception(problem.thrown);
    check(flag, "CVode");
    run.times.push_back(t);
    if (!every_step && t != t1) throw std::runtime_error("CVode stopped at t = " + std::to_string(t));
  }
  run.y = view(y.get());
  check(CVodeGetNumJacEvals(memory.get(), &run.jacobians), "CVodeGetNumJacEvals");
  check(CVodeGetNumLinSolvSetups(memory.get(), &run.factorizations), "CVodeGetNumLinSolvSetups");
  check(CVodeGetNumNonlinSolvIters(memory.get(), &run.iterations), "CVodeGetNumNonlinSolvIters");
  return run;
}

/// y(t1) at rtol = 1e-12.
[[nodiscard]] inline Vector cvode(const RightHandSide& f, const Vector& y0, double t1, const Vector& atol) {
  return cvode_run(f, y0, t1, 1e-12, atol, false).y;
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

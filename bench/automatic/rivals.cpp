/// @file
/// LSODA and DOP853 as the package numbalsoda has them, CVODE, GSL.
#include "rivals.hpp"

#include "../numbalsoda.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>

#ifdef BENCH_HAS_GSL
#include <gsl/gsl_errno.h>
#include <gsl/gsl_odeiv2.h>
#endif
#ifdef BENCH_HAS_CVODE
#include <cvode/cvode.h>
#include <nvector/nvector_serial.h>
#include <sunlinsol/sunlinsol_dense.h>
#include <sunmatrix/sunmatrix_dense.h>
#include <sunnonlinsol/sunnonlinsol_fixedpoint.h>

#include "accuracy/reference/sundials.hpp"
#endif

namespace automatic {
namespace {

constexpr int most_steps = 200'000;

void rate_for_numbalsoda(double t, double* y, double* out, double* user) {
  const auto& problem = *reinterpret_cast<const BareProblem*>(user);
  problem.rate(problem.self.get(), t, y, out);
}
Eigen::VectorXd run_numbalsoda(bench::Numbalsoda solver, BareProblem problem, double rtol) {
  const auto n = static_cast<int>(problem.start.size());
  Eigen::MatrixXd out(n, 2);
  double times[] = {0, problem.end};
  int success = 0;
  solver(rate_for_numbalsoda, n, problem.start.data(), reinterpret_cast<double*>(&problem), 2, times, out.data(), rtol,
         problem.a * rtol, most_steps, &success);
  return success == 1 ? Eigen::VectorXd(out.col(1)) : Eigen::VectorXd();
}

#ifdef BENCH_HAS_CVODE
using namespace reference::detail;

int rate_for_cvode(sunrealtype t, N_Vector y, N_Vector out, void* user) {
  const auto& problem = *static_cast<const BareProblem*>(user);
  problem.rate(problem.self.get(), t, NV_DATA_S(y), NV_DATA_S(out));
  return 0;
}
Eigen::VectorXd run_cvode(bool is_stiff, BareProblem problem, double rtol) {
  const auto n = static_cast<sunindextype>(problem.start.size());
  const Context context = make_context();
  const State y{N_VNew_Serial(n, context.get())};
  view(y.get()) = problem.start;
  const Memory<CVodeFree> memory{CVodeCreate(is_stiff ? CV_BDF : CV_ADAMS, context.get())};
  void* const cv = memory.get();
  CVodeInit(cv, rate_for_cvode, 0, y.get());
#if SUNDIALS_VERSION_MAJOR < 7
  CVodeSetErrHandlerFn(cv, ignore, nullptr);
#endif
  CVodeSStolerances(cv, rtol, problem.a * rtol);
  CVodeSetUserData(cv, &problem);
  CVodeSetMaxNumSteps(cv, most_steps);
  CVodeSetStopTime(cv, problem.end);
  Matrix J;
  LinearSolver solver;
  Handle<std::remove_pointer_t<SUNNonlinearSolver>, SUNNonlinSolFree> iteration;
  if (is_stiff) {
    J.reset(SUNDenseMatrix(n, n, context.get()));
    solver.reset(SUNLinSol_Dense(y.get(), J.get(), context.get()));
    CVodeSetLinearSolver(cv, solver.get(), J.get());
  } else {
    iteration.reset(SUNNonlinSol_FixedPoint(y.get(), 0, context.get()));
    CVodeSetNonlinearSolver(cv, iteration.get());
  }
  sunrealtype t = 0;
  if (CVode(cv, problem.end, y.get(), &t, CV_NORMAL) < 0 || t != problem.end) return {};
  return view(y.get());
}
#endif

#ifdef BENCH_HAS_GSL
struct Counted {
  const BareProblem& problem;
  long calls = 0;
};
int rate_for_gsl(double t, const double y[], double out[], void* user) {
  auto& [problem, calls] = *static_cast<Counted*>(user);
  if (++calls > most_calls) return GSL_EBADFUNC;
  problem.rate(problem.self.get(), t, y, out);
  return GSL_SUCCESS;
}
int jacobian_for_gsl(double t, const double y[], double* J, double by_time[], void* user) {
  const BareProblem& problem = static_cast<Counted*>(user)->problem;
  jacobian_by_differences(problem, t, y, J, by_time);
  return GSL_SUCCESS;
}
Eigen::VectorXd run_gsl(const gsl_odeiv2_step_type* type, const BareProblem& problem, double rtol) {
  gsl_set_error_handler_off();
  Counted counted{problem};
  gsl_odeiv2_system callbacks{rate_for_gsl, jacobian_for_gsl, static_cast<std::size_t>(problem.start.size()), &counted};
  const std::unique_ptr<gsl_odeiv2_driver, decltype(&gsl_odeiv2_driver_free)> driver{
      gsl_odeiv2_driver_alloc_y_new(&callbacks, type, 1e-6 * std::min(problem.end, 1000.0), problem.a * rtol, rtol),
      gsl_odeiv2_driver_free};
  double t = 0;
  Eigen::VectorXd y = problem.start;
  return gsl_odeiv2_driver_apply(driver.get(), &t, problem.end, y.data()) == GSL_SUCCESS ? y : Eigen::VectorXd();
}
#endif

}  // namespace

void jacobian_by_differences(const BareProblem& problem, double t, const double* y, double* J, double* by_time) {
  const Eigen::Index n = problem.start.size();
  thread_local Eigen::VectorXd at, base, beside;
  at = Eigen::Map<const Eigen::VectorXd>(y, n);
  base.resize(n), beside.resize(n);
  problem.rate(problem.self.get(), t, y, base.data());
  for (Eigen::Index j = 0; j < n; ++j) {
    const double was = at[j];
    at[j] += 1.5e-8 * std::max(std::abs(was), problem.a);
    problem.rate(problem.self.get(), t, at.data(), beside.data());
    const double apart = at[j] - was;
    for (Eigen::Index i = 0; i < n; ++i) J[i * n + j] = (beside[i] - base[i]) / apart;
    at[j] = was;
  }
  const double later = t + 1.5e-8 * std::max(std::abs(t), 1e-2 * std::min(problem.end, 1000.0));
  problem.rate(problem.self.get(), later, y, beside.data());
  for (Eigen::Index i = 0; i < n; ++i) by_time[i] = (beside[i] - base[i]) / (later - t);
}

Rivals rivals_of(const BareProblem& problem) {
  Rivals all;
  static const bench::Numbalsoda lsoda = bench::load_numbalsoda("lsoda"), dop853 = bench::load_numbalsoda("dop853");
  if (lsoda) all.emplace_back("LSODA", [problem](double rtol) { return run_numbalsoda(lsoda, problem, rtol); });
  if (dop853) all.emplace_back("DOP853", [problem](double rtol) { return run_numbalsoda(dop853, problem, rtol); });
#ifdef BENCH_HAS_CVODE
  all.emplace_back("CVODE", [problem](double rtol) { return run_cvode(true, problem, rtol); });
  all.emplace_back("CVODE Adams", [problem](double rtol) { return run_cvode(false, problem, rtol); });
#endif
#ifdef BENCH_HAS_GSL
  for (const auto& [name, type] : {std::pair{"GSL msbdf", gsl_odeiv2_step_msbdf},
                                   {"GSL bsimp", gsl_odeiv2_step_bsimp},
                                   {"GSL msadams", gsl_odeiv2_step_msadams},
                                   {"GSL rk8pd", gsl_odeiv2_step_rk8pd}})
    all.emplace_back(name, [problem, type = type](double rtol) { return run_gsl(type, problem, rtol); });
#endif
#ifdef BENCH_HAS_ODEINT
  for (auto& rival : odeint_rivals(problem)) all.push_back(std::move(rival));
#endif
  return all;
}

}  // namespace automatic

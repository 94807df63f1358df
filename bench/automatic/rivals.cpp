/// @file
/// LSODA (a translation to C++) and CVODE.
#include "rivals.hpp"

#include "../numbalsoda.hpp"

#include <memory>
#include <string>

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

void rate_for_lsoda(double t, double* y, double* out, double* user) {
  reinterpret_cast<const BareProblem*>(user)->rate(t, y, out);
}
Eigen::VectorXd run_lsoda(bench::Numbalsoda lsoda, BareProblem problem, double rtol) {
  const auto n = static_cast<int>(problem.start.size());
  Eigen::MatrixXd out(n, 2);
  double times[] = {0, problem.end};
  int success = 0;
  lsoda(rate_for_lsoda, n, problem.start.data(), reinterpret_cast<double*>(&problem), 2, times, out.data(), rtol,
        problem.a * rtol, most_steps, &success);
  return success == 1 ? Eigen::VectorXd(out.col(1)) : Eigen::VectorXd();
}

#ifdef BENCH_HAS_CVODE
using namespace reference::detail;

int rate_for_cvode(sunrealtype t, N_Vector y, N_Vector out, void* user) {
  static_cast<const BareProblem*>(user)->rate(t, NV_DATA_S(y), NV_DATA_S(out));
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

}  // namespace

std::vector<std::pair<std::string, RivalRun>> rivals_of(const BareProblem& problem) {
  std::vector<std::pair<std::string, RivalRun>> all;
  static const bench::Numbalsoda lsoda = bench::load_numbalsoda("lsoda");
  if (lsoda != nullptr) all.emplace_back("LSODA", [problem](double rtol) { return run_lsoda(lsoda, problem, rtol); });
#ifdef BENCH_HAS_CVODE
  all.emplace_back("CVODE", [problem](double rtol) { return run_cvode(true, problem, rtol); });
  all.emplace_back("CVODE Adams", [problem](double rtol) { return run_cvode(false, problem, rtol); });
#endif
  return all;
}

}  // namespace automatic

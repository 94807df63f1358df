/// @file
/// SUNDIALS' rows: CVODE and ARKODE with the force, the Jacobian and the linear solver that suit each problem.
///
/// What SUNDIALS can't do for itself is not on its clock: the pattern of a sparse matrix, and where each emitted entry goes.
#pragma once

#ifdef BENCH_HAS_SUNDIALS_SOLVERS

#include <arkode/arkode_arkstep.h>
#include <cvode/cvode.h>
#include <nvector/nvector_serial.h>
#include <sunlinsol/sunlinsol_band.h>
#include <sunlinsol/sunlinsol_dense.h>
#include <sunlinsol/sunlinsol_klu.h>
#include <sunlinsol/sunlinsol_spgmr.h>
#include <sunmatrix/sunmatrix_band.h>
#include <sunmatrix/sunmatrix_dense.h>
#include <sunmatrix/sunmatrix_sparse.h>
#include <sunnonlinsol/sunnonlinsol_fixedpoint.h>

#include <algorithm>
#include <array>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "reference/sundials.hpp"
#include "table.hpp"

#if SUNDIALS_VERSION_MAJOR > 7 || (SUNDIALS_VERSION_MAJOR == 7 && SUNDIALS_VERSION_MINOR >= 1)
#define BENCH_ARKODE(function) ARKode##function
#else
#define BENCH_ARKODE(function) ARKStep##function
#endif

namespace work_precision::sundials {

using namespace reference::detail;
using Vector = Eigen::VectorXd;

/// What the callbacks are given.
template <class Problem>
struct Data {
  const Problem& problem;
  long calls = 0;
};
template <class Problem>
int rate(sunrealtype t, N_Vector y, N_Vector out, void* user) {
  auto& data = *static_cast<Data<Problem>*>(user);
  ++data.calls;
  data.problem.rate(t, NV_DATA_S(y), NV_DATA_S(out));
  return 0;
}

// How Newton's linear equations are solved. Each makes its matrix and solver, and fills the matrix.

struct Dense {
  [[nodiscard]] SUNMatrix matrix(sunindextype n, SUNContext context) const { return SUNDenseMatrix(n, n, context); }
  [[nodiscard]] static SUNLinearSolver solver(N_Vector y, SUNMatrix J, SUNContext context) {
    return SUNLinSol_Dense(y, J, context);
  }
  void fill(const auto& problem, double t, const double* y, SUNMatrix J) const {
    sunrealtype* const to = SM_DATA_D(J);
    const auto n = SM_ROWS_D(J);
    problem.jacobian(t, y, [=](auto i, auto j, double x) { to[i + j * n] += x; });
  }
};

struct Band {
  sunindextype lower, upper;
  [[nodiscard]] SUNMatrix matrix(sunindextype n, SUNContext context) const {
    return SUNBandMatrix(n, upper, lower, context);
  }
  [[nodiscard]] static SUNLinearSolver solver(N_Vector y, SUNMatrix J, SUNContext context) {
    return SUNLinSol_Band(y, J, context);
  }
  void fill(const auto& problem, double t, const double* y, SUNMatrix J) const {
    sunrealtype* const to = SM_DATA_B(J);
    const auto leading = SM_LDIM_B(J), diagonal = SM_SUBAND_B(J);
    problem.jacobian(t, y, [=](auto i, auto j, double x) { to[i - j + diagonal + j * leading] += x; });
  }
};

/// KLU on columns in their order, with the pattern of what the problem emits.
class Klu {
 public:
  template <class Problem>
  explicit Klu(const Problem& problem) {
    const Vector y = problem.start();
    const auto n = y.size();
    std::vector<std::pair<sunindextype, std::size_t>> places;  // column by column, and who emits there
    problem.jacobian(0, y.data(), [&](auto i, auto j, double) { places.emplace_back(j * n + i, places.size()); });
    const std::size_t emitted = places.size();
    for (sunindextype i = 0; i < n; ++i) places.emplace_back(i * n + i, emitted);
    std::sort(places.begin(), places.end());
    slot_.resize(emitted + 1);
    start_.assign(static_cast<std::size_t>(n) + 1, 0);
    sunindextype last = -1;
    for (const auto& [place, who] : places) {
      if (place != last) {
        row_.push_back(place % n);
        ++start_[static_cast<std::size_t>(place / n) + 1];
      }
      last = place;
      slot_[who] = row_.size() - 1;
    }
    for (std::size_t j = 0; j < static_cast<std::size_t>(n); ++j) start_[j + 1] += start_[j];
  }
  [[nodiscard]] SUNMatrix matrix(sunindextype n, SUNContext context) const {
    return SUNSparseMatrix(n, n, static_cast<sunindextype>(row_.size()), CSC_MAT, context);
  }
  [[nodiscard]] static SUNLinearSolver solver(N_Vector y, SUNMatrix J, SUNContext context) {
    SUNLinearSolver solver = SUNLinSol_KLU(y, J, context);
    SUNLinSol_KLUSetOrdering(solver, 0);  // AMD: COLAMD, the default, fills twice as much on symmetric patterns
    return solver;
  }
  void fill(const auto& problem, double t, const double* y, SUNMatrix J) const {
    std::copy(start_.begin(), start_.end(), SM_INDEXPTRS_S(J));
    std::copy(row_.begin(), row_.end(), SM_INDEXVALS_S(J));
    sunrealtype* const to = SM_DATA_S(J);
    std::fill(to, to + row_.size(), 0.0);
    const std::size_t* slot = slot_.data();
    problem.jacobian(t, y, [&](auto, auto, double x) { to[*slot++] += x; });
  }

 private:
  std::vector<sunindextype> start_, row_;
  std::vector<std::size_t> slot_;
};

/// GMRES on products by differences, as SUNDIALS makes them; without a preconditioner.
struct Gmres {
  int dimension = 20;
};

template <class Linear>
struct IsMatrixFree : std::is_same<Linear, Gmres> {};

template <class Problem, class Linear>
struct Everything : Data<Problem> {
  const Linear& linear;
};
template <class Problem, class Linear>
int jacobian(sunrealtype t, N_Vector y, N_Vector, SUNMatrix J, void* user, N_Vector, N_Vector, N_Vector) {
  const auto& data = *static_cast<Everything<Problem, Linear>*>(static_cast<Data<Problem>*>(user));
  data.linear.fill(data.problem, t, NV_DATA_S(y), J);
  return 0;
}

/// The handles of one run.
struct Handles {
  Context context = make_context();
  State y;
  Matrix J;
  LinearSolver solver;
  explicit Handles(const Vector& start)
      : y{N_VNew_Serial(static_cast<sunindextype>(start.size()), context.get())} {
    view(y.get()) = start;
  }
  template <class Linear>
  void make_solver(const Linear& linear) {
    if constexpr (IsMatrixFree<Linear>::value) {
      solver.reset(SUNLinSol_SPGMR(y.get(), SUN_PREC_NONE, linear.dimension, context.get()));
    } else {
      J.reset(linear.matrix(N_VGetLength(y.get()), context.get()));
      solver.reset(Linear::solver(y.get(), J.get(), context.get()));
    }
  }
};

inline void be_quiet(SUNContext context) {
#if SUNDIALS_VERSION_MAJOR >= 7
  SUNContext_ClearErrHandlers(context);
#else
  static_cast<void>(context);
#endif
}
inline void ignore(int, const char*, const char*, char*, void*) {}

/// CVODE: variable order and step, BDF with Newton.
template <class Problem, class Linear>
[[nodiscard]] Answer cvode_bdf(const Problem& problem, double end, double a, double rtol, const Linear& linear) {
  Handles h(problem.start());
  be_quiet(h.context.get());
  const Memory<CVodeFree> memory{CVodeCreate(CV_BDF, h.context.get())};
  void* const cv = memory.get();
  Everything<Problem, Linear> data{{problem}, linear};
  CVodeInit(cv, rate<Problem>, 0, h.y.get());
#if SUNDIALS_VERSION_MAJOR < 7
  CVodeSetErrHandlerFn(cv, ignore, nullptr);
#endif
  CVodeSStolerances(cv, rtol, a * rtol);
  CVodeSetUserData(cv, static_cast<Data<Problem>*>(&data));
  CVodeSetMaxNumSteps(cv, 200000);
  CVodeSetStopTime(cv, end);
  h.make_solver(linear);
  CVodeSetLinearSolver(cv, h.solver.get(), h.J.get());
  if constexpr (!IsMatrixFree<Linear>::value) CVodeSetJacFn(cv, jacobian<Problem, Linear>);
  sunrealtype t = 0;
  if (CVode(cv, end, h.y.get(), &t, CV_NORMAL) < 0 || t != end) return {};
  long steps = 0, jacobians = 0, factorizations = 0, products = 0;
  CVodeGetNumSteps(cv, &steps);
  CVodeGetNumLinSolvSetups(cv, &factorizations);
  if constexpr (IsMatrixFree<Linear>::value) CVodeGetNumLinRhsEvals(cv, &products);
  else CVodeGetNumJacEvals(cv, &jacobians);
  return {view(h.y.get()), steps, data.calls, jacobians, IsMatrixFree<Linear>::value ? 0 : factorizations};
}

/// CVODE: Adams-Moulton with fixed-point iteration, for problems that aren't stiff.
template <class Problem>
[[nodiscard]] Answer cvode_adams(const Problem& problem, double end, double a, double rtol) {
  Handles h(problem.start());
  be_quiet(h.context.get());
  const Memory<CVodeFree> memory{CVodeCreate(CV_ADAMS, h.context.get())};
  void* const cv = memory.get();
  Data<Problem> data{problem};
  CVodeInit(cv, rate<Problem>, 0, h.y.get());
#if SUNDIALS_VERSION_MAJOR < 7
  CVodeSetErrHandlerFn(cv, ignore, nullptr);
#endif
  CVodeSStolerances(cv, rtol, a * rtol);
  CVodeSetUserData(cv, &data);
  CVodeSetMaxNumSteps(cv, 200000);
  CVodeSetStopTime(cv, end);
  const Handle<std::remove_pointer_t<SUNNonlinearSolver>, SUNNonlinSolFree> iteration{
      SUNNonlinSol_FixedPoint(h.y.get(), 0, h.context.get())};
  CVodeSetNonlinearSolver(cv, iteration.get());
  sunrealtype t = 0;
  if (CVode(cv, end, h.y.get(), &t, CV_NORMAL) < 0 || t != end) return {};
  long steps = 0;
  CVodeGetNumSteps(cv, &steps);
  return {view(h.y.get()), steps, data.calls};
}

/// ARKODE with the run that `set` prepares.
template <class Problem>
[[nodiscard]] Answer arkode(const Problem& problem, double end, double a, double rtol, int order, bool implicit,
                            auto&& set) {
  Handles h(problem.start());
  be_quiet(h.context.get());
  const Memory<BENCH_ARKODE(Free)> memory{ARKStepCreate(implicit ? nullptr : rate<Problem>,
                                                       implicit ? rate<Problem> : nullptr, 0, h.y.get(),
                                                       h.context.get())};
  void* const ark = memory.get();
#if SUNDIALS_VERSION_MAJOR < 7
  ARKStepSetErrHandlerFn(ark, ignore, nullptr);
#endif
  BENCH_ARKODE(SStolerances)(ark, rtol, a * rtol);
  BENCH_ARKODE(SetOrder)(ark, order);
  BENCH_ARKODE(SetMaxNumSteps)(ark, 200000);
  BENCH_ARKODE(SetStopTime)(ark, end);
  Data<Problem>& data = set(h, ark);
  sunrealtype t = 0;
  if (BENCH_ARKODE(Evolve)(ark, end, h.y.get(), &t, ARK_NORMAL) < 0 || t != end) return {};
  Answer answer{view(h.y.get()), 0, data.calls};
  long steps = 0;
  BENCH_ARKODE(GetNumSteps)(ark, &steps);
  answer.steps = steps;
  if (implicit && h.J) {
    long jacobians = 0, factorizations = 0;
    BENCH_ARKODE(GetNumJacEvals)(ark, &jacobians);
    BENCH_ARKODE(GetNumLinSolvSetups)(ark, &factorizations);
    answer.jacobians = jacobians;
    answer.factorizations = factorizations;
  }
  return answer;
}

/// ARKODE: a diagonally implicit Runge-Kutta method of fixed order. With the settings that make it work: Newton's error
/// kept below the step's, slopes recovered from the stage equation, stages predicted by extrapolation.
template <class Problem, class Linear>
[[nodiscard]] Answer arkode_dirk(const Problem& problem, double end, double a, double rtol, int order,
                                 const Linear& linear, double newton_share) {
  Everything<Problem, Linear> data{{problem}, linear};
  return arkode(problem, end, a, rtol, order, true, [&](Handles& h, void* ark) -> Data<Problem>& {
    BENCH_ARKODE(SetUserData)(ark, static_cast<Data<Problem>*>(&data));
    h.make_solver(linear);
    BENCH_ARKODE(SetLinearSolver)(ark, h.solver.get(), h.J.get());
    if constexpr (!IsMatrixFree<Linear>::value) BENCH_ARKODE(SetJacFn)(ark, jacobian<Problem, Linear>);
    BENCH_ARKODE(SetNonlinConvCoef)(ark, newton_share);
    BENCH_ARKODE(SetMaxNonlinIters)(ark, 8);
    BENCH_ARKODE(SetDeduceImplicitRhs)(ark, 1);
    BENCH_ARKODE(SetPredictorMethod)(ark, 1);
    return data;
  });
}

/// ARKODE: an explicit Runge-Kutta method of fixed order.
template <class Problem>
[[nodiscard]] Answer arkode_erk(const Problem& problem, double end, double a, double rtol, int order) {
  Data<Problem> data{problem};
  return arkode(problem, end, a, rtol, order, false, [&](Handles&, void* ark) -> Data<Problem>& {
    BENCH_ARKODE(SetUserData)(ark, &data);
    return data;
  });
}

/// CVODE BDF and ARKODE DIRK with one linear solver.
template <class Problem, class Linear>
void add_implicit(Table& table, const Problem& problem, double end, const std::string& solver, const Linear& linear,
                  double tightest = -8, const std::vector<int>& orders = {2, 3, 4, 5}) {
  const double a = table.a;
  table.methods.push_back({"CVODE BDF, " + solver, "rtol", tolerances(-1, tightest),
                           [=](double rtol) { return cvode_bdf(problem, end, a, rtol, linear); }});
  for (const int order : orders)
    table.methods.push_back(
        {"ARKODE DIRK" + std::to_string(order) + ", " + solver, "rtol", tolerances(-1, tightest),
         [=](double rtol) { return arkode_dirk(problem, end, a, rtol, order, linear, 1e-2); }});
}
/// CVODE Adams and ARKODE ERK of orders 3 … 5 and 8.
template <class Problem>
void add_explicit(Table& table, const Problem& problem, double end, double tightest = -10) {
  const double a = table.a;
  table.methods.push_back({"CVODE Adams", "rtol", tolerances(-1, tightest),
                           [=](double rtol) { return cvode_adams(problem, end, a, rtol); }});
  for (const int order : {3, 4, 5, 8})
    table.methods.push_back({"ARKODE ERK" + std::to_string(order), "rtol", tolerances(-1, tightest),
                             [=](double rtol) { return arkode_erk(problem, end, a, rtol, order); }});
}

}  // namespace work_precision::sundials

#undef BENCH_ARKODE
#endif

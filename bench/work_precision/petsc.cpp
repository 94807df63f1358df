/// @file
/// PETSc's rows, for stiff problems of a few unknowns: θ = ½ at the ends, Rosenbrock-W, an L-stable DIRK; dense LU.
#ifdef BENCH_HAS_PETSC
#include <petscts.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "../petsc_start.hpp"
#include "table.hpp"

namespace work_precision {
namespace {

/// What the callbacks are given.
struct Data {
  const System& system;
  void* self;
  long calls = 0, jacobians = 0;
  std::vector<double> values{};
};
PetscErrorCode rate(TS, PetscReal t, Vec Y, Vec Out, void* user) {
  auto& data = *static_cast<Data*>(user);
  ++data.calls;
  const double* y = nullptr;
  double* out = nullptr;
  VecGetArrayRead(Y, &y);
  VecGetArray(Out, &out);
  data.system.rate(t, y, out, data.self);
  VecRestoreArray(Out, &out);
  VecRestoreArrayRead(Y, &y);
  return 0;
}
PetscErrorCode jacobian(TS, PetscReal t, Vec Y, Mat J, Mat, void* user) {
  auto& data = *static_cast<Data*>(user);
  ++data.jacobians;
  const double* y = nullptr;
  double* to = nullptr;
  VecGetArrayRead(Y, &y);
  data.system.entries(t, y, data.values.data(), data.self);
  VecRestoreArrayRead(Y, &y);
  const auto n = static_cast<std::size_t>(data.system.size());
  MatDenseGetArray(J, &to);
  std::fill(to, to + n * n, 0.0);
  const double* value = data.values.data();
  for (const auto& [i, j] : data.system.pattern)
    to[static_cast<std::size_t>(i) + n * static_cast<std::size_t>(j)] += *value++;
  MatDenseRestoreArray(J, &to);
  MatAssemblyBegin(J, MAT_FINAL_ASSEMBLY);
  MatAssemblyEnd(J, MAT_FINAL_ASSEMBLY);
  return 0;
}
/// F = y' − f, which is what makes Rosenbrock methods implicit, and ∂F/∂y + s ∂F/∂y'.
PetscErrorCode residual(TS ts, PetscReal t, Vec Y, Vec Rate, Vec F, void* user) {
  rate(ts, t, Y, F, user);
  return VecAYPX(F, -1.0, Rate);
}
PetscErrorCode residual_jacobian(TS ts, PetscReal t, Vec Y, Vec, PetscReal shift, Mat J, Mat B, void* user) {
  jacobian(ts, t, Y, J, B, user);
  MatScale(J, -1.0);
  return MatShift(J, shift);
}

enum class Type { theta, rosenbrock, dirk };

Answer run(const System& system, Type type, double rtol, Film* film) {
  start_petsc();
  Eigen::VectorXd y = system.start;
  Data data{system, system.legs.front().self.get()};
  data.values.resize(system.pattern.size());
  const PetscInt n = system.size();
  const double end = system.end();
  Vec state = nullptr;
  Mat J = nullptr;
  TS ts = nullptr;
  VecCreateSeqWithArray(PETSC_COMM_SELF, 1, n, y.data(), &state);
  MatCreateSeqDense(PETSC_COMM_SELF, n, n, nullptr, &J);
  TSCreate(PETSC_COMM_SELF, &ts);
  TSSetProblemType(ts, TS_NONLINEAR);
  if (type == Type::rosenbrock) {
    TSSetIFunction(ts, nullptr, residual, &data);
    TSSetIJacobian(ts, J, J, residual_jacobian, &data);
    TSSetType(ts, TSROSW);
    TSRosWSetType(ts, TSROSWRA34PW2);
  } else {
    TSSetRHSFunction(ts, nullptr, rate, &data);
    TSSetRHSJacobian(ts, J, J, jacobian, &data);
    if (type == Type::theta) {
      TSSetType(ts, TSTHETA);
      TSThetaSetTheta(ts, 0.5);
      TSThetaSetEndpoint(ts, PETSC_TRUE);
    } else {
      TSSetType(ts, TSARKIMEX);
      TSARKIMEXSetType(ts, TSARKIMEX4);
      TSARKIMEXSetFullyImplicit(ts, PETSC_TRUE);
    }
  }
  TSSetTimeStep(ts, 1e-6 * std::min(end, 1.0));
  TSSetMaxSteps(ts, 100000);
  TSSetExactFinalTime(ts, TS_EXACTFINALTIME_MATCHSTEP);
  TSSetTolerances(ts, system.a * rtol, nullptr, rtol, nullptr);
  TSSetMaxStepRejections(ts, -1);
  TSSetMaxSNESFailures(ts, -1);
  TSAdapt adapt = nullptr;
  TSGetAdapt(ts, &adapt);
  TSAdaptSetType(adapt, TSADAPTBASIC);
  TSAdaptSetStepLimits(adapt, 0, 1e300);
  SNES newton = nullptr;
  TSGetSNES(ts, &newton);
  SNESSetTolerances(newton, 1e-50, std::min(1e-4, 0.1 * std::sqrt(rtol)), 1e-12, 20, 10000);
  KSP linear = nullptr;
  SNESGetKSP(newton, &linear);
  KSPSetType(linear, KSPPREONLY);
  PC preconditioner = nullptr;
  KSPGetPC(linear, &preconditioner);
  PCSetType(preconditioner, PCLU);

  PetscPushErrorHandler(PetscReturnErrorHandler, nullptr);
  const auto advance = [&](double t) {
    TSSetMaxTime(ts, t);
    TSConvergedReason reason = TS_CONVERGED_ITERATING;
    PetscReal reached = 0;
    const bool well = TSSolve(ts, state) == 0 && TSGetConvergedReason(ts, &reason) == 0 && reason > 0;
    TSGetSolveTime(ts, &reached);
    return well && reached >= t * (1 - 1e-12);
  };
  bool well = true;
  if (film)
    for (std::size_t k = 0; k < film->times.size() && well; ++k) {
      well = advance(film->times[k]);
      if (well) film->put(k, y.data());
    }
  else well = advance(end);
  PetscPopErrorHandler();
  PetscInt steps = 0;
  TSGetStepNumber(ts, &steps);
  TSDestroy(&ts);
  MatDestroy(&J);
  VecDestroy(&state);
  if (!well) return {};
  return {y, steps, data.calls, data.jacobians, data.jacobians};
}

}  // namespace

void petsc(Table& table) {
  if (table.system.shape != Shape::dense) return;
  const auto add = [&table](const char* name, Type type, double tightest) {
    table.add("PETSc", name, tolerances(-1, tightest),
              [system = table.system, type](double rtol, Film* film) { return run(system, type, rtol, film); });
  };
  add("theta 1/2", Type::theta, -6);
  add("rosw ra34pw2", Type::rosenbrock, -8);
  add("arkimex4", Type::dirk, -8);
}

}  // namespace work_precision
#endif

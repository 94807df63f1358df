/// @file
/// PETSc's generalized-α, alpha2: M a + K r = 0, a Cholesky factorization for each Δt, one Newton iteration a step and the residual
/// after it, in which alpha2 finds v and a (not so by SNESKSPONLY: they then are those of the guess). Its acceleration at the start
/// is its own, from two steps of half the length.
#include "problem.hpp"

#ifdef BENCH_HAS_PETSC
#include <petscts.h>

#include "../petsc_start.hpp"

namespace struck_beam {
namespace {

Mat matrix_of(const Sparse& A) {
  Mat B = nullptr;
  MatCreateSeqAIJ(PETSC_COMM_SELF, n, n, 8, nullptr, &B);
  for (int j = 0; j < n; ++j)
    for (Sparse::InnerIterator entry(A, j); entry; ++entry)
      MatSetValue(B, static_cast<PetscInt>(entry.row()), j, entry.value(), INSERT_VALUES);
  MatAssemblyBegin(B, MAT_FINAL_ASSEMBLY);
  MatAssemblyEnd(B, MAT_FINAL_ASSEMBLY);
  return B;
}

struct Data {
  Mat K, M;
  PetscReal shift = 0;  ///< of the Jacobian that is there
};
PetscErrorCode residual(TS, PetscReal, ::Vec r, ::Vec, ::Vec a, ::Vec out, void* user) {
  const Data& data = *static_cast<Data*>(user);
  MatMult(data.K, r, out);
  return MatMultAdd(data.M, a, out, out);
}
/// Left as it is, with its factors, while Δt stays.
PetscErrorCode jacobian(TS, PetscReal, ::Vec, ::Vec, ::Vec, PetscReal, PetscReal shift, Mat J, Mat, void* user) {
  Data& data = *static_cast<Data*>(user);
  if (shift == data.shift) return 0;
  data.shift = shift;
  MatCopy(data.K, J, SAME_NONZERO_PATTERN);
  return MatAXPY(J, shift, data.M, SAME_NONZERO_PATTERN);
}
struct Watch {
  Seen* seen;
};
PetscErrorCode look(TS ts, PetscInt, PetscReal t, ::Vec, void* user) {
  const Watch& watch = *static_cast<Watch*>(user);
  ::Vec r = nullptr, v = nullptr;
  TS2GetSolution(ts, &r, &v);
  const double *at = nullptr, *to = nullptr;
  VecGetArrayRead(r, &at);
  VecGetArrayRead(v, &to);
  (*watch.seen)(t, Eigen::Map<const Vec>(at, n), Eigen::Map<const Vec>(to, n));
  VecRestoreArrayRead(v, &to);
  return VecRestoreArrayRead(r, &at);
}

}  // namespace

void petsc(const Beam& beam, std::vector<Row>& rows, double rho, int count) {
  start_petsc();
  Row row{"PETSc alpha2(" + std::to_string(rho).substr(0, 3) + ")", {}};
  for (int k = 0; k < count; ++k)
    row.runs.push_back(timed(beam, [&](Seen* seen) -> long long {
      Vec r0 = Vec::Zero(n), v0 = beam.v0;
      Data data{matrix_of(beam.K), matrix_of(beam.M)};
      ::Vec r = nullptr, v = nullptr;
      Mat J = nullptr;
      TS ts = nullptr;
      VecCreateSeqWithArray(PETSC_COMM_SELF, 1, n, r0.data(), &r);
      VecCreateSeqWithArray(PETSC_COMM_SELF, 1, n, v0.data(), &v);
      MatDuplicate(data.K, MAT_COPY_VALUES, &J);
      TSCreate(PETSC_COMM_SELF, &ts);
      TSSetProblemType(ts, TS_NONLINEAR);
      TSSetType(ts, TSALPHA2);
      TSAlpha2SetRadius(ts, rho);
      TSSetI2Function(ts, nullptr, residual, &data);
      TSSetI2Jacobian(ts, J, J, jacobian, &data);
      TS2SetSolution(ts, r, v);
      TSSetTimeStep(ts, beam.period / (250 << k));
      TSSetMaxTime(ts, beam.t1);
      TSSetMaxSteps(ts, 1 << 30);
      TSSetExactFinalTime(ts, TS_EXACTFINALTIME_MATCHSTEP);
      TSAdapt adapt = nullptr;
      TSGetAdapt(ts, &adapt);
      TSAdaptSetType(adapt, TSADAPTNONE);
      Watch watch{seen};
      if (seen != nullptr) TSMonitorSet(ts, look, &watch, nullptr);
      SNES newton = nullptr;
      KSP linear = nullptr;
      PC factors = nullptr;
      SNESLineSearch search = nullptr;
      TSGetSNES(ts, &newton);
      SNESSetTolerances(newton, 0, 0, 0, 1, 1 << 30);
      SNESSetConvergenceTest(newton, SNESConvergedSkip, nullptr, nullptr);
      SNESGetLineSearch(newton, &search);
      SNESLineSearchSetType(search, SNESLINESEARCHBASIC);
      SNESGetKSP(newton, &linear);
      KSPSetType(linear, KSPPREONLY);
      KSPGetPC(linear, &factors);
      PCSetType(factors, PCCHOLESKY);
      PCFactorSetMatOrderingType(factors, MATORDERINGNATURAL);
      TSSolve(ts, nullptr);
      PetscInt steps = 0;
      TSGetStepNumber(ts, &steps);
      TSDestroy(&ts);
      for (Mat* A : {&J, &data.K, &data.M}) MatDestroy(A);
      for (::Vec* x : {&r, &v}) VecDestroy(x);
      return steps;
    }));
  rows.push_back(row);
}

}  // namespace struck_beam
#else
void struck_beam::petsc(const Beam&, std::vector<Row>&, double, int) {}
#endif

/// @file
/// CVODE's BDF. M is not the identity: y' = (v, −M⁻¹K r), M factorized once; Newton's equations (I − γJ) x = b by GMRES with the
/// exact inverse for a preconditioner, v from (M + γ²K) v = M b_v − γK b_r, so that it takes one iteration.
#include <cstdio>

#include "problem.hpp"

#ifdef BENCH_HAS_SUNDIALS_SOLVERS
#include <cvode/cvode.h>
#include <nvector/nvector_serial.h>
#include <sunlinsol/sunlinsol_spgmr.h>

namespace struck_beam {
namespace {

constexpr long most = 50000;  // steps

struct Data {
  const Beam& beam;
  Eigen::SimplicialLDLT<Sparse> mass, whole{};
};
auto part(N_Vector y, int at) { return Eigen::Map<Vec>(N_VGetArrayPointer(y) + at * n, n); }

int rate(sunrealtype, N_Vector y, N_Vector out, void* user) {
  Data& data = *static_cast<Data*>(user);
  part(out, 0) = part(y, 1);
  part(out, 1) = data.mass.solve(-(data.beam.K * part(y, 0)));
  return 0;
}
int set_up(sunrealtype, N_Vector, N_Vector, sunbooleantype, sunbooleantype* made, sunrealtype gamma, void* user) {
  Data& data = *static_cast<Data*>(user);
  data.whole.compute(Sparse(data.beam.M + gamma * gamma * data.beam.K));
  *made = 1;
  return 0;
}
int solve(sunrealtype, N_Vector, N_Vector, N_Vector b, N_Vector x, sunrealtype gamma, sunrealtype, int, void* user) {
  Data& data = *static_cast<Data*>(user);
  const Vec v = data.whole.solve(data.beam.M * part(b, 1) - gamma * (data.beam.K * part(b, 0)));
  part(x, 0) = part(b, 0) + gamma * v;
  part(x, 1) = v;
  return 0;
}
int product(N_Vector x, N_Vector out, sunrealtype t, N_Vector, N_Vector, void* user, N_Vector) {
  return rate(t, x, out, user);
}

}  // namespace

void cvode(const Beam& beam, std::vector<Row>& rows) {
  Row row{"CVODE, BDF", {}};
  for (int k = 0; k < 2; ++k)
    row.runs.push_back(timed(beam, [&](Seen* seen) -> long long {
      SUNContext context = nullptr;
      SUNContext_Create(nullptr, &context);
      N_Vector y = N_VNew_Serial(2 * n, context);
      part(y, 0).setZero();
      part(y, 1) = beam.v0;
      Data data{beam, Eigen::SimplicialLDLT<Sparse>(beam.M)};
      void* cv = CVodeCreate(CV_BDF, context);
      CVodeInit(cv, rate, 0, y);
      CVodeSStolerances(cv, std::pow(10.0, -2 - k), std::pow(10.0, -4 - k));
      CVodeSetUserData(cv, &data);
      SUNLinearSolver gmres = SUNLinSol_SPGMR(y, SUN_PREC_LEFT, 5, context);
      CVodeSetLinearSolver(cv, gmres, nullptr);
      CVodeSetPreconditioner(cv, set_up, solve);
      CVodeSetJacTimes(cv, nullptr, product);
      sunrealtype t = 0;
      CVodeSetStopTime(cv, beam.t1);
      long steps = 0;
      for (; t < beam.t1 && steps < most && CVode(cv, beam.t1, y, &t, CV_ONE_STEP) >= 0; ++steps)
        if (seen != nullptr) (*seen)(t, part(y, 0), part(y, 1));
      if (t < beam.t1 && seen != nullptr)
        std::printf("CVODE, rtol %.0e: after %ld steps at t = %.3f of %.3f\n", std::pow(10.0, -2 - k), steps, t,
                    beam.t1);
      CVodeFree(&cv);
      SUNLinSolFree(gmres);
      N_VDestroy(y);
      SUNContext_Free(&context);
      return steps;
    }));
  rows.push_back(row);
}

}  // namespace struck_beam
#else
void struck_beam::cvode(const Beam&, std::vector<Row>&) {}
#endif

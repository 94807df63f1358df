// Spots that divide: the reaction and diffusion of Gray and Scott (gray_scott.hpp) on a square grid that PETSc spreads over
// all ranks (gray_scott_grid.hpp). The state is a Vec of a DMDA, the steps and their error control are phistep's, the linear
// equations those of a KSP that the command line chooses.
//
// Run: mpiexec -n 2 gray_scott_petsc [-n 256] [-t1 6000] [-rtol 1e-3] [-out gray_scott.csv] [-ksp_type gmres] …
// Picture: python3 plot/plot_gray_scott.py [DIR]
#include <phistep/petsc.hpp>

#include "gray_scott_grid.hpp"

using phistep::check_petsc;

static void run() {
  PetscInt n = 256;
  double t1 = 6000, rtol = 1e-3;
  char file[256] = "gray_scott.csv";
  check_petsc(PetscOptionsGetInt(nullptr, nullptr, "-n", &n, nullptr));
  check_petsc(PetscOptionsGetReal(nullptr, nullptr, "-t1", &t1, nullptr));
  check_petsc(PetscOptionsGetReal(nullptr, nullptr, "-rtol", &rtol, nullptr));
  check_petsc(PetscOptionsGetString(nullptr, nullptr, "-out", file, sizeof file, nullptr));

  const gray_scott::Grid problem(n);
  phistep::PetscField y{problem.start()};
  const phistep::PetscForce force{[&](Vec state, Vec rate) { problem.rate(state, rate); }};
  phistep::PhiStepper stepper{y, force, phistep::rodas4p2, phistep::newton(problem.solver())};
  const phistep::RunReport report =
      phistep::integrate(stepper, y, {0.0, t1}, phistep::tolerance{.rtol = rtol, .atol = rtol});

  int ranks = 0;
  MPI_Comm_size(PETSC_COMM_WORLD, &ranks);
  const auto& work = report.statistics;
  check_petsc(PetscPrintf(PETSC_COMM_WORLD,
                          "%d x %d points on %d ranks, %s: %lld steps, dt from %.2g to %.2g\n"
                          "%lld calls of the rate, %lld Jacobians, %lld solves of %.1f iterations each\n",
                          static_cast<int>(n), static_cast<int>(n), ranks, describe(report.outcome),
                          static_cast<long long>(work.steps), report.smallest_dt, report.largest_dt,
                          static_cast<long long>(work.force_calls), static_cast<long long>(work.jacobians),
                          static_cast<long long>(work.solves),
                          static_cast<double>(work.linear_iterations) / static_cast<double>(work.solves)));
  problem.write(y.handle(), file);
}

int main(int argc, char** argv) {
  check_petsc(PetscInitialize(&argc, &argv, nullptr, nullptr));
  run();  // all that belongs to PETSc has to end before PETSc does
  return PetscFinalize();
}

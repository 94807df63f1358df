// Spots that divide: the reaction and diffusion of Gray and Scott (gray_scott.hpp) on a square grid that PETSc spreads over all
// ranks. The state is a Vec of a DMDA, the steps and their error control are phistep's, the linear equations those of a KSP that
// the command line chooses.
//
// Run: mpiexec -n 2 gray_scott_petsc [-n 256] [-t1 6000] [-rtol 1e-3] [-out gray_scott.csv] [-ksp_type gmres] [-pc_type bjacobi] …
// Picture: python3 plot/plot_gray_scott.py [DIR]
#include <petscdmda.h>

#include <cmath>
#include <cstdio>
#include <phistep/petsc.hpp>

#include "gray_scott.hpp"

using namespace gray_scott;
using phistep::check_petsc;

class GrayScott {
 public:
  explicit GrayScott(PetscInt n) : n_{n}, c_{1 / std::pow(length / static_cast<double>(n), 2)} {
    check_petsc(DMDACreate2d(PETSC_COMM_WORLD, DM_BOUNDARY_PERIODIC, DM_BOUNDARY_PERIODIC, DMDA_STENCIL_STAR, n, n,
                             PETSC_DECIDE, PETSC_DECIDE, 2, 1, nullptr, nullptr, &dm_));
    check_petsc(DMSetFromOptions(dm_));
    check_petsc(DMSetUp(dm_));
    check_petsc(DMDAGetCorners(dm_, &i0_, &j0_, nullptr, &ni_, &nj_, nullptr));
  }
  GrayScott(const GrayScott&) = delete;
  GrayScott& operator=(const GrayScott&) = delete;
  ~GrayScott() { DMDestroy(&dm_); }

  [[nodiscard]] Vec start() const {
    Vec y = nullptr;
    check_petsc(DMCreateGlobalVector(dm_, &y));
    double*** at = nullptr;
    check_petsc(DMDAVecGetArrayDOF(dm_, y, &at));
    for_each([&](PetscInt j, PetscInt i) {
      const auto [u, v] = gray_scott::start(place(i), place(j));
      at[j][i][0] = u, at[j][i][1] = v;
    });
    check_petsc(DMDAVecRestoreArrayDOF(dm_, y, &at));
    return y;
  }
  /// Ψ(y): each rank fetches the edges of its neighbours, then computes its own part.
  void rate(Vec y, Vec out) const {
    Vec local = nullptr;
    check_petsc(DMGetLocalVector(dm_, &local));
    check_petsc(DMGlobalToLocal(dm_, y, INSERT_VALUES, local));
    const double*** at = nullptr;
    double*** to = nullptr;
    check_petsc(DMDAVecGetArrayDOFRead(dm_, local, &at));
    check_petsc(DMDAVecGetArrayDOF(dm_, out, &to));
    for_each([&](PetscInt j, PetscInt i) {
      const auto laplacian = [&](int m) {
        return c_ * (at[j][i - 1][m] + at[j][i + 1][m] + at[j - 1][i][m] + at[j + 1][i][m] - 4 * at[j][i][m]);
      };
      const auto [u, v] = reaction(at[j][i][0], at[j][i][1]);
      to[j][i][0] = D_u * laplacian(0) + u;
      to[j][i][1] = D_v * laplacian(1) + v;
    });
    check_petsc(DMDAVecRestoreArrayDOFRead(dm_, local, &at));
    check_petsc(DMDAVecRestoreArrayDOF(dm_, out, &to));
    check_petsc(DMRestoreLocalVector(dm_, &local));
  }
  /// ∂Ψ/∂y, two rows at once.
  void jacobian(Vec y, Mat J) const {
    const double*** at = nullptr;
    check_petsc(DMDAVecGetArrayDOFRead(dm_, y, &at));
    check_petsc(MatZeroEntries(J));
    for_each([&](PetscInt j, PetscInt i) {
      const double a = c_ * D_u, b = c_ * D_v;
      const auto [u, v] = tangent(at[j][i][0], at[j][i][1]);
      const MatStencil row{0, j, i, 0};
      const MatStencil columns[5] = {
          {0, j, i, 0}, {0, j, i + 1, 0}, {0, j, i - 1, 0}, {0, j + 1, i, 0}, {0, j - 1, i, 0}};
      const double rows[2][10] = {{u[0] - 4 * a, u[1], a, 0, a, 0, a, 0, a, 0},
                                  {v[0], v[1] - 4 * b, 0, b, 0, b, 0, b, 0, b}};
      check_petsc(MatSetValuesBlockedStencil(J, 1, &row, 5, columns, &rows[0][0], INSERT_VALUES));
    });
    check_petsc(DMDAVecRestoreArrayDOFRead(dm_, y, &at));
    check_petsc(MatAssemblyBegin(J, MAT_FINAL_ASSEMBLY));
    check_petsc(MatAssemblyEnd(J, MAT_FINAL_ASSEMBLY));
  }
  [[nodiscard]] phistep::PetscSolver solver() const {
    Mat like = nullptr;
    check_petsc(DMCreateMatrix(dm_, &like));
    phistep::PetscSolver solver{like, [this](double, Vec y, Mat J) { jacobian(y, J); }};
    check_petsc(MatDestroy(&like));
    return solver;
  }
  /// v on rank 0, row by row.
  void write(Vec y, const char* file) const {
    Vec natural = nullptr, whole = nullptr;
    VecScatter scatter = nullptr;
    check_petsc(DMDACreateNaturalVector(dm_, &natural));
    check_petsc(DMDAGlobalToNaturalBegin(dm_, y, INSERT_VALUES, natural));
    check_petsc(DMDAGlobalToNaturalEnd(dm_, y, INSERT_VALUES, natural));
    check_petsc(VecScatterCreateToZero(natural, &scatter, &whole));
    check_petsc(VecScatterBegin(scatter, natural, whole, INSERT_VALUES, SCATTER_FORWARD));
    check_petsc(VecScatterEnd(scatter, natural, whole, INSERT_VALUES, SCATTER_FORWARD));
    PetscMPIInt rank = 0;
    MPI_Comm_rank(PETSC_COMM_WORLD, &rank);
    if (std::FILE* out = rank == 0 ? std::fopen(file, "w") : nullptr; out != nullptr) {
      const double* at = nullptr;
      check_petsc(VecGetArrayRead(whole, &at));
      for (PetscInt j = 0; j < n_; ++j)
        for (PetscInt i = 0; i < n_; ++i)
          std::fprintf(out, "%.5g%c", at[2 * (j * n_ + i) + 1], i + 1 < n_ ? ',' : '\n');
      check_petsc(VecRestoreArrayRead(whole, &at));
      std::fclose(out);
    }
    check_petsc(VecScatterDestroy(&scatter));
    check_petsc(VecDestroy(&natural));
    check_petsc(VecDestroy(&whole));
  }

 private:
  [[nodiscard]] double place(PetscInt i) const { return length * static_cast<double>(i) / static_cast<double>(n_); }
  void for_each(auto&& f) const {
    for (PetscInt j = j0_; j < j0_ + nj_; ++j)
      for (PetscInt i = i0_; i < i0_ + ni_; ++i) f(j, i);
  }
  PetscInt n_;
  double c_;  // [1/length²]
  DM dm_ = nullptr;
  PetscInt i0_ = 0, j0_ = 0, ni_ = 0, nj_ = 0;  // this rank's part
};

static void run() {
  PetscInt n = 256;
  double t1 = 6000, rtol = 1e-3;
  char file[256] = "gray_scott.csv";
  check_petsc(PetscOptionsGetInt(nullptr, nullptr, "-n", &n, nullptr));
  check_petsc(PetscOptionsGetReal(nullptr, nullptr, "-t1", &t1, nullptr));
  check_petsc(PetscOptionsGetReal(nullptr, nullptr, "-rtol", &rtol, nullptr));
  check_petsc(PetscOptionsGetString(nullptr, nullptr, "-out", file, sizeof file, nullptr));

  const GrayScott problem(n);
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

// The reaction of gray_scott.hpp on a square grid that PETSc spreads over all ranks: a DMDA.
#pragma once

#include <petscdmda.h>

#include <cmath>
#include <cstdio>
#include <phistep/petsc.hpp>

#include "gray_scott.hpp"

namespace gray_scott {

using phistep::check_petsc;

class Grid {
 public:
  explicit Grid(PetscInt n) : n_{n}, c_{1 / std::pow(length / static_cast<double>(n), 2)} {
    check_petsc(DMDACreate2d(PETSC_COMM_WORLD, DM_BOUNDARY_PERIODIC, DM_BOUNDARY_PERIODIC, DMDA_STENCIL_STAR, n, n,
                             PETSC_DECIDE, PETSC_DECIDE, 2, 1, nullptr, nullptr, &dm_));
    check_petsc(DMSetFromOptions(dm_));
    check_petsc(DMSetUp(dm_));
    check_petsc(DMDAGetCorners(dm_, &i0_, &j0_, nullptr, &ni_, &nj_, nullptr));
  }
  Grid(const Grid&) = delete;
  Grid& operator=(const Grid&) = delete;
  ~Grid() { DMDestroy(&dm_); }

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
  /// An empty one; the caller's.
  [[nodiscard]] Mat matrix() const {
    Mat J = nullptr;
    check_petsc(DMCreateMatrix(dm_, &J));
    return J;
  }
  [[nodiscard]] phistep::PetscSolver solver() const {
    Mat like = matrix();
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

}  // namespace gray_scott

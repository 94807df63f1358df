// Fields on PETSc's Vec.
#include <petscdmda.h>

#include <cmath>
#include <string>
#include <string_view>

#include "adapters/brusselator.hpp"
#include "phistep/petsc.hpp"

using namespace phistep;

namespace {
class Grid {
 public:
  using Field = PetscField;
  Grid() {
    check_petsc(DMDACreate2d(PETSC_COMM_WORLD, DM_BOUNDARY_PERIODIC, DM_BOUNDARY_PERIODIC, DMDA_STENCIL_STAR, N, N,
                             PETSC_DECIDE, PETSC_DECIDE, 2, 1, nullptr, nullptr, &dm_));
    check_petsc(DMSetUp(dm_));
    check_petsc(DMCreateMatrix(dm_, &like_));
    check_petsc(DMDAGetCorners(dm_, &i0_, &j0_, nullptr, &ni_, &nj_, nullptr));
  }
  Grid(const Grid&) = delete;
  Grid& operator=(const Grid&) = delete;
  ~Grid() {
    MatDestroy(&like_);
    DMDestroy(&dm_);
  }
  [[nodiscard]] Mat like() const { return like_; }
  [[nodiscard]] PetscField start() const {
    Vec y = nullptr;
    check_petsc(DMCreateGlobalVector(dm_, &y));
    for_each(y, [](int j, int i, int c, double& x) { x = c == 0 ? u0(j) : v0(i); });
    return PetscField{y};
  }
  void rate(Vec y, Vec out) const {
    Vec local = nullptr;
    check_petsc(DMGetLocalVector(dm_, &local));
    check_petsc(DMGlobalToLocal(dm_, y, INSERT_VALUES, local));
    const double*** from = nullptr;
    double*** to = nullptr;
    check_petsc(DMDAVecGetArrayDOFRead(dm_, local, &from));
    check_petsc(DMDAVecGetArrayDOF(dm_, out, &to));
    for_each([&](int j, int i) {
      reaction([&](int dj, int di, int c) { return from[j + dj][i + di][c]; }, to[j][i][0], to[j][i][1]);
    });
    check_petsc(DMDAVecRestoreArrayDOFRead(dm_, local, &from));
    check_petsc(DMDAVecRestoreArrayDOF(dm_, out, &to));
    check_petsc(DMRestoreLocalVector(dm_, &local));
  }
  void jacobian(Vec y, Mat J) const {
    const double*** from = nullptr;
    check_petsc(DMDAVecGetArrayDOFRead(dm_, y, &from));
    check_petsc(MatZeroEntries(J));
    for_each([&](int j, int i) {
      const double u = from[j][i][0], v = from[j][i][1], c = diffusion;
      const MatStencil row{0, j, i, 0},
          columns[5] = {{0, j, i, 0}, {0, j, i + 1, 0}, {0, j, i - 1, 0}, {0, j + 1, i, 0}, {0, j - 1, i, 0}};
      const double block[2][10] = {{2 * u * v - 4.4 - 4 * c, u * u, c, 0, c, 0, c, 0, c, 0},
                                   {3.4 - 2 * u * v, -u * u - 4 * c, 0, c, 0, c, 0, c, 0, c}};
      MatSetValuesBlockedStencil(J, 1, &row, 5, columns, &block[0][0], INSERT_VALUES);
    });
    check_petsc(DMDAVecRestoreArrayDOFRead(dm_, y, &from));
    check_petsc(MatAssemblyBegin(J, MAT_FINAL_ASSEMBLY));
    check_petsc(MatAssemblyEnd(J, MAT_FINAL_ASSEMBLY));
  }
  [[nodiscard]] PetscSolver solver() const {
    return PetscSolver{like_, [this](double, Vec y, Mat J) { jacobian(y, J); }};
  }
  void for_each(Vec y, auto&& f) const {
    double*** all = nullptr;
    check_petsc(DMDAVecGetArrayDOF(dm_, y, &all));
    for_each([&](int j, int i) { f(j, i, 0, all[j][i][0]), f(j, i, 1, all[j][i][1]); });
    check_petsc(DMDAVecRestoreArrayDOF(dm_, y, &all));
  }

 private:
  void for_each(auto&& f) const {
    for (PetscInt j = j0_; j < j0_ + nj_; ++j)
      for (PetscInt i = i0_; i < i0_ + ni_; ++i) f(static_cast<int>(j), static_cast<int>(i));
  }
  DM dm_ = nullptr;
  Mat like_ = nullptr;
  PetscInt i0_ = 0, j0_ = 0, ni_ = 0, nj_ = 0;
};
constexpr const char* library = "petsc";
constexpr int some_error_code = PETSC_ERR_USER;
}  // namespace

#include "adapters/rank_cases.hpp"

namespace {
/// PETSc's life around main(), which is Catch2's own.
const struct Petsc {
  Petsc() {
    PetscInitializeNoArguments();
    PetscPopSignalHandler();
    PetscPushErrorHandler(PetscReturnErrorHandler, nullptr);
    watch_ranks();
  }
  Petsc(const Petsc&) = delete;
  Petsc& operator=(const Petsc&) = delete;
  ~Petsc() { PetscFinalize(); }
} petsc;
}  // namespace

TEST_CASE("PETSc's multigrid serves every step length") {
  // Made for the first steps, where W is nearly the identity, and kept, it would take hundreds of iterations later on.
  check_petsc(PetscOptionsSetValue(nullptr, "-pc_type", "gamg"));
  const Grid grid;
  PetscField y = grid.start();
  PhiStepper stepper{y, PetscForce{[&](Vec x, Vec out) { grid.rate(x, out); }}, rodas4, newton(grid.solver())};
  check_petsc(PetscOptionsClearValue(nullptr, "-pc_type"));
  const RunReport report = integrate(stepper, y, {0.0, 1.0}, tolerance{.rtol = 1e-3, .atol = 1e-3});
  CHECK(report);
  CHECK(report.largest_dt > 20 * report.smallest_dt);
  CHECK(report.statistics.linear_iterations <= 8 * report.statistics.solves);
}

namespace {
/// y' = −y on 100 points with J = −1 as a matrix of this kind: what the run said where the end isn't 1/e, empty where it is.
std::string decay_with(Mat like, KSP own = nullptr) {
  Vec ones = nullptr;
  check_petsc(VecCreateMPI(PETSC_COMM_WORLD, PETSC_DECIDE, 100, &ones));
  check_petsc(VecSet(ones, 1));
  PetscField y{ones};
  const PetscForce force{[](Vec x, Vec out) { return VecAXPBY(out, -1, 0, x); }};
  std::string said;
  try {
    PetscSolver solver{like, [](double, Vec, Mat J) {
                         MatType type = nullptr;
                         check_petsc(MatGetType(J, &type));
                         if (std::string_view{type} == MATSHELL) return;
                         PetscInt from = 0, to = 0;
                         check_petsc(MatGetOwnershipRange(J, &from, &to));
                         for (PetscInt i = from; i < to; ++i) check_petsc(MatSetValue(J, i, i, -1, INSERT_VALUES));
                         check_petsc(MatAssemblyBegin(J, MAT_FINAL_ASSEMBLY));
                         check_petsc(MatAssemblyEnd(J, MAT_FINAL_ASSEMBLY));
                       }};
    if (own != nullptr) solver.use(own);
    PhiStepper stepper{y, force, rodas4, newton(solver)};
    const RunReport report = integrate(stepper, y, {0.0, 1.0}, tolerance{.rtol = 1e-6, .atol = 1e-9});
    PetscReal largest = 0;
    check_petsc(VecNorm(y.handle(), NORM_INFINITY, &largest));
    if (!report || std::abs(largest * std::exp(1.0) - 1) > 1e-4) said = report.message();
  } catch (const std::exception& error) {
    said = error.what();
  }
  MatDestroy(&like);
  return said;
}
}  // namespace

TEST_CASE("a matrix of numbers") {
  Mat like = nullptr;
  check_petsc(MatCreateAIJ(PETSC_COMM_WORLD, PETSC_DECIDE, PETSC_DECIDE, 100, 100, 1, nullptr, 0, nullptr, &like));
  PetscInt from = 0, to = 0;
  check_petsc(MatGetOwnershipRange(like, &from, &to));
  for (PetscInt i = from; i < to; ++i) check_petsc(MatSetValue(like, i, i, 0, INSERT_VALUES));
  check_petsc(MatAssemblyBegin(like, MAT_FINAL_ASSEMBLY));
  check_petsc(MatAssemblyEnd(like, MAT_FINAL_ASSEMBLY));
  CHECK(decay_with(like) == "");
}
TEST_CASE("a matrix that is only a product, MATSHELL") {
  Mat like = nullptr;
  check_petsc(MatCreateShell(PETSC_COMM_WORLD, PETSC_DECIDE, PETSC_DECIDE, 100, 100, nullptr, &like));
  const auto product = [](Mat, Vec x, Vec out) { return VecAXPBY(out, -1, 0, x); };
  check_petsc(MatShellSetOperation(like, MATOP_MULT, reinterpret_cast<void (*)()>(+product)));
  CHECK(decay_with(like) == "");
}
TEST_CASE("a matrix that fills its pattern when it is assembled first") {
  Mat like = nullptr;
  check_petsc(MatCreateAIJ(PETSC_COMM_WORLD, PETSC_DECIDE, PETSC_DECIDE, 100, 100, 1, nullptr, 0, nullptr, &like));
  CHECK(decay_with(like) == "");
}
TEST_CASE("the application's own KSP") {
  Mat like = nullptr;
  check_petsc(MatCreateShell(PETSC_COMM_WORLD, PETSC_DECIDE, PETSC_DECIDE, 100, 100, nullptr, &like));
  const auto product = [](Mat, Vec x, Vec out) { return VecAXPBY(out, -1, 0, x); };
  check_petsc(MatShellSetOperation(like, MATOP_MULT, reinterpret_cast<void (*)()>(+product)));
  KSP own = nullptr;
  check_petsc(KSPCreate(PETSC_COMM_WORLD, &own));
  PC pc = nullptr;
  check_petsc(KSPGetPC(own, &pc));
  check_petsc(PCSetType(pc, PCNONE));
  CHECK(decay_with(like, own) == "");
  PetscInt iterations = 0;
  check_petsc(KSPGetTotalIterations(own, &iterations));
  CHECK(iterations > 0);
  check_petsc(KSPDestroy(&own));
}

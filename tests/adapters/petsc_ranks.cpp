// A field on PETSc's Vec, to be run on 1, 2 and 3 ranks: the digits and counts of Eigen's vectors, one decision for all ranks
// whatever happens on one of them, and how often the ranks wait for each other.
#include <petscdmda.h>
#include <unistd.h>

#include <Eigen/Core>
#include <Eigen/Sparse>

#include <cmath>
#include <cstddef>
#include <iostream>
#include <limits>
#include <stdexcept>
#include <string>
#include <vector>

#include "phistep/petsc.hpp"
#include "phistep/sparse.hpp"
#include "support/catch.hpp"

using namespace phistep;

static long reductions = 0;
// MPI's profiling interface: this one is called, and counts.
#undef MPI_Allreduce  // PETSc counts by a macro
extern "C" int MPI_Allreduce(const void* mine, void* all, int n, MPI_Datatype type, MPI_Op op, MPI_Comm comm) {
  ++reductions;
  return PMPI_Allreduce(mine, all, n, type, op, comm);
}

namespace {
/// PETSc's life around main(), which is Catch2's own.
const struct Petsc {
  Petsc() {
    PetscInitializeNoArguments();
    PetscPopSignalHandler();
    PetscPushErrorHandler(PetscReturnErrorHandler, nullptr);
    alarm(240);  // ranks that wait for each other for ever end here
    int mine = 0;
    MPI_Comm_rank(PETSC_COMM_WORLD, &mine);
    if (mine != 0) std::cout.setstate(std::ios::failbit);
  }
  Petsc(const Petsc&) = delete;
  Petsc& operator=(const Petsc&) = delete;
  ~Petsc() { PetscFinalize(); }
} petsc;

int rank() {
  int mine = 0;
  MPI_Comm_rank(PETSC_COMM_WORLD, &mine);
  return mine;
}
int ranks() {
  int all = 0;
  MPI_Comm_size(PETSC_COMM_WORLD, &all);
  return all;
}

/// The Brusselator with diffusion on a periodic N × N grid (Hairer & Wanner, Solving ODEs II, p. 151), u and v interleaved.
constexpr int N = 12;
constexpr double diffusion = 0.1 * N * N;
double u0(int j) { return 22 * (j / double(N)) * std::pow(1 - j / double(N), 1.5); }
double v0(int i) { return 27 * (i / double(N)) * std::pow(1 - i / double(N), 1.5); }
/// @param at  at(rows on, columns on, component)
void reaction(auto&& at, double& fu, double& fv) {
  const double u = at(0, 0, 0), v = at(0, 0, 1);
  fu = 1 + u * u * v - 4.4 * u + diffusion * (at(0, -1, 0) + at(0, 1, 0) + at(-1, 0, 0) + at(1, 0, 0) - 4 * u);
  fv = 3.4 * u - u * u * v + diffusion * (at(0, -1, 1) + at(0, 1, 1) + at(-1, 0, 1) + at(1, 0, 1) - 4 * v);
}

class Grid {
 public:
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
    double*** all = nullptr;
    check_petsc(DMDAVecGetArrayDOF(dm_, y, &all));
    for_each([&](int j, int i) { all[j][i][0] = u0(j), all[j][i][1] = v0(i); });
    check_petsc(DMDAVecRestoreArrayDOF(dm_, y, &all));
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
  /// The largest difference to a state of Eigen's, whole on every rank.
  [[nodiscard]] double difference(const PetscField& y, const Eigen::VectorXd& other) const {
    double most = 0, all = 0;
    const double*** from = nullptr;
    check_petsc(DMDAVecGetArrayDOFRead(dm_, y.handle(), &from));
    for_each([&](int j, int i) {
      for (int c = 0; c < 2; ++c) most = std::max(most, std::abs(from[j][i][c] - other[2 * (j * N + i) + c]));
    });
    check_petsc(DMDAVecRestoreArrayDOFRead(dm_, y.handle(), &from));
    MPI_Allreduce(&most, &all, 1, MPI_DOUBLE, MPI_MAX, PETSC_COMM_WORLD);
    return all;
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

/// The same on one of Eigen's vectors.
struct Whole {
  static Eigen::VectorXd start() {
    Eigen::VectorXd y(2 * N * N);
    for (int j = 0; j < N; ++j)
      for (int i = 0; i < N; ++i) y[2 * (j * N + i)] = u0(j), y[2 * (j * N + i) + 1] = v0(i);
    return y;
  }
  static int at(int j, int i) { return 2 * ((j + N) % N * N + (i + N) % N); }
  Eigen::VectorXd operator()(const Eigen::VectorXd& y) const {
    Eigen::VectorXd out(y.size());
    for (int j = 0; j < N; ++j)
      for (int i = 0; i < N; ++i)
        reaction([&](int dj, int di, int c) { return y[at(j + dj, i + di) + c]; }, out[at(j, i)], out[at(j, i) + 1]);
    return out;
  }
  static Eigen::SparseMatrix<double> jacobian(const Eigen::VectorXd& y) {
    std::vector<Eigen::Triplet<double>> entries;
    for (int j = 0; j < N; ++j)
      for (int i = 0; i < N; ++i) {
        const int k = at(j, i);
        const double u = y[k], v = y[k + 1], c = diffusion;
        entries.insert(entries.end(), {{k, k, 2 * u * v - 4.4 - 4 * c},
                                       {k, k + 1, u * u},
                                       {k + 1, k, 3.4 - 2 * u * v},
                                       {k + 1, k + 1, -u * u - 4 * c}});
        for (const int other : {at(j, i + 1), at(j, i - 1), at(j + 1, i), at(j - 1, i)})
          entries.insert(entries.end(), {{k, other, c}, {k + 1, other + 1, c}});
      }
    Eigen::SparseMatrix<double> J(2 * N * N, 2 * N * N);
    J.setFromTriplets(entries.begin(), entries.end());
    return J;
  }
};

void compare(const auto& scheme, double tolerated) {
  const Grid grid;
  PetscField y = grid.start();
  PhiStepper stepper{y, PetscForce{[&](Vec x, Vec out) { grid.rate(x, out); }}, scheme,
                     newton(grid.solver(), {.linear_rtol = 1e-13})};
  const tolerance control{.rtol = 1e-4, .atol = 1e-4};
  const RunReport report = integrate(stepper, y, {0.0, 1.0}, control);
  Eigen::VectorXd z = Whole::start();
  PhiStepper like{z, Whole{}, scheme, newton<Eigen::SparseLU<Eigen::SparseMatrix<double>>>()};
  const RunReport expected = integrate(like, z, {0.0, 1.0}, control);
  REQUIRE(report);
  CHECK(report.statistics.steps == expected.statistics.steps);
  CHECK(report.statistics.rejections == expected.statistics.rejections);
  CHECK(report.statistics.force_calls == expected.statistics.force_calls);
  CHECK(report.statistics.jacobians == expected.statistics.jacobians);
  CHECK(grid.difference(y, z) <= tolerated * z.lpNorm<Eigen::Infinity>());
}

enum class Fault { none, not_a_number, exception, error_code };
/// The rate, with a fault on one rank from one of its calls on, until it is mended.
struct Faulty {
  const Grid* grid;
  Fault fault;
  int on_rank, at_call;
  const bool* is_mended;
  int calls = 0;
  PetscErrorCode operator()(Vec y, Vec out) {
    grid->rate(y, out);
    if (calls++ < at_call || rank() != on_rank || *is_mended) return 0;
    if (fault == Fault::exception) throw std::runtime_error("rank " + std::to_string(on_rank));
    if (fault == Fault::error_code) return PETSC_ERR_USER;
    double* x = nullptr;
    check_petsc(VecGetArray(out, &x));
    x[1] = std::numeric_limits<double>::quiet_NaN();
    check_petsc(VecRestoreArray(out, &x));
    return 0;
  }
};
bool same_bits_on_all(const PetscField& a, const PetscField& b) { return PetscOps::equal(a.handle(), b.handle()); }
bool all_alike(int mine) {
  int most = 0, least = 0;
  MPI_Allreduce(&mine, &most, 1, MPI_INT, MPI_MAX, PETSC_COMM_WORLD);
  MPI_Allreduce(&mine, &least, 1, MPI_INT, MPI_MIN, PETSC_COMM_WORLD);
  return most == least;
}

/// Steps until a fault shows: on all ranks at the same step, with the state as it was before.
void meet(const auto& scheme, Fault fault, int on_rank, int at_call) {
  CAPTURE(static_cast<int>(fault), on_rank, at_call);
  const Grid grid;
  PetscField y = grid.start(), before = y;
  bool is_mended = false;
  PhiStepper stepper{y, PetscForce{Faulty{&grid, fault, on_rank, at_call, &is_mended}}, scheme, newton(grid.solver())};
  Outcome outcome = Outcome::success;
  bool thrown = false;
  int steps = 0;
  double t = 0;
  for (; steps < 20 && outcome == Outcome::success && !thrown; ++steps) {
    before = y;
    try {
      outcome = stepper.step(y, t, 0.002).outcome();
    } catch (const std::exception& error) {
      thrown = true;
    }
    if (!thrown && outcome == Outcome::success) t += 0.002;
  }
  CHECK(all_alike(steps));
  CHECK(same_bits_on_all(y, before));
  if (fault == Fault::not_a_number) {
    CHECK_FALSE(thrown);
    CHECK(all_alike(static_cast<int>(outcome)));
    // Not where the force itself was NaN, it made the state so.
    CAPTURE(describe(outcome));
    CHECK((outcome == Outcome::non_finite_force || outcome == Outcome::non_finite_state));
  } else {
    CHECK(thrown == (rank() == on_rank));
    if (!thrown) CHECK(outcome == Outcome::exception_elsewhere);
  }
  is_mended = true;
  const bool goes_on = static_cast<bool>(stepper.step(y, t, 0.002));
  CHECK(goes_on);
  PetscField z = before;
  PhiStepper anew{z, PetscForce{Faulty{&grid, Fault::none, 0, 0, &is_mended}}, scheme, newton(grid.solver())};
  const bool does = static_cast<bool>(anew.step(z, t, 0.002));
  CHECK(does);
  CHECK(same_bits_on_all(y, z));
}
void meet_all(const auto& scheme, int calls) {
  for (const Fault fault : {Fault::not_a_number, Fault::exception, Fault::error_code})
    for (int on_rank = 0; on_rank < ranks(); ++on_rank)
      for (int at_call = 0; at_call < calls; ++at_call) meet(scheme, fault, on_rank, at_call);
}
}  // namespace

TEST_CASE("a field on a Vec takes the steps of Eigen's vectors, to 12 digits") {
  compare(rodas4, 1e-12);
  compare(rodas5p, 1e-12);
  compare(tsit5, 1e-12);
}
TEST_CASE("whatever goes wrong on one rank, all ranks end the step alike") {
  meet_all(trapezoidal, 6);
  meet_all(rodas4, 8);
  meet_all(tsit5, 8);
}
TEST_CASE("an exception on one rank ends the run of all") {
  for (int on_rank = 0; on_rank < ranks(); ++on_rank)
    for (int at_call : {0, 1, 2, 3, 7, 30}) {
      CAPTURE(on_rank, at_call);
      const Grid grid;
      PetscField y = grid.start();
      const bool is_mended = false;
      PhiStepper stepper{y, PetscForce{Faulty{&grid, Fault::exception, on_rank, at_call, &is_mended}}, rodas4,
                         newton(grid.solver())};
      bool thrown = false;
      RunReport report;
      try {
        report = integrate(stepper, y, {0.0, 1.0}, tolerance{.rtol = 1e-3, .atol = 1e-3});
      } catch (const std::runtime_error&) {
        thrown = true;
      }
      CHECK(thrown == (rank() == on_rank));
      if (!thrown) CHECK(report.outcome == Outcome::exception_elsewhere);
    }
}
TEST_CASE("an edit on one rank is an edit on all") {
  const Grid grid;
  for (int on_rank = 0; on_rank < ranks(); ++on_rank) {
    PetscField y = grid.start();
    PhiStepper stepper{y, PetscForce{[&](Vec x, Vec out) { grid.rate(x, out); }}, phi(0.7), newton(grid.solver())};
    bool good = static_cast<bool>(stepper.step(y, 0.0, 0.002));
    if (rank() == on_rank) {
      double* x = nullptr;
      check_petsc(VecGetArray(y.handle(), &x));
      x[0] += 0.5;
      check_petsc(VecRestoreArray(y.handle(), &x));
    }
    PetscField z = y;
    good = stepper.step(y, 0.002, 0.002) && good;
    PhiStepper anew{z, PetscForce{[&](Vec x, Vec out) { grid.rate(x, out); }}, phi(0.7), newton(grid.solver())};
    good = anew.step(z, 0.002, 0.002) && good;
    CHECK(good);
    double difference = 0;
    check_petsc(VecAXPY(z.handle(), -1, y.handle()));
    check_petsc(VecNorm(z.handle(), NORM_INFINITY, &difference));
    CHECK(difference <= 1e-4);
  }
}
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
TEST_CASE("how often the ranks wait for each other") {
  const Grid grid;
  PetscField y = grid.start();
  PhiStepper euler{y, PetscForce{[&](Vec x, Vec out) { grid.rate(x, out); }}, forward_euler};
  REQUIRE(euler.step(y, 0.0, 1e-4));  // the vectors are made
  const long before = reductions;
  for (int k = 1; k < 11; ++k) REQUIRE(euler.step(y, k * 1e-4, 1e-4));
  CHECK(reductions - before == 10);  // whether all of y is finite
}

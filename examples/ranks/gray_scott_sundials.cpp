// The same spots as those of gray_scott_petsc.cpp, on SUNDIALS: the state is an N_Vector, of which each rank has some rows of the grid,
// the linear equations are solved by SPGMR, preconditioned point by point.
//
// Run: mpiexec -n 2 gray_scott_sundials [n = 256] [t1 = 6000] [rtol = 1e-3] [file = gray_scott.csv]
// Picture: python3 plot/plot_gray_scott.py [DIR]
#include <mpi.h>
#include <nvector/nvector_parallel.h>
#include <sunlinsol/sunlinsol_spgmr.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <cstdlib>
#include <phistep/sundials.hpp>
#include <vector>

#include "gray_scott.hpp"

using namespace gray_scott;

/// Rows j0 … j0 + rows − 1 of an n × n grid, u and v of a point side by side.
class Rows {
 public:
  Rows(int n, SUNContext context) : n_{n}, c_{std::pow(n / length, 2)}, context_{context} {
    MPI_Comm_rank(MPI_COMM_WORLD, &rank_);
    MPI_Comm_size(MPI_COMM_WORLD, &ranks_);
    j0_ = first(rank_), rows_ = first(rank_ + 1) - j0_;
    near_.resize(2 * static_cast<std::size_t>(n_) * static_cast<std::size_t>(rows_ + 2));
  }
  [[nodiscard]] N_Vector start() const {
    const N_Vector y = N_VNew_Parallel(MPI_COMM_WORLD, row() * rows_, row() * n_, context_);
    double* const to = N_VGetArrayPointer(y);
    for_each([&](int j, int i) {
      const auto [u, v] = gray_scott::start(length * i / n_, length * (j0_ + j) / n_);
      to[at(j, i)] = u, to[at(j, i) + 1] = v;
    });
    return y;
  }
  /// Ψ(y)
  void rate(N_Vector y, N_Vector out) {
    fetch(y);
    const double* const of = N_VGetArrayPointer(y);
    double* const to = N_VGetArrayPointer(out);
    for_each([&](int j, int i) {
      const auto [u, v] = reaction(of[at(j, i)], of[at(j, i) + 1]);
      to[at(j, i)] = D_u * laplacian(j, i, 0) + u;
      to[at(j, i) + 1] = D_v * laplacian(j, i, 1) + v;
    });
  }
  /// ∂Ψ/∂y x
  void product(N_Vector y, N_Vector x, N_Vector out) {
    fetch(x);
    const double *const of = N_VGetArrayPointer(y), *const by = N_VGetArrayPointer(x);
    double* const to = N_VGetArrayPointer(out);
    for_each([&](int j, int i) {
      const std::size_t p = at(j, i);
      const auto [u, v] = tangent(of[p], of[p + 1]);
      to[p] = D_u * laplacian(j, i, 0) + u[0] * by[p] + u[1] * by[p + 1];
      to[p + 1] = D_v * laplacian(j, i, 1) + v[0] * by[p] + v[1] * by[p + 1];
    });
  }
  /// z = D⁻¹ r, D what 1 − γ ∂Ψ/∂y has of each point with itself
  void divide(N_Vector y, double gamma, N_Vector r, N_Vector z) const {
    const double *const of = N_VGetArrayPointer(y), *const by = N_VGetArrayPointer(r);
    double* const to = N_VGetArrayPointer(z);
    for_each([&](int j, int i) {
      const std::size_t p = at(j, i);
      const auto [u, v] = tangent(of[p], of[p + 1]);
      const double a = 1 - gamma * (u[0] - 4 * c_ * D_u), b = -gamma * u[1], c = -gamma * v[0],
                   d = 1 - gamma * (v[1] - 4 * c_ * D_v), inverse = 1 / (a * d - b * c);
      const double first = by[p], second = by[p + 1];
      to[p] = inverse * (d * first - b * second);
      to[p + 1] = inverse * (a * second - c * first);
    });
  }
  /// v on rank 0, row by row.
  void write(N_Vector y, const char* name) const {
    std::vector<int> counts, starts;
    for (int rank = 0; rank < ranks_; ++rank) {
      starts.push_back(first(rank) * static_cast<int>(row()));
      counts.push_back(first(rank + 1) * static_cast<int>(row()) - starts.back());
    }
    std::vector<double> all(rank_ == 0 ? static_cast<std::size_t>(row() * n_) : 0);
    MPI_Gatherv(N_VGetArrayPointer(y), counts[static_cast<std::size_t>(rank_)], MPI_DOUBLE, all.data(), counts.data(),
                starts.data(), MPI_DOUBLE, 0, MPI_COMM_WORLD);
    if (std::FILE* out = rank_ == 0 ? std::fopen(name, "w") : nullptr; out != nullptr) {
      for (int j = 0; j < n_; ++j)
        for (int i = 0; i < n_; ++i) std::fprintf(out, "%.5g%c", all[at(j, i) + 1], i + 1 < n_ ? ',' : '\n');
      std::fclose(out);
    }
  }
  [[nodiscard]] int ranks() const { return ranks_; }

 private:
  [[nodiscard]] int first(int rank) const { return static_cast<int>(static_cast<long>(n_) * rank / ranks_); }
  [[nodiscard]] sunindextype row() const { return 2 * static_cast<sunindextype>(n_); }  // numbers in a row
  [[nodiscard]] std::size_t at(int j, int i) const {
    return 2 * (static_cast<std::size_t>(j) * static_cast<std::size_t>(n_) + static_cast<std::size_t>(i));
  }
  /// The rows here and, from the ranks beside this one, a row below and one above.
  void fetch(N_Vector x) {
    const auto many = static_cast<int>(row());
    const std::size_t width = static_cast<std::size_t>(many), inside = width * static_cast<std::size_t>(rows_);
    const double* const own = N_VGetArrayPointer(x);
    std::copy_n(own, inside, near_.begin() + many);
    const int below = (rank_ + ranks_ - 1) % ranks_, above = (rank_ + 1) % ranks_;
    MPI_Sendrecv(own, many, MPI_DOUBLE, below, 0, near_.data() + width + inside, many, MPI_DOUBLE, above, 0,
                 MPI_COMM_WORLD, MPI_STATUS_IGNORE);
    MPI_Sendrecv(own + inside - width, many, MPI_DOUBLE, above, 1, near_.data(), many, MPI_DOUBLE, below, 1,
                 MPI_COMM_WORLD, MPI_STATUS_IGNORE);
  }
  /// ∇² of what was fetched.
  [[nodiscard]] double laplacian(int j, int i, std::size_t m) const {
    const int left = i == 0 ? n_ - 1 : i - 1, right = i + 1 == n_ ? 0 : i + 1;
    const auto x = [&](int row, int column) { return near_[at(row + 1, column) + m]; };
    return c_ * (x(j, left) + x(j, right) + x(j - 1, i) + x(j + 1, i) - 4 * x(j, i));
  }
  void for_each(auto&& f) const {
    for (int j = 0; j < rows_; ++j)
      for (int i = 0; i < n_; ++i) f(j, i);
  }

  int n_;
  double c_;  // [1/length²]
  SUNContext context_;
  int rank_ = 0, ranks_ = 1, j0_ = 0, rows_ = 0;
  std::vector<double> near_;
};

static void run(int n, double t1, double rtol, const char* file, SUNContext context) {
  Rows problem(n, context);
  const N_Vector start = problem.start(), at = N_VClone(start);
  phistep::SundialsField y{start};
  const phistep::SundialsForce force{[&](N_Vector state, N_Vector rate) { problem.rate(state, rate); }};
  const SUNLinearSolver gmres = SUNLinSol_SPGMR(start, SUN_PREC_RIGHT, 50, context);
  phistep::SundialsSolver solver{
      gmres, [&](double, N_Vector state, N_Vector x, N_Vector Jx) { problem.product(state, x, Jx); }};
  solver.precondition([&](double, N_Vector state, double) { N_VScale(1, state, at); },
                      [&](double gamma, N_Vector r, N_Vector z) { problem.divide(at, gamma, r, z); });
  phistep::PhiStepper stepper{y, force, phistep::rodas4p2, phistep::newton(solver)};
  const phistep::RunReport report =
      phistep::integrate(stepper, y, {0.0, t1}, phistep::tolerance{.rtol = rtol, .atol = rtol});

  int rank = 0;
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  const auto& work = report.statistics;
  if (rank == 0)
    std::printf(
        "%d x %d points on %d ranks, %s: %lld steps, dt from %.2g to %.2g\n"
        "%lld calls of the rate, %lld Jacobians, %lld solves of %.1f iterations each\n",
        n, n, problem.ranks(), describe(report.outcome), static_cast<long long>(work.steps), report.smallest_dt,
        report.largest_dt, static_cast<long long>(work.force_calls), static_cast<long long>(work.jacobians),
        static_cast<long long>(work.solves),
        static_cast<double>(work.linear_iterations) / static_cast<double>(work.solves));
  problem.write(y.handle(), file);
  N_VDestroy(at);
}

int main(int argc, char** argv) {
  MPI_Init(&argc, &argv);
  MPI_Comm all = MPI_COMM_WORLD;
  SUNContext context = nullptr;
  SUNContext_Create(&all, &context);
  const auto given = [&](int k, const char* otherwise) { return k < argc ? argv[k] : otherwise; };
  run(std::atoi(given(1, "256")), std::atof(given(2, "6000")), std::atof(given(3, "1e-3")), given(4, "gray_scott.csv"),
      context);  // all that belongs to SUNDIALS has to end before its context does
  SUNContext_Free(&context);
  MPI_Finalize();
}

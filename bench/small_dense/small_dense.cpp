/// @file
/// Factorization and solve of dense n×n systems, n = 2 … 20: phistep's LU, the same by hand, Eigen, SUNDIALS.
///
/// factor    copies one matrix into the solver and factorizes it; its pivots lie on the diagonal, so no branch surprises
/// pivoting  the same for 8 matrices in turn whose pivots lie anywhere, each elsewhere
/// solve     copies the right-hand side and solves; one call may overlap the next
/// chained   each solve waits for the answer of the one before, as Newton's corrections do
///
/// All answers are compared before anything is timed. Without arguments, ends with a table of median CPU times over 9 repetitions
/// interleaved at random, and the ratios of phistep to the same by hand.
///     bench_small_dense [--benchmark_filter=…]
#include <benchmark/benchmark.h>

#include <Eigen/Dense>

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <memory>
#include <random>
#include <string>
#include <type_traits>
#include <vector>

#include <phistep/step/matrix/small_dense_lu.hpp>

#include "hand.hpp"
#ifdef BENCH_HAS_SUNDIALS
#include <nvector/nvector_serial.h>
#include <sundials/sundials_config.h>
#include <sunlinsol/sunlinsol_dense.h>
#include <sunmatrix/sunmatrix_dense.h>
#endif

namespace {

template <int n>
using Matrix = Eigen::Matrix<double, n, n>;
template <int n>
using Vector = Eigen::Matrix<double, n, 1>;
constexpr int pivotings = 8;

template <int n>
struct Problem {
  Matrix<n> dominant;
  std::array<Matrix<n>, pivotings> any;
  Vector<n> b;
  Problem() {
    std::mt19937 random(1);
    std::uniform_real_distribution<double> uniform(-1, 1);
    const auto fill = [&](auto& A) {
      for (int j = 0; j < A.cols(); ++j)
        for (int i = 0; i < A.rows(); ++i) A(i, j) = uniform(random);
    };
    fill(dominant);
    dominant.diagonal().array() += 3;
    for (auto& A : any) fill(A);
    fill(b);
  }
};

// Every rival has factor(A) and solve(x).
template <class Solver>
struct Phistep {
  Solver solver;
  void factor(const auto& A) {
    solver.matrix() = A;
    if (!solver.factorize()) std::abort();
  }
  void solve(auto& x) const { solver.solve_in_place(x); }
};
template <class Hand>
struct ByHand {
  Hand hand;
  void factor(const auto& A) { hand.factor(A.data()); }
  void solve(auto& x) const { hand.solve(x.data()); }
};
template <int n>
struct EigenLu {
  Eigen::PartialPivLU<Matrix<n>> lu;
  void factor(const auto& A) { lu.compute(A); }
  void solve(auto& x) const { x = lu.solve(x); }
};
template <int n>
struct EigenInverse {
  Matrix<n> inverse;
  void factor(const auto& A) { inverse = A.inverse(); }
  void solve(auto& x) const { x = inverse * x; }
};
struct EigenDynamic {
  Eigen::PartialPivLU<Eigen::MatrixXd> lu;
  void factor(const auto& A) { lu.compute(A); }
  void solve(auto& x) const { x = lu.solve(x); }
};
#ifdef BENCH_HAS_SUNDIALS
#if SUNDIALS_VERSION_MAJOR >= 7
SUNContext sundials_context() {
  static const SUNContext context = [] {
    SUNContext made = nullptr;
    SUNContext_Create(SUN_COMM_NULL, &made);
    return made;
  }();
  return context;
}
#else
SUNContext sundials_context() {
  static const SUNContext context = [] {
    SUNContext made = nullptr;
    SUNContext_Create(nullptr, &made);
    return made;
  }();
  return context;
}
#endif
template <int n>
struct Sundials {
  N_Vector b = N_VNew_Serial(n, sundials_context()),
           x = N_VMake_Serial(n, N_VGetArrayPointer(b), sundials_context());  // x borrows its numbers
  SUNMatrix A = SUNDenseMatrix(n, n, sundials_context());
  SUNLinearSolver solver = SUNLinSol_Dense(b, A, sundials_context());
  Sundials() = default;
  Sundials(const Sundials&) = delete;
  Sundials& operator=(const Sundials&) = delete;
  ~Sundials() {
    SUNLinSolFree(solver);
    SUNMatDestroy(A);
    N_VDestroy(x);
    N_VDestroy(b);
  }
  void factor(const auto& from) {
    std::copy(from.data(), from.data() + n * n, SUNDenseMatrix_Data(A));
    if (SUNLinSolSetup(solver, A) != 0) std::abort();
  }
  void solve(auto& y) const {  // in place, as CVODE does it
    N_VSetArrayPointer(y.data(), x);
    if (SUNLinSolSolve(solver, A, x, x, 0) != 0) std::abort();
  }
};
#endif

/// f(name, rival) for all of one size.
template <int n>
void for_each_rival(auto f) {
  f("phistep LU", std::type_identity<Phistep<phistep::DenseLu<double, n>>>{});
  f("hand LU", std::type_identity<ByHand<small_dense::HandLu<n>>>{});
  f("Eigen LU", std::type_identity<EigenLu<n>>{});
  if constexpr (n <= 4) f("Eigen inverse", std::type_identity<EigenInverse<n>>{});
  f("Eigen dynamic", std::type_identity<EigenDynamic>{});
#ifdef BENCH_HAS_SUNDIALS
  f("SUNDIALS", std::type_identity<Sundials<n>>{});
#endif
}

template <class Rival, int n>
void factor(benchmark::State& run, const Matrix<n>* matrices, int count) {
  Rival rival;
  int i = 0;
  for (auto _ : run) {
    rival.factor(matrices[i]);
    benchmark::DoNotOptimize(&rival);
    benchmark::ClobberMemory();
    i = (i + 1) % count;
  }
}
template <class Rival, int n>
void solve(benchmark::State& run, const Problem<n>& problem, bool chained) {
  Rival rival;
  rival.factor(problem.dominant);
  Vector<n> x = problem.b;
  int i = 0;
  for (auto _ : run) {
    if (!chained) x = problem.b;
    else if (++i % 16 == 0) x = 1e-300 * x + problem.b;  // it shrinks with every solve, and must not reach zero
    rival.solve(x);
    benchmark::DoNotOptimize(x.data());
    benchmark::ClobberMemory();
  }
}

template <int n>
void add() {
  static const Problem<n> problem;
  for_each_rival<n>([](const char* name, auto type) {
    using Rival = typename decltype(type)::type;
    for (int k = -1; k < pivotings; ++k) {
      const Matrix<n>& A = k < 0 ? problem.dominant : problem.any[static_cast<unsigned>(k)];
      const Vector<n> expected = A.fullPivLu().solve(problem.b);
      Vector<n> x = problem.b;
      Rival rival;
      rival.factor(A);
      rival.solve(x);
      // n u times the growth and the condition numbers of these matrices, at most 3e3.
      if (!((x - expected).norm() <= 1e-11 * expected.norm())) {
        std::fprintf(stderr, "bench_small_dense: %s is wrong for n = %d; nothing was timed\n", name, n);
        std::exit(1);
      }
    }
    const std::string row = "n=" + std::to_string(n) + "/" + name + "/";
    const auto register_as = [&](const char* what, auto body) {
      benchmark::RegisterBenchmark((row + what).c_str(), body);
    };
    register_as("factor", [](auto& run) { factor<Rival, n>(run, &problem.dominant, 1); });
    register_as("pivoting", [](auto& run) { factor<Rival, n>(run, problem.any.data(), pivotings); });
    register_as("solve", [](auto& run) { solve<Rival, n>(run, problem, false); });
    register_as("chained", [](auto& run) { solve<Rival, n>(run, problem, true); });
  });
}

/// Prints what the console prints, and keeps the medians.
class Medians : public benchmark::ConsoleReporter {
 public:
  void ReportRuns(const std::vector<Run>& runs) override {
    ConsoleReporter::ReportRuns(runs);
    for (const Run& run : runs)
      if (run.aggregate_name == "median") ns_[run.run_name.function_name] = run.GetAdjustedCPUTime();
  }
  void print() const {
    for (const char* what : {"factor", "pivoting", "solve", "chained"}) {
      std::printf("\n%s, medians in ns\n%4s", what, "n");
      for (const char* name : names) std::printf("%16s", name);
      std::printf("%16s\n", "phistep/hand");
      for (const int n : {2, 3, 4, 5, 8, 12, 15, 20}) {
        std::printf("%4d", n);
        for (const char* name : names) {
          const double ns = of(n, name, what);
          if (ns > 0) std::printf("%16.1f", ns);
          else std::printf("%16s", "-");
        }
        std::printf("%16.2f\n", of(n, "phistep LU", what) / of(n, "hand LU", what));
      }
    }
  }

 private:
  static constexpr std::array names{"phistep LU", "hand LU", "Eigen LU", "Eigen inverse", "Eigen dynamic", "SUNDIALS"};
  [[nodiscard]] double of(int n, const char* name, const char* what) const {
    const auto found = ns_.find("n=" + std::to_string(n) + "/" + name + "/" + what);
    return found == ns_.end() ? 0 : found->second;
  }
  std::map<std::string, double> ns_;
};

}  // namespace

int main(int argc, char** argv) {
  add<2>();
  add<3>();
  add<4>();
  add<5>();
  add<8>();
  add<12>();
  add<15>();
  add<20>();

  std::vector<char*> arguments(argv, argv + argc);
  char interleave[] = "--benchmark_enable_random_interleaving=true", repeat[] = "--benchmark_repetitions=9",
       aggregates[] = "--benchmark_report_aggregates_only=true", brief[] = "--benchmark_min_time=0.01";
  if (argc == 1) arguments.insert(arguments.end(), {interleave, repeat, aggregates, brief});
  int count = static_cast<int>(arguments.size());
  benchmark::Initialize(&count, arguments.data());
  Medians medians;
  benchmark::RunSpecifiedBenchmarks(&medians);
  if (argc == 1) medians.print();
}

// Fields on N_Vectors of SUNDIALS: of MPI's ranks, and several of them in a ManyVector; serial ones, with a SUNMatrix.
#include <mpi.h>
#include <nvector/nvector_mpimanyvector.h>
#include <nvector/nvector_parallel.h>
#include <nvector/nvector_serial.h>
#include <sunlinsol/sunlinsol_dense.h>
#include <sunlinsol/sunlinsol_spbcgs.h>
#include <sunlinsol/sunlinsol_spgmr.h>
#include <sunmatrix/sunmatrix_dense.h>

#include <deque>
#include <map>
#include <vector>

#include "adapters/brusselator.hpp"
#include "phistep/sundials.hpp"

using namespace phistep;

namespace {
SUNContext context = nullptr;
constexpr const char* library = "sundials";
constexpr int some_error_code = -17;

/// Each rank has some rows.
class Grid {
 public:
  using Field = SundialsField;
  enum class Kind { interleaved, many };  ///< u and v in one vector, or one each
  explicit Grid(Kind kind = Kind::interleaved) : kind_{kind} {
    MPI_Comm_rank(MPI_COMM_WORLD, &rank_);
    MPI_Comm_size(MPI_COMM_WORLD, &ranks_);
    j0_ = rank_ * N / ranks_, rows_ = (rank_ + 1) * N / ranks_ - j0_;
  }
  [[nodiscard]] Field start() const {
    const auto part = [this](int components) {
      return N_VNew_Parallel(MPI_COMM_WORLD, components * rows_ * N, components * N * N, context);
    };
    N_Vector y = nullptr;
    if (kind_ == Kind::many) {
      N_Vector parts[2] = {part(1), part(1)};
      y = N_VMake_MPIManyVector(MPI_COMM_WORLD, 2, parts, context);
      N_VEnableLinearCombination_MPIManyVector(y, SUNTRUE);
      static_cast<N_VectorContent_MPIManyVector>(y->content)->own_data = SUNTRUE;
    } else {
      y = part(2);
    }
    for_each(y, [](int j, int i, int c, double& x) { x = c == 0 ? u0(j) : v0(i); });
    return Field{y};
  }
  void rate(N_Vector y, N_Vector out) const {
    fetch(y);
    for (int j = 0; j < rows_; ++j)
      for (int i = 0; i < N; ++i)
        reaction([&](int dj, int di, int c) { return near_by(j + dj, i + di, c); }, at(out, j, i, 0), at(out, j, i, 1));
  }
  void product(N_Vector y, N_Vector x, N_Vector out) const {
    fetch(x);
    for (int j = 0; j < rows_; ++j)
      for (int i = 0; i < N; ++i) {
        const double u = at(y, j, i, 0), v = at(y, j, i, 1), du = near_by(j, i, 0), dv = near_by(j, i, 1);
        const auto diffused = [&](int c) {
          return diffusion * (near_by(j, i - 1, c) + near_by(j, i + 1, c) + near_by(j - 1, i, c) +
                              near_by(j + 1, i, c) - 4 * near_by(j, i, c));
        };
        const double reacts = 2 * u * v * du + u * u * dv;
        at(out, j, i, 0) = reacts - 4.4 * du + diffused(0);
        at(out, j, i, 1) = 3.4 * du - reacts + diffused(1);
      }
  }
  [[nodiscard]] SundialsSolver solver() const {
    const Field like = start();
    const SUNLinearSolver method = SUNLinSol_SPGMR(like.handle(), SUN_PREC_NONE, 60, context);
    SUNLinSol_SPGMRSetMaxRestarts(method, 20);
    return SundialsSolver{method, [this](double, N_Vector y, N_Vector x, N_Vector out) { product(y, x, out); }};
  }
  void for_each(N_Vector y, auto&& f) const {
    for (int j = 0; j < rows_; ++j)
      for (int i = 0; i < N; ++i)
        for (int c = 0; c < 2; ++c) f(j0_ + j, i, c, at(y, j, i, c));
  }

 private:
  [[nodiscard]] double& at(N_Vector x, int j, int i, int c) const {
    if (kind_ == Kind::many) return N_VGetSubvectorArrayPointer_MPIManyVector(x, c)[j * N + i];
    return N_VGetArrayPointer(x)[2 * (j * N + i) + c];
  }
  /// All rows of x, and those of the neighbours beside them.
  void fetch(N_Vector x) const {
    constexpr int w = 2 * N;
    rows_and_two_.resize(static_cast<std::size_t>((rows_ + 2) * w));
    double* const to = rows_and_two_.data();
    for (int j = 0; j < rows_; ++j)
      for (int i = 0; i < N; ++i)
        for (int c = 0; c < 2; ++c) to[(j + 1) * w + 2 * i + c] = at(x, j, i, c);
    const int up = (rank_ + 1) % ranks_, down = (rank_ + ranks_ - 1) % ranks_;
    MPI_Sendrecv(to + rows_ * w, w, MPI_DOUBLE, up, 0, to, w, MPI_DOUBLE, down, 0, MPI_COMM_WORLD, MPI_STATUS_IGNORE);
    MPI_Sendrecv(to + w, w, MPI_DOUBLE, down, 1, to + (rows_ + 1) * w, w, MPI_DOUBLE, up, 1, MPI_COMM_WORLD,
                 MPI_STATUS_IGNORE);
  }
  [[nodiscard]] double near_by(int j, int i, int c) const {
    return rows_and_two_[static_cast<std::size_t>((j + 1) * 2 * N + 2 * ((i + N) % N) + c)];
  }
  Kind kind_;
  int rank_ = 0, ranks_ = 1, j0_ = 0, rows_ = 0;
  mutable std::vector<double> rows_and_two_;
};
}  // namespace

#include "adapters/rank_cases.hpp"

namespace {
/// MPI's life around main(), which is Catch2's own.
const struct Life {
  Life() {
    MPI_Init(nullptr, nullptr);
    MPI_Comm all = MPI_COMM_WORLD;
    SUNContext_Create(&all, &context);
    watch_ranks();
  }
  Life(const Life&) = delete;
  Life& operator=(const Life&) = delete;
  ~Life() {
    SUNContext_Free(&context);
    MPI_Finalize();
  }
} life;

/// y' = −y², three numbers on each rank by itself.
SundialsForce squares{[](N_Vector y, N_Vector out) {
  N_VProd(y, y, out);
  N_VScale(-1, out, out);
}};
SundialsField three_numbers() {
  SundialsField y{N_VNew_Serial(3, context)};
  for (int i = 0; i < 3; ++i) N_VGetArrayPointer(y.handle())[i] = i + 1;
  return y;
}
void product_of_squares(double, N_Vector y, N_Vector x, N_Vector out) {
  N_VProd(y, x, out);
  N_VScale(-2, out, out);
}
}  // namespace

TEST_CASE("a ManyVector, too") {
  const Grid grid{Grid::Kind::many};
  compare(grid, rodas4, 1e-12);
  compare(grid, tsit5, 1e-12);
}
TEST_CASE("a preconditioner that is exact leaves one iteration a solve") {
  const auto iterations_a_solve = [](bool preconditioned) {
    SundialsField y = three_numbers(), diagonal = y;
    SundialsSolver solver{SUNLinSol_SPGMR(y.handle(), preconditioned ? SUN_PREC_RIGHT : SUN_PREC_NONE, 0, context),
                          product_of_squares};
    int setups = 0;
    if (preconditioned)
      solver.precondition(
          [&](double, N_Vector at, double gamma) {
            N_VScale(2 * gamma, at, diagonal.handle());
            N_VAddConst(diagonal.handle(), 1, diagonal.handle());
            ++setups;
          },
          [&](double, N_Vector r, N_Vector z) { N_VDiv(r, diagonal.handle(), z); });
    PhiStepper stepper{y, squares, rodas4, newton(solver, {.linear_rtol = 1e-10})};
    const RunReport report = integrate(stepper, y, {0.0, 1.0}, fixed(0.1));
    CHECK(report);
    CHECK(setups == (preconditioned ? report.statistics.factorizations : 0));
    for (int i = 0; i < 3; ++i) CHECK(std::abs(N_VGetArrayPointer(y.handle())[i] - (i + 1) / (i + 2.0)) <= 1e-4);
    return static_cast<double>(report.statistics.linear_iterations) / static_cast<double>(report.statistics.solves);
  };
  CHECK(iterations_a_solve(false) == 3);
  CHECK(iterations_a_solve(true) == 1);
}
TEST_CASE("matrices, masses and one process's own vectors") {
  SundialsField y = three_numbers(), z = three_numbers();
  const double m = 3;
  const SUNMatrix W = SUNDenseMatrix(3, 3, context);
  PhiStepper direct{y, squares, rodas4, mass(m),
                    newton(SundialsSolver{SUNLinSol_Dense(y.handle(), W, context), W,
                                          [](double, N_Vector at, SUNMatrix J) {
                                            for (int i = 0; i < 3; ++i)
                                              SM_ELEMENT_D(J, i, i) = -2 * N_VGetArrayPointer(at)[i];
                                          },
                                          m})};
  PhiStepper iterative{
      z, squares, rodas4, mass(m),
      newton(SundialsSolver{SUNLinSol_SPBCGS(z.handle(), SUN_PREC_NONE, 0, context), product_of_squares, m},
             {.linear_rtol = 1e-13})};
  REQUIRE(integrate(direct, y, {0.0, 3.0}, tolerance{.rtol = 1e-8, .atol = 1e-8}));
  REQUIRE(integrate(iterative, z, {0.0, 3.0}, tolerance{.rtol = 1e-8, .atol = 1e-8}));
  for (int i = 0; i < 3; ++i) {
    const double exact = (i + 1) / (1.0 + (i + 1));  // 3 y' = −y² until t = 3
    CHECK(std::abs(N_VGetArrayPointer(y.handle())[i] - exact) <= 1e-8);
    CHECK(std::abs(N_VGetArrayPointer(z.handle())[i] - exact) <= 1e-8);
  }
}
TEST_CASE("an exception or error code inside of a linear solve passes through, and the state keeps every bit") {
  for (const bool throws : {true, false})
    for (int on_rank = 0; on_rank < ranks(); ++on_rank) {
      CAPTURE(throws, on_rank);
      const Grid grid;
      SundialsField y = grid.start();
      const SundialsField before = y;
      int calls = 0;
      const SundialsSolver solver{SUNLinSol_SPGMR(y.handle(), SUN_PREC_NONE, 20, context),
                                  [&](double, N_Vector at, N_Vector x, N_Vector out) -> int {
                                    grid.product(at, x, out);
                                    if (++calls < 9 || rank() != on_rank) return 0;
                                    if (throws) throw std::runtime_error("the product of this rank");
                                    return some_error_code;
                                  }};
      PhiStepper stepper{y, Force{[&](N_Vector x, N_Vector out) { grid.rate(x, out); }}, rodas4, newton(solver)};
      bool thrown = false;
      Outcome outcome = Outcome::success;
      try {
        outcome = stepper.step(y, 0.0, 0.1).outcome();
      } catch (const std::runtime_error&) {
        thrown = true;
      }
      CHECK(thrown == (rank() == on_rank));
      if (!thrown) CHECK(outcome == Outcome::exception_elsewhere);
      CHECK(same_bits_on_all(y, before));
    }
}

namespace {
/// y' = −50 y² from 1 to t = 1, on a vector of n numbers: each ends at 1/51.
SundialsForce steep_squares{[](N_Vector y, N_Vector out) {
  N_VProd(y, y, out);
  N_VScale(-50, out, out);
}};
bool ends_right_or_is_refused(N_Vector vector, bool* is_refused = nullptr) {
  const auto n = static_cast<double>(N_VGetLength(vector));
  N_VConst(1, vector);
  try {
    SundialsField y{vector};
    PhiStepper stepper{y, steep_squares, tsit5};
    const RunReport report = integrate(stepper, y, {0.0, 1.0}, tolerance{.rtol = 1e-6, .atol = 1e-9});
    const double mean = N_VL1Norm(y.handle()) / n;
    UNSCOPED_INFO(describe(report.outcome) << ", " << report.statistics.steps << " steps, mean " << mean);
    return report && std::abs(mean * 51 - 1) <= 1e-4;
  } catch (const std::invalid_argument&) {
    if (is_refused != nullptr) *is_refused = true;
    return true;
  }
}

/// The numbers of MPI's ranks under another name, as users write: SUNDIALS_NVEC_CUSTOM. Behind each rank's own there are as many
/// NaN as all ranks have numbers, so that whoever takes the length of all for that of one reads these.
namespace own_kind {
std::deque<std::vector<double>> memory;
N_Vector clone(N_Vector like) {
  const N_Vector x = N_VCloneEmpty_Parallel(like);
  const auto mine = static_cast<std::size_t>(NV_LOCLENGTH_P(like)), all = static_cast<std::size_t>(N_VGetLength(like));
  memory.emplace_back(mine + all, std::numeric_limits<double>::quiet_NaN());
  NV_DATA_P(x) = memory.back().data();
  NV_OWN_DATA_P(x) = SUNFALSE;
  return x;
}
N_Vector make(sunindextype n) {
  const sunindextype mine = n * (rank() + 1) / ranks() - n * rank() / ranks();
  const N_Vector like = N_VNewEmpty_Parallel(MPI_COMM_WORLD, mine, n, context), x = clone(like);
  N_VDestroy(like);
  x->ops->nvgetvectorid = [](N_Vector) { return SUNDIALS_NVEC_CUSTOM; };
  x->ops->nvclone = clone;
  return x;
}
}  // namespace own_kind

/// What SUNDIALS' vectors on a device are like: all operations on numbers there, and beside them an array of this process that
/// holds those of the last copy, here none.
namespace on_device {
std::map<const void*, std::vector<double>> copies;
realtype* last_copy(N_Vector x) {
  std::vector<double>& its = copies[x->content];
  its.resize(static_cast<std::size_t>(N_VGetLength(x)));
  return its.data();
}
N_Vector make(sunindextype n) {
  const N_Vector x = N_VNew_Serial(n, context);
  x->ops->nvgetvectorid = [](N_Vector) { return SUNDIALS_NVEC_CUDA; };
  x->ops->nvgetdevicearraypointer = x->ops->nvgetarraypointer;
  x->ops->nvgetarraypointer = last_copy;
  return x;
}
}  // namespace on_device
}  // namespace

TEST_CASE("vectors of kinds that SUNDIALS has") {
  CHECK(ends_right_or_is_refused(N_VNew_Serial(1000, context)));
  CHECK(ends_right_or_is_refused(N_VNew_Parallel(MPI_COMM_WORLD, 10, 10 * ranks(), context)));
}
// Whose ranks tell how many numbers they have, and whose don't.
TEST_CASE("a user's own kind of vector, spread over ranks") {
  CHECK(ends_right_or_is_refused(own_kind::make(1000)));
  const N_Vector told = own_kind::make(1000);
  told->ops->nvgetlocallength = [](N_Vector x) { return NV_LOCLENGTH_P(x); };
  bool is_refused = false;
  CHECK(ends_right_or_is_refused(told, &is_refused));
  CHECK_FALSE(is_refused);
}
TEST_CASE("a vector on a device is refused") {
  bool is_refused = false;
  CHECK(ends_right_or_is_refused(on_device::make(1000), &is_refused));
  CHECK(is_refused);
}

/// @file
/// Run time against error on differential-algebraic equations of index 1, beside IDA of SUNDIALS: times to an error of 1e-3, 1e-6,
/// 1e-9 at the end of the run, max |y_i − exact_i| / (|exact_i| + a), interpolated along each method's ladder of tolerances
/// (atol = a·rtol). All have the same Jacobians, dense; set-up included.
///
///     bench_dae [--rounds N] [--quick]
#include <phistep/phistep.hpp>

#include <Eigen/Core>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string>
#include <utility>

#include "../work_precision/measure.hpp"
#include "problems/dae.hpp"

#ifdef BENCH_HAS_IDA
#include <ida/ida.h>
#include <nvector/nvector_serial.h>
#include <sunlinsol/sunlinsol_dense.h>
#include <sunmatrix/sunmatrix_dense.h>
#endif

using namespace work_precision;

namespace {

template <class P>
[[nodiscard]] Eigen::Matrix<double, P::n, P::n> matrix_of_mass() {
  if constexpr (decltype(P::mass())::IsVectorAtCompileTime) return P::mass().asDiagonal();
  else return P::mass();
}

template <class P, class Force>
void phistep_rows(Table& table, const Force& force) {
  const auto row = [&](const char* name, auto scheme) {
    table.add("phistep", name, tolerances(-2, -12), [force, a = table.system.a, scheme](double rtol, Film*) {
      typename P::State y = P::start();
      phistep::PhiStepper stepper{y, force, scheme, phistep::capacity(P::mass())};
      const auto report =
          phistep::integrate(stepper, y, {0.0, P::t1}, phistep::tolerance{.rtol = rtol, .atol = a * rtol});
      if (!report) return Answer{};
      const phistep::Statistics& work = report.statistics;
      return Answer{y, static_cast<std::int64_t>(work.steps), static_cast<std::int64_t>(work.force_calls)};
    });
  };
  row("rodas4", phistep::rodas4);
  row("rodas4p2", phistep::rodas4p2);
  row("rodas5p", phistep::rodas5p);
  row("radau", phistep::radau);
  row("tr_bdf2", phistep::tr_bdf2);
}

#ifdef BENCH_HAS_IDA
/// y' at the start, which IDA wants to be given.
template <class P>
[[nodiscard]] typename P::State start_slope() {
  if constexpr (P::n == 3) return {-0.04, 0.04, 0};
  else if constexpr (P::n == 5) return {0, 0, 0, -P::gravity, 0};
  else return {51.338775, 51.338775, -500.0 / 3, -24.9757667, -24.9757667, -250.0 / 3, -10.00564453, -10.00564453};
}

/// 0 = Ψ(t, y) − M y'
template <class P>
struct Ida {
  using Matrix = Eigen::Matrix<double, P::n, P::n>;
  using Vector = Eigen::Map<Eigen::Vector<double, P::n>>;

  static int residual(double t, N_Vector y, N_Vector slope, N_Vector out, void* mass) {
    P::rate(t, NV_DATA_S(y), NV_DATA_S(out));
    Vector(NV_DATA_S(out)).noalias() -= *static_cast<const Matrix*>(mass) * Vector(NV_DATA_S(slope));
    return 0;
  }
  static int jacobian(double t, double by, N_Vector y, N_Vector, N_Vector, SUNMatrix J, void* mass, N_Vector, N_Vector,
                      N_Vector) {
    Eigen::Map<Matrix> entries(SUNDenseMatrix_Data(J));
    entries = -by * *static_cast<const Matrix*>(mass);
    P::entries(t, NV_DATA_S(y), [&](int i, int j, double x) { entries(i, j) += x; });
    return 0;
  }
  static Answer run(double rtol, double atol) {
    Matrix mass = matrix_of_mass<P>();
    SUNContext context = nullptr;
    SUNContext_Create(nullptr, &context);
    N_Vector y = N_VNew_Serial(P::n, context), slope = N_VNew_Serial(P::n, context);
    Vector(NV_DATA_S(y)) = P::start();
    Vector(NV_DATA_S(slope)) = start_slope<P>();
    void* ida = IDACreate(context);
    SUNMatrix J = SUNDenseMatrix(P::n, P::n, context);
    SUNLinearSolver solver = SUNLinSol_Dense(y, J, context);
    double t = 0;
    const bool done = IDAInit(ida, residual, 0, y, slope) == 0 && IDASStolerances(ida, rtol, atol) == 0 &&
                      IDASetUserData(ida, &mass) == 0 && IDASetMaxNumSteps(ida, 300000) == 0 &&
                      IDASetLinearSolver(ida, solver, J) == 0 && IDASetJacFn(ida, jacobian) == 0 &&
                      IDASetStopTime(ida, P::t1) == 0 && IDASolve(ida, P::t1, &t, y, slope, IDA_NORMAL) >= 0;
    Answer answer;
    long steps = 0, calls = 0;
    IDAGetNumSteps(ida, &steps);
    IDAGetNumResEvals(ida, &calls);
    if (done) answer = {Vector(NV_DATA_S(y)), steps, calls};
    IDAFree(&ida);
    SUNLinSolFree(solver);
    SUNMatDestroy(J);
    N_VDestroy(slope);
    N_VDestroy(y);
    SUNContext_Free(&context);
    return answer;
  }
};
#endif

/// What `System` has to know here: a size, an end and `a`.
template <class P>
struct Shown {
  [[nodiscard]] static Eigen::VectorXd start() { return P::start(); }
  static void rate(double t, const double* y, double* out) { P::rate(t, y, out); }
  static void jacobian(double, const double*, auto&&) {}
};

template <class P, class Force>
void go(const char* title, double a, const Force& force, const Options& options) {
  Table table{title, title, P::end(), system_of(Shape::explicit_, a, P::t1, Shown<P>{})};
  phistep_rows<P>(table, force);
#ifdef BENCH_HAS_IDA
  table.add("IDA", "dense", tolerances(-2, -12), [a](double rtol, Film*) { return Ida<P>::run(rtol, a * rtol); });
#endif
  std::printf("\n%s\n", title);
  print(measure(std::move(table), options));
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  options.films = false;
  for (int i = 1; i < argc; ++i) {
    if (std::strcmp(argv[i], "--rounds") == 0 && i + 1 < argc) options.rounds = std::max(1, std::atoi(argv[++i]));
    else if (std::strcmp(argv[i], "--quick") == 0) options.be_quick();
    else return std::printf("bench_dae [--rounds N] [--quick]\n"), 1;
  }
  using namespace problems;
  go<RobertsonDae>("Robertson, y1 + y2 + y3 = 1", 1e-6, AutonomousDaeForce<RobertsonDae>{}, options);
  go<CartesianPendulum>("pendulum, index 1", 1, AutonomousDaeForce<CartesianPendulum>{}, options);
  go<TransistorAmplifier>("transistor amplifier", 1, DaeForce<TransistorAmplifier>{}, options);
}

// Nonlinear reaction and diffusion on grids (tests/problems/reaction_diffusion.hpp): factorizations and preconditioned Krylov
// methods beside CVODE with GMRES and the same preconditioner, all with the exact Jacobian.
//
//     bench_fields [--only WORDS] [dimension points_a_side]…          default: 2 64 2 256 3 32; WORDS: in the name of a row
//
// Each row runs at several tolerances; printed are the seconds at an error of 1e-3 and of 1e-5 (‖y − y_ref‖/‖y_ref‖, between two
// tolerances on a line in logarithms; "<" where the loosest tolerance is better already), and, at the tolerance next to
// 1e-3, the steps, the linear iterations and the live heap in bytes an unknown. References: Rodas4 at 1e-8.

#include <malloc.h>
#include <phistep/automatic.hpp>
#include <phistep/integrate.hpp>
#include <phistep/krylov.hpp>
#include <phistep/schemes/rosenbrock.hpp>
#include <phistep/sparse.hpp>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "problems/reaction_diffusion.hpp"

#ifdef BENCH_HAS_SUNDIALS
#include <cvode/cvode.h>
#include <nvector/nvector_serial.h>
#include <sunlinsol/sunlinsol_spgmr.h>
#endif

namespace {

using namespace phistep;
using problems::ReactionDiffusion;
using Vec = Eigen::VectorXd;
using Sparse = Eigen::SparseMatrix<double>;
constexpr double end = 0.1;

struct Done {
  Vec y{};
  double seconds = 0;
  std::int64_t steps = 0, iterations = 0;
  double bytes = 0;
  bool good = false;
};
double heap() {
  const auto info = mallinfo2();
  return static_cast<double>(info.uordblks + info.hblkhd);
}
/// CPU seconds of this process: others may be at work on the machine.
double now() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

/// A run by the stepper that make(y, term) gives.
Done run(const ReactionDiffusion& problem, double rtol, auto&& make, bool is_told = false) {
  Done done{.y = problem.start()};
  const double before = heap(), from = now();
  auto stepper = make(done.y, problems::ReactionDiffusionTerm{problem});
  const auto report = integrate(stepper, done.y, {0.0, end}, tolerance{.rtol = rtol, .atol = 1e-2 * rtol});
  done.seconds = now() - from;
  done.bytes = (heap() - before) / static_cast<double>(problem.size());
  done.steps = report.statistics.steps;
  done.iterations = report.statistics.linear_iterations;
  done.good = static_cast<bool>(report);
  if constexpr (requires { stepper.uses(); })
    if (is_told) std::printf("%s", stepper.uses().message().c_str());
  return done;
}
auto by_hand(auto scheme, auto solver) {
  return [=](Vec& y, auto term) { return PhiStepper{y, term, scheme, solver}; };
}
/// The chooser's pick.
auto by_choice(double rtol) {
  return [rtol](Vec& y, auto term) { return AutomaticStepper{y, term, rtol}; };
}

#ifdef BENCH_HAS_SUNDIALS
/// CVODE's view of the problem, and the preconditioner of I − γJ.
template <class P>
struct Rival {
  ReactionDiffusion problem;
  Sparse W;
  std::vector<double*> slots;
  P preconditioner;
  Vec z;
  bool is_analyzed = false;

  struct View {
    Eigen::Map<const Vec> y;
  };
  struct Out {
    Eigen::Map<Vec> rate;
  };
  [[nodiscard]] Eigen::Map<const Vec> map(N_Vector v) const { return {N_VGetArrayPointer(v), problem.size()}; }
  [[nodiscard]] Eigen::Map<Vec> out(N_Vector v) const { return {N_VGetArrayPointer(v), problem.size()}; }

  static int rate(double t, N_Vector y, N_Vector f, void* data) {
    auto& self = *static_cast<Rival*>(data);
    Out to{self.out(f)};
    to.rate.setZero();
    self.problem.add(t, View{self.map(y)}, to);
    return 0;
  }
  /// J v
  static int product(N_Vector v, N_Vector Jv, double t, N_Vector y, N_Vector, void* data, N_Vector) {
    auto& self = *static_cast<Rival*>(data);
    const auto x = self.map(v);
    auto to = self.out(Jv);
    to.setZero();
    self.problem.entries(t, self.map(y), [&](Eigen::Index i, Eigen::Index j, double J) { to[i] += J * x[j]; });
    return 0;
  }
  static int setup(double t, N_Vector y, N_Vector, int, int* fresh, double gamma, void* data) {
    auto& self = *static_cast<Rival*>(data);
    *fresh = 1;
    if (self.slots.empty()) {
      self.W = self.problem.pattern();
      self.W.makeCompressed();
      self.problem.entries(t, self.map(y), [&self](Eigen::Index i, Eigen::Index j, double) {
        self.slots.push_back(&self.W.coeffRef(i, j));
      });
    }
    std::fill(self.W.valuePtr(), self.W.valuePtr() + self.W.nonZeros(), 0.0);
    auto slot = self.slots.begin();
    self.problem.entries(t, self.map(y), [&](Eigen::Index i, Eigen::Index j, double J) {
      **slot++ += (i == j ? 1.0 : 0.0) - gamma * J;
    });
    if (!std::exchange(self.is_analyzed, true)) self.preconditioner.analyzePattern(self.W);
    self.preconditioner.factorize(self.W);
    return self.preconditioner.info() == Eigen::Success ? 0 : 1;
  }
  static int solve(double, N_Vector, N_Vector, N_Vector r, N_Vector z, double, double, int, void* data) {
    auto& self = *static_cast<Rival*>(data);
    self.z = self.map(r);
    if constexpr (requires { self.preconditioner.solve_in_place(self.z); }) self.preconditioner.solve_in_place(self.z);
    else self.z = self.preconditioner.solve(self.z).eval();
    self.out(z) = self.z;
    return 0;
  }
};
template <class P>
Done run_cvode(const ReactionDiffusion& problem, double rtol) {
  Done done{.y = problem.start()};
  const double before = heap(), from = now();
  Rival<P> rival;
  rival.problem = problem;
  SUNContext context = nullptr;
  SUNContext_Create(nullptr, &context);
  N_Vector y = N_VMake_Serial(problem.size(), done.y.data(), context);
  void* cvode = CVodeCreate(CV_BDF, context);
  SUNLinearSolver linear = SUNLinSol_SPGMR(y, SUN_PREC_LEFT, 0, context);
  double t = 0;
  bool good = CVodeInit(cvode, Rival<P>::rate, 0, y) == 0 && CVodeSStolerances(cvode, rtol, 1e-2 * rtol) == 0 &&
              CVodeSetUserData(cvode, &rival) == 0 && CVodeSetLinearSolver(cvode, linear, nullptr) == 0 &&
              CVodeSetJacTimes(cvode, nullptr, Rival<P>::product) == 0 &&
              CVodeSetPreconditioner(cvode, Rival<P>::setup, Rival<P>::solve) == 0 &&
              CVodeSetMaxNumSteps(cvode, 1000000) == 0 && CVodeSetStopTime(cvode, end) == 0;
  while (good && t < end) good = CVode(cvode, end, y, &t, CV_NORMAL) >= 0;
  done.seconds = now() - from;
  done.bytes = (heap() - before) / static_cast<double>(problem.size());
  long steps = 0, iterations = 0;
  CVodeGetNumSteps(cvode, &steps);
  CVodeGetNumLinIters(cvode, &iterations);
  done.steps = steps, done.iterations = iterations, done.good = good;
  CVodeFree(&cvode);
  SUNLinSolFree(linear);
  N_VDestroy(y);
  SUNContext_Free(&context);
  return done;
}
#endif

/// The factors of PreconditionedBySymmetry by themselves.
struct Mic {
  Eisenstat<double> factors;
  bool is_good = false;
  void analyzePattern(const Sparse& W) { is_good = factors.analyze(W); }
  void factorize(const Sparse& W) { is_good = is_good && factors.factorize(W); }
  void solve_in_place(Vec& x) { factors.precondition(x); }
  [[nodiscard]] Eigen::ComputationInfo info() const { return is_good ? Eigen::Success : Eigen::NumericalIssue; }
};

struct Row {
  std::string name;
  std::function<Done(double rtol)> run;
};
std::vector<Row> rows_of(const ReactionDiffusion& p) {
  using Ic = PreconditionedCg<IncompleteCholesky>;
  using Ilu = Eigen::IncompleteLUT<double>;
  std::vector<Row> rows;
  const auto add = [&](const char* name, auto scheme, auto solver) {
    rows.push_back({name, [=](double rtol) { return run(p, rtol, by_hand(scheme, solver)); }});
  };
  rows.push_back({"automatic", [p](double rtol) { return run(p, rtol, by_choice(rtol)); }});
  const bool fits = p.dim == 2 ? p.m <= 256 : p.m <= 20;
  if (fits) add("TR-BDF2, LDLT", tr_bdf2, newton());
  add("TR-BDF2, CG + IC", tr_bdf2, newton<Ic>());
  const auto by_symmetry = newton<PreconditionedBySymmetry>();
  add("TR-BDF2, CG + MIC", tr_bdf2, by_symmetry);
  add("TR-BDF2, CG + diagonal", tr_bdf2, newton<PreconditionedCg<>>());
  add("TR-BDF2, GMRES + MIC", tr_bdf2, newton<PreconditionedGmres<Mic>>());
  if (fits) add("Rodas4, LDLT", rodas4, newton());
  add("Rodas4, CG + IC", rodas4, newton<Ic>());
  add("Rodas4, CG + MIC", rodas4, by_symmetry);
  add("Rodas4, CG + diagonal", rodas4, newton<PreconditionedCg<>>());
  if (p.size() <= 70000) add("Rodas4, GMRES + ILUT", rodas4, newton<PreconditionedGmres<Ilu>>());
  add("Rodas4P2, CG + MIC", rodas4p2, by_symmetry);
  add("Rodas5P, CG + MIC", rodas5p, by_symmetry);
  add("Rodas5P, CG + diagonal", rodas5p, newton<PreconditionedCg<>>());
#ifdef BENCH_HAS_SUNDIALS
  rows.push_back({"CVODE, GMRES + MIC", [p](double rtol) { return run_cvode<Mic>(p, rtol); }});
  rows.push_back({"CVODE, GMRES + IC", [p](double rtol) { return run_cvode<IncompleteCholesky>(p, rtol); }});
  rows.push_back({"CVODE, GMRES + diagonal",
                  [p](double rtol) { return run_cvode<Eigen::DiagonalPreconditioner<double>>(p, rtol); }});
  if (p.size() <= 70000) rows.push_back({"CVODE, GMRES + ILUT", [p](double rtol) { return run_cvode<Ilu>(p, rtol); }});
#endif
  return rows;
}

struct Point {
  double error, seconds;
  Done done;
};
/// Seconds at an error, between the points beside it; negative: the loosest tolerance is better already.
double at(const std::vector<Point>& points, double error) {
  if (points.empty()) return NAN;
  if (points.front().error <= error) return -points.front().seconds;
  for (std::size_t k = 1; k < points.size(); ++k)
    if (points[k].error <= error) {
      const Point &a = points[k - 1], &b = points[k];
      const double x = std::log(a.error / error) / std::log(a.error / b.error);
      return a.seconds * std::pow(b.seconds / a.seconds, x);
    }
  return NAN;
}

void table(const ReactionDiffusion& problem, const std::string& only) {
  const Vec reference = run(problem, 1e-8, by_hand(rodas4, newton<PreconditionedBySymmetry>())).y;
  std::printf("\n%d-D, %td a side, %td unknowns\n%-26s %12s %12s %8s %8s %10s\n", problem.dim, problem.m,
              problem.size(), "", "s at 1e-3", "s at 1e-5", "steps", "linear", "bytes/n");
  static_cast<void>(run(problem, 1e-3, by_choice(1e-3), true));
  for (const Row& row : rows_of(problem)) {
    if (row.name.find(only) == std::string::npos) continue;
    std::vector<Point> points;
    for (double rtol = 0.1; rtol > 5e-8; rtol /= std::sqrt(10.0)) {
      Done done = row.run(rtol);
      const int repeats = done.seconds < 0.1 ? 4 : done.seconds < 1 ? 2 : 0;
      for (int k = 0; k < repeats; ++k) done.seconds = std::min(done.seconds, row.run(rtol).seconds);
      if (!done.good) {
        std::printf("%-26s failed at %.1e\n", row.name.c_str(), rtol);
        continue;
      }
      const double error = (done.y - reference).norm() / reference.norm();
      done.y.resize(0);
      if (points.empty() || error < points.back().error) points.push_back({error, done.seconds, done});
      if (error < 1e-5) break;
    }
    const auto first = std::find_if(points.begin(), points.end(), [](const Point& p) { return p.error <= 1e-3; });
    const Done counts = first == points.end() ? Done{} : first->done;
    const auto text = [](double s) {
      char all[32];
      std::snprintf(all, sizeof all, "%s%.4g", s < 0 ? "<" : "", std::abs(s));
      return std::string(all);
    };
    std::printf("%-26s %12s %12s %8td %8td %10.0f\n", row.name.c_str(), text(at(points, 1e-3)).c_str(),
                text(at(points, 1e-5)).c_str(), counts.steps, counts.iterations, counts.bytes);
    std::fflush(stdout);
  }
}

}  // namespace

int main(int count, char** words) {
  std::vector<ReactionDiffusion> problems;
  const bool has_only = count > 2 && std::string(words[1]) == "--only";
  for (int k = has_only ? 3 : 1; k + 1 < count; k += 2)
    problems.push_back({.m = std::atoi(words[k + 1]), .dim = std::atoi(words[k])});
  if (problems.empty()) problems = {{.m = 64, .dim = 2}, {.m = 256, .dim = 2}, {.m = 32, .dim = 3}};
  for (const auto& problem : problems) table(problem, has_only ? words[2] : "");
}

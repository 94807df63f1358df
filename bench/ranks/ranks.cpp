// A reaction and diffusion on PETSc (examples/ranks/gray_scott_grid.hpp), by phistep's schemes on a Vec and by PETSc's own TS: the
// same grid, rate and Jacobian, KSP and preconditioner. Each method at several tolerances: error against Krylov iterations and
// time, and what an error of 1e-3 and 1e-5 costs.
//
// Run: [mpiexec -n 2] bench_ranks [-n 128] [-t1 200] [-repeats 3] [-ksp_rtol 1e-5: of TS] [-ksp_type …] [-pc_type …]
#include <petscts.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <functional>
#include <optional>
#include <phistep/petsc.hpp>
#include <string>
#include <utility>
#include <vector>

#include "../../examples/ranks/gray_scott_grid.hpp"
#include "../equal_error.hpp"

using gray_scott::Grid;
using phistep::check_petsc;

namespace {

struct Done {
  Vec y = nullptr;
  long long steps = 0, iterations = 0;
};
struct Method {
  std::string name;
  std::function<Done(double rtol)> run;
};

template <class Scheme>
Method ours(const char* name, Scheme scheme, const Grid& grid, double t1) {
  return {std::string("phistep ") + name, [=, &grid](double rtol) {
            phistep::PetscField y{grid.start()};
            const phistep::PetscForce force{[&grid](Vec state, Vec rate) { grid.rate(state, rate); }};
            phistep::PhiStepper stepper{y, force, scheme, phistep::newton(grid.solver())};
            const phistep::RunReport report =
                phistep::integrate(stepper, y, {0.0, t1}, phistep::tolerance{.rtol = rtol, .atol = rtol});
            Done done{nullptr, report.statistics.steps, report.statistics.linear_iterations};
            check_petsc(VecDuplicate(y.handle(), &done.y));
            check_petsc(VecCopy(y.handle(), done.y));
            if (!report) done.steps = -1;
            return done;
          }};
}

/// TS in its implicit form, F(t, y, y') = y' − Ψ(y) = 0, which all of its implicit methods take.
Method petsc(const char* name, TSType type, const char* kind, const Grid& grid, double t1) {
  return {
      std::string("TS ") + name, [=, &grid](double rtol) {
        TS ts = nullptr;
        check_petsc(TSCreate(PETSC_COMM_WORLD, &ts));
        Mat J = grid.matrix();
        check_petsc(TSSetIFunction(
            ts, nullptr,
            [](TS, PetscReal, Vec y, Vec slope, Vec residual, void* of) -> PetscErrorCode {
              static_cast<const Grid*>(of)->rate(y, residual);
              return VecAYPX(residual, -1, slope);
            },
            const_cast<Grid*>(&grid)));
        check_petsc(TSSetIJacobian(
            ts, J, J,
            [](TS, PetscReal, Vec y, Vec, PetscReal shift, Mat, Mat W, void* of) -> PetscErrorCode {
              static_cast<const Grid*>(of)->jacobian(y, W);
              check_petsc(MatScale(W, -1));
              return MatShift(W, shift);
            },
            const_cast<Grid*>(&grid)));
        check_petsc(TSSetType(ts, type));
        if (std::string(type) == TSROSW) check_petsc(TSRosWSetType(ts, kind));
        if (std::string(type) == TSARKIMEX) {
          check_petsc(TSARKIMEXSetType(ts, kind));
          check_petsc(TSARKIMEXSetFullyImplicit(ts, PETSC_TRUE));
        }
        if (std::string(type) == TSBDF) check_petsc(TSBDFSetOrder(ts, std::atoi(kind)));
        if (std::string(type) == TSTHETA) {  // the trapezoidal rule, and the adaptivity that it doesn't have by default
          check_petsc(TSThetaSetTheta(ts, 0.5));
          check_petsc(TSThetaSetEndpoint(ts, PETSC_TRUE));
          TSAdapt adapt = nullptr;
          check_petsc(TSGetAdapt(ts, &adapt));
          check_petsc(TSAdaptSetType(adapt, TSADAPTBASIC));
        }
        check_petsc(TSSetTolerances(ts, rtol, nullptr, rtol, nullptr));
        check_petsc(TSSetTimeStep(ts, 0.1));
        check_petsc(TSSetMaxTime(ts, t1));
        check_petsc(TSSetMaxSteps(ts, 1000000));
        check_petsc(TSSetMaxSNESFailures(ts, -1));  // a step whose Newton fails is tried again, as ours is
        check_petsc(TSSetExactFinalTime(ts, TS_EXACTFINALTIME_MATCHSTEP));
        check_petsc(TSSetFromOptions(ts));
        Done done{grid.start()};
        check_petsc(TSSolve(ts, done.y));
        TSConvergedReason reason{};
        check_petsc(TSGetConvergedReason(ts, &reason));
        PetscInt steps = 0, iterations = 0;
        check_petsc(TSGetStepNumber(ts, &steps));
        check_petsc(TSGetKSPIterations(ts, &iterations));
        done.steps = reason > 0 ? steps : -1, done.iterations = iterations;
        check_petsc(MatDestroy(&J));
        check_petsc(TSDestroy(&ts));
        return done;
      }};
}

/// max |a − b|
double apart(Vec a, Vec b) {
  Vec difference = nullptr;
  double size = 0;
  check_petsc(VecDuplicate(a, &difference));
  check_petsc(VecWAXPY(difference, -1, a, b));
  check_petsc(VecNorm(difference, NORM_INFINITY, &size));
  check_petsc(VecDestroy(&difference));
  return size;
}

void compare() {
  PetscInt n = 128, repeats = 3;
  double t1 = 200;
  check_petsc(PetscOptionsGetInt(nullptr, nullptr, "-n", &n, nullptr));
  check_petsc(PetscOptionsGetInt(nullptr, nullptr, "-repeats", &repeats, nullptr));
  check_petsc(PetscOptionsGetReal(nullptr, nullptr, "-t1", &t1, nullptr));
  const Grid grid(n);
  const std::vector<Method> methods{ours("rodas4p2", phistep::rodas4p2, grid, t1),
                                    ours("rodas4", phistep::rodas4, grid, t1),
                                    ours("tr_bdf2", phistep::tr_bdf2, grid, t1),
                                    ours("trapezoidal", phistep::trapezoidal, grid, t1),
                                    petsc("ROSW ra34pw2", TSROSW, TSROSWRA34PW2, grid, t1),
                                    petsc("ROSW rodas3", TSROSW, TSROSWRODAS3, grid, t1),
                                    petsc("ROSW veldd4", TSROSW, TSROSWVELDD4, grid, t1),
                                    petsc("ROSW grk4t", TSROSW, TSROSWGRK4T, grid, t1),
                                    petsc("ARKIMEX 3", TSARKIMEX, TSARKIMEX3, grid, t1),
                                    petsc("ARKIMEX 4", TSARKIMEX, TSARKIMEX4, grid, t1),
                                    petsc("BDF 2", TSBDF, "2", grid, t1),
                                    petsc("BDF 4", TSBDF, "4", grid, t1),
                                    petsc("THETA 0.5", TSTHETA, "", grid, t1)};
  // Two references that share no scheme: what they agree to is what errors can be told from.
  Done reference = ours("rodas5p", phistep::rodas5p, grid, t1).run(1e-10);
  Done other = ours("rodas4p2", phistep::rodas4p2, grid, t1).run(1e-9);
  check_petsc(PetscPrintf(PETSC_COMM_WORLD, "%d x %d points to t = %g; references apart by %.1e\n", int(n), int(n), t1,
                          apart(reference.y, other.y)));
  check_petsc(PetscPrintf(PETSC_COMM_WORLD, "%-20s %8s %9s %7s %11s %9s\n", "method", "rtol", "error", "steps",
                          "iterations", "ms"));
  struct Cost {
    std::string name;
    std::vector<std::pair<double, double>> times, iterations;
  };
  std::vector<Cost> costs;
  for (const Method& method : methods) {
    Cost cost{method.name, {}, {}};
    for (const double rtol : {1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7}) {
      std::vector<double> ms;
      Done done;
      for (PetscInt k = 0; k < repeats; ++k) {
        if (done.y != nullptr) check_petsc(VecDestroy(&done.y));
        MPI_Barrier(PETSC_COMM_WORLD);
        const auto begin = std::chrono::steady_clock::now();
        done = method.run(rtol);
        MPI_Barrier(PETSC_COMM_WORLD);
        ms.push_back(std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin).count());
      }
      std::nth_element(ms.begin(), ms.begin() + static_cast<std::ptrdiff_t>(ms.size() / 2), ms.end());
      const double error = apart(done.y, reference.y), median = ms[ms.size() / 2];
      if (done.steps >= 0) {
        cost.times.emplace_back(median, error);
        cost.iterations.emplace_back(static_cast<double>(done.iterations), error);
      }
      check_petsc(PetscPrintf(PETSC_COMM_WORLD, "%-20s %8.0e %9.1e %7lld %11lld %9.1f\n", method.name.c_str(), rtol,
                              error, done.steps, done.iterations, median));
      check_petsc(VecDestroy(&done.y));
    }
    costs.push_back(std::move(cost));
  }
  for (const double wanted : {1e-3, 1e-5}) {
    check_petsc(PetscPrintf(PETSC_COMM_WORLD, "\nto an error of %.0e %11s %9s\n", wanted, "iterations", "ms"));
    for (const Cost& cost : costs) {
      const auto ms = bench::time_to_error(wanted, cost.times), count = bench::time_to_error(wanted, cost.iterations);
      if (ms && count)
        check_petsc(PetscPrintf(PETSC_COMM_WORLD, "%-20s %11.0f %9.1f\n", cost.name.c_str(), *count, *ms));
      else check_petsc(PetscPrintf(PETSC_COMM_WORLD, "%-20s %11s %9s\n", cost.name.c_str(), "-", "-"));
    }
  }
  check_petsc(VecDestroy(&reference.y));
  check_petsc(VecDestroy(&other.y));
}

}  // namespace

int main(int argc, char** argv) {
  check_petsc(PetscInitialize(&argc, &argv, nullptr, nullptr));
  compare();
  return PetscFinalize();
}

// Every way to solve, at the extremes: ratios of masses and of stiffnesses, tangents that are indefinite, and every scheme in
// units of 2^±300. The quick part: stress_list.test.cpp, units.test.cpp.
#include <phistep/krylov.hpp>
#include <phistep/sparse.hpp>

#include <Eigen/Eigenvalues>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "accuracy/units.hpp"
#include "support/figures.hpp"

using namespace phistep;
using namespace in_units;
using Mat = Eigen::MatrixXd;
using Sparse = Eigen::SparseMatrix<double>;

namespace {

constexpr double u = std::numeric_limits<double>::epsilon();

using Force = std::function<Vec(const Vec&, const Vec&, double)>;
using Field = std::function<Vec(const Vec&)>;

/// A chain of masses: springs k_i to the one before, the first to a wall.
Mat chain_matrix(const Vec& k) {
  Mat K = Mat::Zero(k.size(), k.size());
  for (Eigen::Index i = 0; i < k.size(); ++i) {
    K(i, i) -= k[i];
    if (i > 0) K(i - 1, i - 1) -= k[i], K(i, i - 1) = K(i - 1, i) = k[i];
  }
  return K;
}

/// What three steps of backward Euler make of a linear chain, beside the truth in long double.
struct Judged {
  bool solved = false;
  double error = 0;     ///< of v, beside what r could move by
  double residual = 0;  ///< of the last step's equation, relative to its terms
};
template <class Stepper>
Judged judge(Stepper&& stepper, Motion<Vec> y, const Mat& K, const Vec& m, double h) {
  using Wide = Eigen::Matrix<long double, Eigen::Dynamic, Eigen::Dynamic>;
  const Wide A = K.cast<long double>(), M = m.cast<long double>().asDiagonal();
  Judged all;
  const Motion<Vec> before = y;
  if (!stepper.step(y, 0, h)) return all;
  all.solved = true;
  const long double H = h;
  const Wide r = before.r.cast<long double>(), v = before.v.cast<long double>();
  const Wide exact = (M - H * H * A).fullPivLu().solve(M * v + H * (A * r));
  const double size = exact.cast<double>().cwiseAbs().maxCoeff() + before.r.cwiseAbs().maxCoeff() / h;
  all.error = (y.v - exact.cast<double>()).cwiseAbs().maxCoeff() / size;
  const Vec force = K * y.r, sizes = K.cwiseAbs() * (before.r.cwiseAbs() + h * y.v.cwiseAbs());
  const Vec left = m.cwiseProduct(y.v - before.v) - h * force;
  all.residual = left.norm() / (m.cwiseProduct(y.v.cwiseAbs() + before.v.cwiseAbs()) + h * sizes).norm();
  return all;
}

/// f(name, Judged) for every solver.
void each_solver(const Mat& K, const Vec& m, double h, auto&& f) {
  const Eigen::Index n = K.cols();
  const Motion<Vec> y{Vec::LinSpaced(n, 0.01, 0.1), 0.1 * Vec::Unit(n, 0)};
  const Sparse S = K.sparseView();
  const Field field = [&K](const Vec& r) -> Vec { return K * r; };
  const auto masses = mass(m);
  f("dense LU, affine", judge(PhiStepper{y, linear(K), backward_euler, masses}, y, K, m, h));
  f("dense LU, differences", judge(PhiStepper{y, field, backward_euler, masses}, y, K, m, h));
  f("banded LU", judge(PhiStepper{y, banded(field, 1, 1), backward_euler, masses}, y, K, m, h));
  f("sparse LU", judge(PhiStepper{y, linear(S), backward_euler, masses}, y, K, m, h));
  f("sparse LDLT", judge(PhiStepper{y, symmetric(linear(S)), backward_euler, masses}, y, K, m, h));
  f("Eigen's CG", judge(PhiStepper{y, linear(S), backward_euler, masses,
                                   newton<Eigen::ConjugateGradient<Sparse, Eigen::Lower | Eigen::Upper>>()},
                        y, K, m, h));
  f("BiCGSTAB on products", judge(PhiStepper{y, field, backward_euler, masses, newton<MatrixFree<>>()}, y, K, m, h));
  f("fixed point", judge(PhiStepper{y, field, backward_euler, masses, fixed_point()}, y, K, m, h));
}

}  // namespace

TEST_CASE("mass ratio 1e12: every solver") {
  double worst = 0;
  int direct_failures = 0, refused = 0, all = 0;
  for (const double h : {1e-3, 1e-2, 1.0, 10.0, 1e3})
    for (const double k : {1.0, 1e12}) {
      Vec m(10);
      for (int i = 0; i < 10; ++i) m[i] = i % 3 == 1 ? 1e12 : 1;
      each_solver(chain_matrix(k * Vec::Ones(10)), m, h, [&](const std::string& name, const Judged& judged) {
        ++all;
        if (judged.solved) worst = std::max(worst, judged.error);
        else if (name.find('L') != std::string::npos && name != "BiCGSTAB on products") ++direct_failures;
        refused += judged.solved ? 0 : 1;
        CAPTURE(name, h, k, judged.error);
        CHECK((!judged.solved || judged.error <= 1e-13));
      });
    }
  // Heavy and light in one matrix cost no digits; alternating stiff chains cost those of their condition.
  figures::at_most(1e-13, worst, "mass ratio 1e12: right, or an outcome", "nine solvers, largest error of v");
  figures::at_most(0, direct_failures, "mass ratio 1e12: LU and LDLT always solve", "failures");
  figures::told(refused, "mass ratio 1e12: right, or an outcome", "outcomes of " + std::to_string(all));
}

TEST_CASE("stiffness ratios to 1e16 in one chain: every solver") {
  for (const double ratio : {1e4, 1e8, 1e12, 1e16}) {
    double error = 0, residual = 0;
    int refused = 0, all = 0;
    for (const bool sorted : {true, false})
      for (const double h : {1e-3, 1.0, 100.0}) {
        Vec k(10);
        for (int i = 0; i < 10; ++i) k[i] = std::pow(ratio, (sorted ? i : (7 * i) % 10) / 9.0);
        const Mat K = chain_matrix(k);
        // κ of I − h²K
        const double condition = 1 + h * h * 4 * k.maxCoeff();
        each_solver(K, Vec::Ones(10), h, [&](const std::string& name, const Judged& judged) {
          ++all, refused += judged.solved ? 0 : 1;
          if (!judged.solved) return;
          CAPTURE(name, h, ratio, sorted, judged.error, judged.residual);
          error = std::max(error, judged.error / (condition * u));
          residual = std::max(residual, judged.residual);
        });
      }
    const std::string of = "ratio " + figures::text(ratio);
    figures::at_most(10, error, "stiffness ratios: error <= 10 kappa u, or an outcome", of + ", error/(kappa u)");
    figures::at_most(1e-12, residual, "stiffness ratios: the equation is solved, or an outcome", of + ", residual");
    figures::told(refused, "stiffness ratios: the equation is solved, or an outcome",
                  of + ", outcomes of " + std::to_string(all));
  }
}

TEST_CASE("stiffness ratio 1e16 side by side: every digit, stiff schemes") {
  // y' = −λ(y − 1), λ = 1 … 1e16: y(1) = 1 + (y0 − 1) e^{−λ}.
  const auto run = [](const std::string& name, auto scheme, double rtol) {
    Vec lambda(5);
    lambda << 1, 1e4, 1e8, 1e12, 1e16;
    Vec y = Vec::Constant(5, 3.0);
    PhiStepper stepper{
        y, Field{[lambda](const Vec& x) -> Vec { return -lambda.cwiseProduct((x.array() - 1).matrix()); }}, scheme};
    const RunReport report = integrate(stepper, y, {0, 1}, tolerance{.rtol = rtol, .max_steps = 1000000});
    const double error = std::max(std::abs(y[0] - 1 - 2 * std::exp(-1.0)), (y.tail(4).array() - 1).abs().maxCoeff());
    figures::at_most(100 * rtol, report ? error : 1, "stiffness ratio 1e16 in one state: the run's accuracy", name);
  };
  run("backward Euler", backward_euler, 1e-3);
  run("TR-BDF2", tr_bdf2, 1e-5);
  run("Rodas4", rodas4, 1e-6);
  run("Radau", radau, 1e-8);
  run("Rodas5P", rodas5p, 1e-7);
}

TEST_CASE("indefinite tangents: right, or an outcome, by every solver") {
  // An inverted pendulum on a chain: Ψ = K r with one eigenvalue above zero.
  double worst = 0;
  int refused = 0, all = 0;
  for (const double h : {0.1, 0.9, 1.1, 3.0, 30.0, 1e4}) {
    Mat K = chain_matrix(Vec::Ones(8));
    K(3, 3) += 6;
    const double top = Eigen::SelfAdjointEigenSolver<Mat>(K).eigenvalues().maxCoeff();
    REQUIRE(top > 1);
    each_solver(K, Vec::Ones(8), h, [&](const std::string& name, const Judged& judged) {
      ++all, refused += judged.solved ? 0 : 1;
      CAPTURE(name, h, judged.error);
      if (judged.solved) worst = std::max(worst, judged.error);
    });
  }
  figures::at_most(1e-13, worst, "indefinite tangents: right, or an outcome", "nine solvers, largest error of v");
  figures::told(refused, "indefinite tangents: right, or an outcome", "outcomes of " + std::to_string(all));
}

// ---- units of 2^±300 -------------------------------------------------------------------------------------------------

namespace {

const std::vector<Units> far{{300, 0, 0},       {-300, 0, 0},     {0, 300, 0},    {0, -300, 0},
                             {0, 0, 300},       {0, 0, -300},     {300, 300, 0},  {-300, -300, 0},
                             {400, -100, -150}, {-400, 100, 150}, {300, 0, -220}, {-300, 0, 220}};
const auto chain = [](const Units& units) {
  return Force{[f = Chain{units}](const Vec& r, const Vec& v, double t) -> Vec { return f.all(r, v, t); }};
};
const auto elastic = [](const Units& units) {
  return Field{[f = Chain{units}](const Vec& r) -> Vec { return f.elastic(r); }};
};
const auto to_rounding = [](const Units&) { return newton(); };

/// How many systems of units change a bit or a count.
int differing(auto&& run) {
  const Result first = run(Units{});
  int all = 0;
  for (const Units& units : far) {
    const Result other = run(units);
    all += other.outcome == first.outcome && other.counts == first.counts && other.numbers == first.numbers ? 0 : 1;
  }
  return all;
}
void check_motion(const std::string& name, auto scheme, auto&& force, auto&& solver, double dt, int n, double rtol) {
  const int all = differing([&](const Units& units) {
    Scene scene{units};
    PhiStepper stepper{scene.y, force(units), scheme, mass(scene.masses), solver(units)};
    Result result = march(stepper, scene, dt, n);
    const auto report = integrate(stepper, scene.y, {0.0, units.of(1, 0, 0, 1)}, tolerance{.rtol = rtol});
    return Result{result.outcome + ", " + describe(report.outcome), scene.numbers(), stepper.statistics()};
  });
  figures::at_most(0, all, "units of 2^-400 ... 2^400 change no bit and no count", name + ", of 12");
}

}  // namespace

TEST_CASE("units of 2^300: every scheme") {
  check_motion("velocity Verlet", velocity_verlet, elastic, to_rounding, 0.02, 50, 1e-3);
  check_motion("trapezoidal", trapezoidal, chain, to_rounding, 0.1, 20, 1e-4);
  check_motion("midpoint", midpoint, elastic, to_rounding, 0.1, 20, 1e-3);
  check_motion(
      "fixed point", trapezoidal, chain, [](const Units&) { return fixed_point(); }, 0.05, 20, 1e-4);
  check_motion("TR-BDF2", tr_bdf2, chain, to_rounding, 0.2, 20, 1e-4);
  check_motion("Rodas4", rodas4, chain, to_rounding, 0.1, 20, 1e-6);
  check_motion("Radau", radau, chain, to_rounding, 0.1, 20, 1e-8);
  figures::progress("half of the schemes done");
  const auto damped = [](const Units&) { return newton({.line_search = true}); };
  check_motion("Newton, damped", backward_euler, chain, damped, 2, 5, 1e-2);
  const int by_cg = differing([](const Units& units) {
    Scene scene{units};
    Mat K = Mat::Zero(5, 5);
    for (int i = 0; i < 5; ++i) {
      K(i, i) = units.of(-81.3, 0, 1, -2);
      if (i > 0) K(i, i - 1) = K(i - 1, i) = units.of(40.1, 0, 1, -2);
    }
    PhiStepper stepper{scene.y, linear(Sparse(K.sparseView())), backward_euler, mass(scene.masses),
                       newton<Eigen::ConjugateGradient<Sparse, Eigen::Lower | Eigen::Upper>>()};
    return march(stepper, scene, 0.3, 20);
  });
  figures::at_most(0, by_cg, "units of 2^-400 ... 2^400 change no bit and no count",
                   "Eigen's conjugate gradients, of 12");
  check_motion("tsit5", tsit5, chain, to_rounding, 0.02, 20, 1e-5);
  check_motion("dop853", dop853, chain, to_rounding, 0.02, 20, 1e-8);
  check_motion("RKN 12(10)", rkn1210, elastic, to_rounding, 0.02, 20, 1e-8);
}

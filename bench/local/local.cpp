// Implicit steps of particles that don't act on each other: anharmonic wells with drag, trapezoidal rule, 10⁴ particles.
// Both sides do Newton particle by particle with a fresh Jacobian in each particle's first iteration, the same LU, and
// the same test of convergence (to rounding). What differs: the hand loop keeps no promise about failures or edits, and
// knows its force. Number of Newton iterations a particle-step is printed for both.
#include <benchmark/benchmark.h>
#include <phistep/phistep.hpp>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <random>

namespace {

using Eigen::Matrix3d;
using Eigen::Matrix3Xd;
using Eigen::Vector3d;
using State = phistep::Motion<Matrix3Xd>;

constexpr double k = 1, q = 0.3, c = 0.2, dt = 0.1;

struct Well {
  Vector3d operator()(const Vector3d& r, const Vector3d& v) const { return -(k + q * r.squaredNorm()) * r - c * v; }
  [[nodiscard]] phistep::MotionJacobian<Matrix3d> jacobian(const Vector3d& r, const Vector3d& /*v*/) const {
    const Matrix3d I = Matrix3d::Identity();
    return {-(k + q * r.squaredNorm()) * I - 2 * q * r * r.transpose(), -c * I};
  }
};

State start(Eigen::Index n) {
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  State y{Matrix3Xd(3, n), Matrix3Xd(3, n)};
  for (auto& x : y.r.reshaped()) x = normal(random);
  for (auto& x : y.v.reshaped()) x = normal(random);
  return y;
}

/// v⁺ = v + ½Δt (Ψ + Ψ⁺), r⁺ = r + ½Δt (v + v⁺) by hand. Returns the Newton iterations of all particles.
long hand_step(State& y) {
  const Well well;
  const double h = dt / 2;
  long iterations = 0;
  phistep::DenseLu<double, 3> lu;
  for (Eigen::Index i = 0; i < y.r.cols(); ++i) {
    const Vector3d r = y.r.col(i), v = y.v.col(i);
    const Vector3d bv = v + h * well(r, v), br = r + h * v;
    Vector3d w = v - bv;
    double last = 0;
    bool factorized = false;
    for (int m = 0; m < 25; ++m) {
      const Vector3d rn = br + h * (bv + w), vn = bv + w;
      Vector3d delta = h * well(rn, vn) - w;
      if (!factorized) {
        const auto J = well.jacobian(rn, vn);
        lu.matrix() = Matrix3d::Identity() - h * J.C - h * h * J.K;
        if (!lu.factorize()) std::abort();
        factorized = true;
      }
      lu.solve_in_place(delta);
      w += delta;
      ++iterations;
      const double size = delta.cwiseAbs().maxCoeff() / (bv + w).cwiseAbs().maxCoeff();
      const double theta = last > 0 ? size / last : 1;
      last = size;
      if (size == 0 || (theta < 1 && theta / (1 - theta) * size <= 2.2e-16)) break;
      if (theta > 0.3 && size <= 3.7e-11 && m > 0) break;
      if (theta > 0.05 && m > 0) factorized = false;
    }
    y.v.col(i) = bv + w;
    y.r.col(i) = br + h * (bv + w);
  }
  return iterations;
}

void hand(benchmark::State& run) {
  State y = start(10000);
  long iterations = 0;
  for (auto _ : run) iterations += hand_step(y);
  run.counters["iterations"] = static_cast<double>(iterations) / static_cast<double>(run.iterations() * y.r.cols());
  run.counters["ns"] = benchmark::Counter(static_cast<double>(run.iterations() * y.r.cols()) * 1e-9,
                                          benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
}
BENCHMARK(hand)->Iterations(200);  // the same motion for all: drag makes it easier with time

void ours(benchmark::State& run) {
  State y = start(10000);
  phistep::PhiStepper stepper{y, phistep::local<3>(Well{}), phistep::trapezoidal};
  for (auto _ : run)
    if (!stepper.step(y, 0, dt)) std::abort();
  run.counters["iterations"] =
      static_cast<double>(stepper.statistics().active_iterations) / static_cast<double>(run.iterations() * y.r.cols());
  run.counters["ns"] = benchmark::Counter(static_cast<double>(run.iterations() * y.r.cols()) * 1e-9,
                                          benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
}
BENCHMARK(ours)->Iterations(200);

struct Unmarked : phistep::Local<3, Well> {
  template <int>
  static constexpr bool is_particlewise = false;
  Unmarked() : Local{Well{}} {}
};
/// The same Newton iteration for all at once: as many iterations for each as the hardest needs.
void together(benchmark::State& run) {
  State y = start(10000);
  phistep::PhiStepper stepper{y, Unmarked{}, phistep::trapezoidal};
  for (auto _ : run)
    if (!stepper.step(y, 0, dt)) std::abort();
  run.counters["iterations"] =
      static_cast<double>(stepper.statistics().iterations) / static_cast<double>(run.iterations());
  run.counters["ns"] = benchmark::Counter(static_cast<double>(run.iterations() * y.r.cols()) * 1e-9,
                                          benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
}
BENCHMARK(together)->Iterations(200);

}  // namespace

int main(int argc, char** argv) {
  State a = start(100), b = a;
  phistep::PhiStepper stepper{b, phistep::local<3>(Well{}), phistep::trapezoidal};
  for (int i = 0; i < 50; ++i) {
    hand_step(a);
    if (!stepper.step(b, 0, dt)) return 1;
  }
  if (!((a.r - b.r).norm() <= 1e-12 * a.r.norm())) {
    std::fprintf(stderr, "the two answers differ by %g\n", (a.r - b.r).norm());
    return 1;
  }
  std::printf("compiler %s; ns: for one particle and step; iterations: Newton's, for one particle and step\n",
              __VERSION__);
  benchmark::Initialize(&argc, argv);
  benchmark::RunSpecifiedBenchmarks();
}

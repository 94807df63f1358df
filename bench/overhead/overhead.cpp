/// @file
/// The bare update: what a step costs beside the force. The force array is given, so that nothing but the update is timed.
///
/// Rows: the best hand loops (unguarded in place; guarded: nothing lost on failure), phistep, Boost.Odeint. Answers are
/// compared before anything is timed. Rows of one size are interleaved at random and repeated; read the medians.
///     bench_overhead [--benchmark_filter=…]
#include <benchmark/benchmark.h>

#include <phistep/phistep.hpp>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <string>
#include <vector>

#include "hand.hpp"
#ifdef BENCH_HAS_ODEINT
#include "rivals.hpp"
#endif

namespace {
using Eigen::VectorXd;
constexpr double mass = 2.0, dt = 1e-6;

struct Scene {
  VectorXd r, v, f;
  explicit Scene(Eigen::Index particles)
      : r(VectorXd::LinSpaced(3 * particles, -1, 1)), v(r.array().cos()), f(r.array().sin()) {}
};

void per_particle(benchmark::State& run, Eigen::Index particles) {
  run.counters["ns/particle"] =
      benchmark::Counter(static_cast<double>(particles) * 1e-9 * static_cast<double>(run.iterations()),
                         benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
}

/// The force array, given: calling it costs nothing, and it says so.
struct Given {
  const VectorXd* f;
  static constexpr bool is_lookup = true;
  const VectorXd& operator()(const VectorXd&) const { return *f; }
};

/// A step function that owns what it steps.
template <class Make>
void add(const std::string& name, Eigen::Index particles, Make make) {
  benchmark::RegisterBenchmark((name + "/N=" + std::to_string(particles)).c_str(), [=](benchmark::State& run) {
    const Scene scene(particles);
    auto step = make(scene);
    for (int warm_up = 0; warm_up < 3; ++warm_up) step();  // the first touch of a work array costs more than a step
    for (auto _ : run) {
      step();
      benchmark::ClobberMemory();
    }
    per_particle(run, particles);
  });
}

template <class Scheme>
auto phistep_row(Scheme scheme) {
  return [scheme](const Scene& s) {
    auto force = std::make_shared<VectorXd>(s.f);
    phistep::Motion state{s.r, s.v};
    phistep::PhiStepper stepper{state, Given{force.get()}, scheme, phistep::mass(mass)};
    return [state, stepper, force]() mutable {
      if (!stepper.step(state, 0.0, dt)) std::abort();
    };
  };
}

template <class Loop>
auto in_place(Loop loop) {
  return [loop](const Scene& s) { return [loop, r = s.r, v = s.v, f = s.f]() mutable { loop(r, v, f, mass, dt); }; };
}
template <class Loop>
auto beside(Loop loop) {
  return [loop](const Scene& s) {
    return [loop, r = s.r, v = s.v, f = s.f, next = overhead::Beside{s.r, s.v}]() mutable {
      if (!loop(r, v, f, mass, dt, next)) std::abort();
    };
  };
}

/// Every row must give the same motion before it may be timed.
void compare() {
  const Scene s(1000);
  // Ten steps of three roundings each, of numbers up to 1: 30 u.
  constexpr double allowed = 30 * 1.2e-16;
  const auto differ = [&](const VectorXd& r, const VectorXd& v, const VectorXd& r1, const VectorXd& v1) {
    return !((r - r1).cwiseAbs().maxCoeff() <= allowed && (v - v1).cwiseAbs().maxCoeff() <= allowed);
  };
  bool wrong = false;
  const auto check = [&](auto scheme, auto loop, auto guarded) {
    VectorXd r = s.r, v = s.v, r1 = s.r, v1 = s.v;
    overhead::Beside next{s.r, s.v};
    phistep::Motion state{s.r, s.v};
    phistep::PhiStepper stepper{state, Given{&s.f}, scheme, phistep::mass(mass)};
    for (int n = 0; n < 10; ++n) {
      loop(r, v, s.f, mass, dt);
      wrong |= !guarded(r1, v1, s.f, mass, dt, next);
      wrong |= !stepper.step(state, 0.0, dt);
    }
    wrong |= differ(state.r, state.v, r, v) || differ(state.r, state.v, r1, v1);
  };
  check(phistep::forward_euler, overhead::hand_euler, overhead::hand_euler_guarded);
  check(phistep::velocity_verlet, overhead::hand_verlet, overhead::hand_verlet_guarded);
#ifdef BENCH_HAS_ODEINT
  const auto rival = [&](auto odeint, auto loop) {
    VectorXd r = s.r, v = s.v;
    for (int n = 0; n < 10; ++n) {
      loop(r, v, s.f, mass, dt);
      odeint->step(dt);
    }
    wrong |= differ(odeint->positions(), odeint->velocities(), r, v);
  };
  rival(overhead::odeint_euler_eigen(s.r, s.v, s.f, mass), overhead::hand_euler);
  rival(overhead::odeint_verlet_eigen(s.r, s.v, s.f, mass), overhead::hand_verlet);
#endif
  if (wrong) {
    std::fputs("bench_overhead: the rows disagree; nothing was timed\n", stderr);
    std::exit(1);
  }
}

constexpr long small_steps = 100000;
template <class Run>
void add_small(const char* name, Run loop) {
  benchmark::RegisterBenchmark(name, [loop](benchmark::State& run) {
    for (auto _ : run) benchmark::DoNotOptimize(loop());
    run.counters["ns/step"] =
        benchmark::Counter(static_cast<double>(small_steps) * 1e-9 * static_cast<double>(run.iterations()),
                           benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
  });
}
const Eigen::Vector3d lorenz_start{10, 1, 1};
template <class State, class Force, class Scheme>
State run_small(State y, Force force, Scheme scheme, double h) {
  phistep::PhiStepper stepper{y, force, scheme};
  for (long n = 0; n < small_steps; ++n)
    if (!stepper.step(y, static_cast<double>(n) * h, h)) std::abort();
  return y;
}
}  // namespace

int main(int argc, char** argv) {
  compare();
  for (const Eigen::Index n : {1000, 10000, 1000000}) {
    add("euler/hand_unguarded", n, in_place(overhead::hand_euler));
    add("euler/eigen_unguarded", n, in_place(overhead::eigen_euler));
    add("euler/hand_guarded", n, beside(overhead::hand_euler_guarded));
    if (n >= 1000000) add("euler/hand_guarded_streaming", n, beside(overhead::hand_euler_guarded_streaming));
    add("euler/phistep", n, phistep_row(phistep::forward_euler));
    add("verlet/hand_unguarded", n, in_place(overhead::hand_verlet));
    add("verlet/eigen_unguarded", n, in_place(overhead::eigen_verlet));
    add("verlet/hand_guarded", n, beside(overhead::hand_verlet_guarded));
    if (n >= 1000000) add("verlet/hand_guarded_streaming", n, beside(overhead::hand_verlet_guarded_streaming));
    add("verlet/phistep", n, phistep_row(phistep::velocity_verlet));
#ifdef BENCH_HAS_ODEINT
    const auto odeint = [](auto make) {
      return [make](const Scene& s) {
        auto f = std::make_shared<VectorXd>(s.f);
        std::shared_ptr<overhead::OdeintMotion> motion = make(s.r, s.v, *f, mass);
        return [f, motion] { motion->step(dt); };
      };
    };
    add("euler/odeint_vector", n, odeint(overhead::odeint_euler_vector));
    add("euler/odeint_eigen", n, odeint(overhead::odeint_euler_eigen));
    add("verlet/odeint_vector", n, odeint(overhead::odeint_verlet_vector));
    add("verlet/odeint_eigen", n, odeint(overhead::odeint_verlet_eigen));
#endif
  }
  constexpr double h = 1e-3;
  const auto lorenz = [](const Eigen::Vector3d& y) -> Eigen::Vector3d {
    return {10.0 * (y[1] - y[0]), 28.0 * y[0] - y[1] - y[0] * y[2], y[0] * y[1] - 8.0 / 3.0 * y[2]};
  };
  add_small("lorenz/hand_doubles", [] { return overhead::hand_lorenz_doubles(lorenz_start, h, small_steps); });
  add_small("lorenz/hand_eigen", [] { return overhead::hand_lorenz_eigen(lorenz_start, h, small_steps); });
  add_small("lorenz/hand_guarded", [] { return overhead::hand_lorenz_eigen_guarded(lorenz_start, h, small_steps); });
  add_small("lorenz/phistep", [lorenz] { return run_small(lorenz_start, lorenz, phistep::forward_euler, h); });
#ifdef BENCH_HAS_ODEINT
  add_small("lorenz/odeint_eigen", [] { return overhead::odeint_lorenz_eigen(lorenz_start, h, small_steps); });
#endif
  const auto spring = [](const Eigen::Vector3d& r) -> Eigen::Vector3d { return -r; };
  const phistep::Motion<Eigen::Vector3d> start{{1, 0, 0}, {0, 1, 0}};
  const overhead::Particle particle{{1, 0, 0}, {0, 1, 0}};
  add_small("spring_euler/hand", [=] { return overhead::hand_spring_euler(particle, h, small_steps); });
  add_small("spring_euler/hand_guarded", [=] { return overhead::hand_spring_euler_guarded(particle, h, small_steps); });
  add_small("spring_euler/phistep", [=] { return run_small(start, spring, phistep::forward_euler, h); });
  add_small("spring_verlet/hand", [=] { return overhead::hand_spring_verlet(particle, h, small_steps); });
  add_small("spring_verlet/hand_guarded",
            [=] { return overhead::hand_spring_verlet_guarded(particle, h, small_steps); });
  add_small("spring_verlet/phistep", [=] { return run_small(start, spring, phistep::velocity_verlet, h); });

  std::vector<char*> arguments(argv, argv + argc);
  char interleave[] = "--benchmark_enable_random_interleaving=true", repeat[] = "--benchmark_repetitions=9",
       aggregates[] = "--benchmark_report_aggregates_only=true", brief[] = "--benchmark_min_time=0.05";
  if (argc == 1) arguments.insert(arguments.end(), {interleave, repeat, aggregates, brief});
  int count = static_cast<int>(arguments.size());
  benchmark::Initialize(&count, arguments.data());
  benchmark::RunSpecifiedBenchmarks();
}

/// @file
/// The bare update: what a step costs beside the force. The force array is given, so that nothing but the update is timed.
///
/// Rows: the best hand loops (unguarded in place; guarded: nothing lost on failure), phistep by step() and by integrate(),
/// Boost.Odeint. `chain`: a force that the library sums itself, against the same loop by hand. `bodies`: an array of structs
/// of 96 bytes, by Maps with a stride, against the old loop over them. `event`: a swing whose 200 passages through zero are found, beside
/// the same run without. Answers are compared before anything is timed. Rows of one size are interleaved at random and repeated; read the medians.
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

void per_particle(benchmark::State& run, Eigen::Index particles, int steps) {
  run.counters["ns/particle"] =
      benchmark::Counter(static_cast<double>(particles * steps) * 1e-9 * static_cast<double>(run.iterations()),
                         benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
}

/// The force array, given: calling it costs nothing, and it says so.
struct Given {
  const VectorXd* f;
  static constexpr bool is_lookup = true;
  const VectorXd& operator()(const VectorXd&) const { return *f; }
};

/// A chain of springs in the library's own terms, and as the hand loop has it.
constexpr double stiffness = 3.0, rest = 0.5, pull = 0.1;
auto chain_terms(Eigen::Index particles) {
  std::vector<phistep::Spring> springs;
  for (Eigen::Index i = 0; i + 1 < particles; ++i) springs.push_back({i, i + 1, stiffness, rest});
  return phistep::UniformForce{Eigen::Vector3d{pull, 0, 0}} + phistep::SpringNetwork<3>{std::move(springs)};
}
overhead::Chain chain_of(Eigen::Index particles) {
  overhead::Chain chain{{}, pull};
  for (Eigen::Index i = 0; i + 1 < particles; ++i) chain.ties.push_back({i, i + 1, stiffness, rest});
  return chain;
}

/// r, v and f of an array of structs.
using Column = Eigen::Map<Eigen::Matrix3Xd, 0, Eigen::OuterStride<12>>;
Column column(std::vector<overhead::Body>& bodies, double (overhead::Body::*member)[3]) {
  return {bodies.front().*member, 3, static_cast<Eigen::Index>(bodies.size())};
}
std::vector<overhead::Body> bodies_of(const Scene& s) {
  std::vector<overhead::Body> bodies(static_cast<std::size_t>(s.r.size() / 3));
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    bodies[i].mass = mass;
    for (int k = 0; k < 3; ++k) {
      const auto at = 3 * static_cast<Eigen::Index>(i) + k;
      bodies[i].r[k] = s.r[at], bodies[i].v[k] = s.v[at], bodies[i].f[k] = s.f[at];
    }
  }
  return bodies;
}
struct GivenInBodies {
  Column f;
  static constexpr bool is_lookup = true;
  const Column& operator()(const Eigen::Matrix3Xd&) const { return f; }
};

/// A function that owns what it steps, `steps` steps a call.
template <class Make>
void add(const std::string& name, Eigen::Index particles, Make make, int steps = 1) {
  benchmark::RegisterBenchmark((name + "/N=" + std::to_string(particles)).c_str(), [=](benchmark::State& run) {
    const Scene scene(particles);
    auto step = make(scene);
    for (int warm_up = 0; warm_up < 3; ++warm_up) step();  // the first touch of a work array costs more than a step
    for (auto _ : run) {
      step();
      benchmark::ClobberMemory();
    }
    per_particle(run, particles, steps);
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

/// The same steps without edits between them.
constexpr int run_steps = 50;
void run_all(auto& stepper, auto& state) {
  if (!phistep::integrate(stepper, state, {0.0, run_steps * dt}, phistep::fixed(dt))) std::abort();
}
template <class Scheme>
auto phistep_run_row(Scheme scheme) {
  return [scheme](const Scene& s) {
    auto force = std::make_shared<VectorXd>(s.f);
    phistep::Motion state{s.r, s.v};
    phistep::PhiStepper stepper{state, Given{force.get()}, scheme, phistep::mass(mass)};
    return [state, stepper, force]() mutable { run_all(stepper, state); };
  };
}
template <class Scheme>
auto chain_row(Scheme scheme, bool runs) {
  return [scheme, runs](const Scene& s) {
    phistep::Motion state{s.r, s.v};
    phistep::PhiStepper stepper{state, chain_terms(s.r.size() / 3), scheme, phistep::mass(mass)};
    return [state, stepper, runs]() mutable {
      if (runs) run_all(stepper, state);
      else if (!stepper.step(state, 0.0, dt)) std::abort();
    };
  };
}
template <class Loop>
auto hand_chain_row(Loop loop) {
  return [loop](const Scene& s) {
    VectorXd f(s.r.size());
    const auto chain = chain_of(s.r.size() / 3);
    overhead::hand_chain_force(s.r, f, chain);
    return [loop, r = s.r, v = s.v, f, chain]() mutable { loop(r, v, f, chain, mass, dt); };
  };
}
template <class Scheme>
auto bodies_row(Scheme scheme, bool runs) {
  return [scheme, runs](const Scene& s) {
    const auto bodies = std::make_shared<std::vector<overhead::Body>>(bodies_of(s));
    using overhead::Body;
    phistep::Motion state{column(*bodies, &Body::r), column(*bodies, &Body::v)};
    phistep::PhiStepper stepper{state, GivenInBodies{column(*bodies, &Body::f)}, scheme, phistep::mass(mass)};
    return [state, stepper, bodies, runs]() mutable {
      if (runs) run_all(stepper, state);
      else if (!stepper.step(state, 0.0, dt)) std::abort();
    };
  };
}
template <class Loop>
auto hand_bodies_row(Loop loop) {
  return [loop](const Scene& s) { return [loop, bodies = bodies_of(s)]() mutable { loop(bodies, dt); }; };
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
  const auto check_codes = [&](auto scheme, auto chain_loop, auto bodies_loop) {
    VectorXd r = s.r, v = s.v, f(s.r.size());
    const auto chain = chain_of(1000);
    overhead::hand_chain_force(r, f, chain);
    phistep::Motion state{s.r, s.v};
    phistep::PhiStepper stepper{state, chain_terms(1000), scheme, phistep::mass(mass)};
    auto old = bodies_of(s), bodies = old;
    phistep::Motion columns{column(bodies, &overhead::Body::r), column(bodies, &overhead::Body::v)};
    phistep::PhiStepper embedded{columns, GivenInBodies{column(bodies, &overhead::Body::f)}, scheme,
                                 phistep::mass(mass)};
    for (int n = 0; n < run_steps; ++n) {
      chain_loop(r, v, f, chain, mass, dt);
      bodies_loop(old, dt);
    }
    run_all(stepper, state);
    run_all(embedded, columns);
    wrong |= !((state.r - r).norm() <= 1e-12 * r.norm() && (state.v - v).norm() <= 1e-12 * v.norm());
    wrong |= (column(old, &overhead::Body::r) - columns.r).norm() > 1e-12 * r.norm() ||
             (column(old, &overhead::Body::v) - columns.v).norm() > 1e-12 * v.norm();
  };
  check_codes(phistep::forward_euler, overhead::hand_chain_euler, overhead::hand_bodies_euler);
  check_codes(phistep::velocity_verlet, overhead::hand_chain_verlet, overhead::hand_bodies_verlet);
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

/// A swing of 100 periods, with an event at each passage through zero or without.
constexpr int passages = 200;
template <class Scheme, class Control>
void add_events(const std::string& name, Scheme scheme, Control control) {
  for (const bool watched : {true, false})
    benchmark::RegisterBenchmark(("event/" + name + (watched ? "" : "_without")).c_str(), [=](benchmark::State& run) {
      const auto spring = [](const Eigen::Vector2d& y) -> Eigen::Vector2d { return {y[1], -y[0]}; };
      for (auto _ : run) {
        Eigen::Vector2d y{1, 0};
        phistep::PhiStepper stepper{y, spring, scheme};
        auto zero = phistep::event([](const Eigen::Vector2d& x) { return x[0]; });
        const double t1 = passages * 3.14159265358979323846;
        const bool done = watched ? bool{phistep::integrate(stepper, y, {0, t1}, control, zero)}
                                  : bool{phistep::integrate(stepper, y, {0, t1}, control)};
        if (!done || (watched && zero.times().size() != passages)) std::abort();
      }
      run.counters["us/event"] = benchmark::Counter(passages * 1e-6 * static_cast<double>(run.iterations()),
                                                    benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
    });
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
    add("euler/phistep_run", n, phistep_run_row(phistep::forward_euler), run_steps);
    add("verlet/hand_unguarded", n, in_place(overhead::hand_verlet));
    add("verlet/eigen_unguarded", n, in_place(overhead::eigen_verlet));
    add("verlet/hand_guarded", n, beside(overhead::hand_verlet_guarded));
    if (n >= 1000000) add("verlet/hand_guarded_streaming", n, beside(overhead::hand_verlet_guarded_streaming));
    add("verlet/phistep", n, phistep_row(phistep::velocity_verlet));
    add("verlet/phistep_run", n, phistep_run_row(phistep::velocity_verlet), run_steps);
    add("chain_euler/hand_unguarded", n, hand_chain_row(overhead::hand_chain_euler));
    add("chain_euler/phistep", n, chain_row(phistep::forward_euler, false));
    add("chain_euler/phistep_run", n, chain_row(phistep::forward_euler, true), run_steps);
    add("chain_verlet/hand_unguarded", n, hand_chain_row(overhead::hand_chain_verlet));
    add("chain_verlet/phistep", n, chain_row(phistep::velocity_verlet, false));
    add("chain_verlet/phistep_run", n, chain_row(phistep::velocity_verlet, true), run_steps);
    add("bodies_euler/hand_unguarded", n, hand_bodies_row(overhead::hand_bodies_euler));
    add("bodies_euler/phistep", n, bodies_row(phistep::forward_euler, false));
    add("bodies_euler/phistep_run", n, bodies_row(phistep::forward_euler, true), run_steps);
    add("bodies_verlet/hand_unguarded", n, hand_bodies_row(overhead::hand_bodies_verlet));
    add("bodies_verlet/phistep", n, bodies_row(phistep::velocity_verlet, false));
    add("bodies_verlet/phistep_run", n, bodies_row(phistep::velocity_verlet, true), run_steps);
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

  const phistep::tolerance six{.rtol = 1e-6, .atol = 1e-6};
  add_events("tsit5_fixed", phistep::tsit5, phistep::fixed(0.05));
  add_events("dop853", phistep::dop853, six);
  add_events("radau", phistep::radau, six);

  std::vector<char*> arguments(argv, argv + argc);
  char interleave[] = "--benchmark_enable_random_interleaving=true", repeat[] = "--benchmark_repetitions=9",
       aggregates[] = "--benchmark_report_aggregates_only=true", brief[] = "--benchmark_min_time=0.05";
  if (argc == 1) arguments.insert(arguments.end(), {interleave, repeat, aggregates, brief});
  int count = static_cast<int>(arguments.size());
  benchmark::Initialize(&count, arguments.data());
  benchmark::RunSpecifiedBenchmarks();
}

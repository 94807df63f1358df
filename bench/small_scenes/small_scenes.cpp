/// @file
/// Scenes of a few particles, over many steps: beside loops by hand that check each step as phistep does. What is left is
/// what a step costs that the loop doesn't have.
///
/// For each scene and scheme: phistep by integrate() and by step(), and the loop; the ways in turns, in one process, CPU time,
/// medians. Answers are compared first.
///     bench_small_scenes [rounds, 21]
#include <phistep/particles/springs/springs.hpp>
#include <phistep/phistep.hpp>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <functional>
#include <string>
#include <vector>

#include "hand.hpp"

namespace {
using namespace small_scenes;
using Eigen::Index;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr double mass = 2.0, dt = 1e-3;

double now() {
  timespec t;
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

/// One way to do the scene's steps, and what it comes to.
struct Way {
  std::string name;
  std::function<VectorXd()> run;
};

VectorXd numbers(const auto& r, const auto& v) {
  VectorXd all(r.size() + v.size());
  all << r.reshaped(), v.reshaped();
  return all;
}

/// ns a step of each way, the first being the loop by hand.
void measure(const std::string& scene, const std::vector<Way>& ways, long steps, int rounds) {
  const VectorXd right = ways.front().run();
  for (const Way& way : ways)
    if (!((way.run() - right).norm() <= 1e-9 * right.norm())) {
      std::printf("%s: %s disagrees; nothing was timed\n", scene.c_str(), way.name.c_str());
      std::exit(1);
    }
  std::vector<std::vector<double>> times(ways.size());
  for (int k = 0; k < rounds; ++k)
    for (std::size_t w = 0; w < ways.size(); ++w) {
      const double start = now();
      const VectorXd end = ways[w].run();
      times[w].push_back((now() - start) / static_cast<double>(steps) * 1e9 + 0 * end[0]);
    }
  const auto median = [](std::vector<double>& x) {
    std::nth_element(x.begin(), x.begin() + static_cast<std::ptrdiff_t>(x.size() / 2), x.end());
    return x[x.size() / 2];
  };
  const double hand = median(times.front());
  std::printf("%-28s by hand %9.2f ns", scene.c_str(), hand);
  for (std::size_t w = 1; w < ways.size(); ++w) {
    const double t = median(times[w]);
    std::printf(" | %s %9.2f ns %5.2f x", ways[w].name.c_str(), t, t / hand);
  }
  std::printf("\n");
}

/// phistep's two ways.
template <class State, class Force, class Scheme>
void add(std::vector<Way>& ways, const std::string& name, const State& start, const Force& force, Scheme scheme,
         long steps) {
  ways.push_back({name + "integrate", [=] {
                    State y = start;
                    phistep::PhiStepper stepper{y, force, scheme, phistep::mass(mass)};
                    if (!phistep::integrate(stepper, y, {0.0, static_cast<double>(steps) * dt}, phistep::fixed(dt)))
                      std::abort();
                    return numbers(y.r, y.v);
                  }});
  ways.push_back({name + "step()", [=] {
                    State y = start;
                    phistep::PhiStepper stepper{y, force, scheme, phistep::mass(mass)};
                    for (long n = 0; n < steps; ++n)
                      if (!stepper.step(y, static_cast<double>(n) * dt, dt)) std::abort();
                    return numbers(y.r, y.v);
                  }});
}

template <class Scheme>
void spring(const char* name, Scheme scheme, auto hand, int rounds) {
  constexpr long steps = 200000;
  const Particle start{{1, 0, 0}, {0, 1, 0}};
  std::vector<Way> ways{{"by hand", [=] {
                           const Particle y = hand(start, mass, dt, steps);
                           return numbers(y.r, y.v);
                         }}};
  const auto force = [](const Vector3d& r) -> Vector3d { return -r; };
  add(ways, "", phistep::Motion{start.r, start.v}, force, scheme, steps);
  measure(std::string("spring, ") + name, ways, steps, rounds);
}

/// The loop's own forces, as a struct for phistep.
struct NetForce {
  Net net;
  static constexpr bool uses_velocity = false, uses_time = false;
  void add(double /*t*/, const auto& y, auto& out) const { add_forces(net, y.r.data(), out.force.data(), y.r.size()); }
};

/// `rows` × `columns` beads, neighbours tied along rows, columns and one diagonal.
Net net_of(Index rows, Index columns) {
  Net net{{}, 0.1};
  const auto tie = [&](Index i, Index j, double length) { net.ties.push_back({i, j, 3.0, length}); };
  for (Index b = 0; b < rows; ++b)
    for (Index a = 0; a < columns; ++a) {
      const Index i = b * columns + a;
      if (a + 1 < columns) tie(i, i + 1, 1);
      if (b + 1 < rows) tie(i, i + columns, 1);
      if (a + 1 < columns && b + 1 < rows) tie(i, i + columns + 1, std::sqrt(2.0));
    }
  return net;
}
Beads beads_of(Index rows, Index columns) {
  const Index n = rows * columns;
  Beads y{VectorXd(3 * n), VectorXd(3 * n)};
  for (Index i = 0; i < n; ++i) {
    const double x = static_cast<double>(i);
    y.r.segment<3>(3 * i) << static_cast<double>(i % columns), static_cast<double>(i / columns), 0.1 * std::sin(x);
    y.v.segment<3>(3 * i) << 0.1 * std::cos(x), 0.1 * std::sin(2 * x), 0;
  }
  return y;
}
template <class Scheme>
void net(const std::string& name, Scheme scheme, auto hand, Index rows, Index columns, int rounds) {
  const long steps = std::max(20L, 2000000 / (rows * columns) / 4);
  const Beads start = beads_of(rows, columns);
  const Net ties = net_of(rows, columns);
  std::vector<Way> ways{{"by hand", [=] {
                           const Beads y = hand(start, ties, mass, dt, steps);
                           return numbers(y.r, y.v);
                         }}};
  std::vector<phistep::Spring> springs;
  for (const auto& tie : ties.ties) springs.push_back({tie.i, tie.j, tie.stiffness, tie.length});
  const phistep::Motion state{start.r, start.v};
  add(ways, "own force: ", state, NetForce{ties}, scheme, steps);
  add(ways, "library's: ", state,
      phistep::UniformForce{Vector3d{ties.pull, 0, 0}} + phistep::SpringNetwork<3>{std::move(springs)}, scheme, steps);
  measure(name, ways, steps, rounds);
}
}  // namespace

int main(int argc, char** argv) {
  const int rounds = argc > 1 ? std::atoi(argv[1]) : 21;
  const auto euler_spring = [](auto... a) { return euler(a...); };
  const auto verlet_spring = [](auto... a) { return verlet(a...); };
  const auto euler_net = [](const auto&... a) { return euler(a...); };
  const auto verlet_net = [](const auto&... a) { return verlet(a...); };
  spring("Euler", phistep::forward_euler, euler_spring, rounds);
  spring("Verlet", phistep::velocity_verlet, verlet_spring, rounds);
  const auto nets = [&](const std::string& name, Index rows, Index columns) {
    net(name + ", Euler", phistep::forward_euler, euler_net, rows, columns, rounds);
    net(name + ", Verlet", phistep::velocity_verlet, verlet_net, rows, columns, rounds);
  };
  nets("chain of 10", 1, 10);
  nets("chain of 100", 1, 100);
  nets("sheet of 10 x 10", 10, 10);
  nets("sheet of 100 x 100", 100, 100);
}

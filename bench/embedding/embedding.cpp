/// @file
/// What embedding costs existing codes: the three codes of examples/existing_codes, as they were and embedded, forces
/// included; and the bare update of each, its force routine empty.
///
/// Each measurement is a run of a few steps with Verlet's first force call. "The code's own run" makes its stepper anew each
/// time, the other two keep theirs; what making one takes is printed beside. Rows of one size take turns in an order drawn
/// anew each round; printed are medians of CPU time, and the median of what each took relative to the old loop in the same
/// round. Answers are compared before anything is timed.
///     bench_embedding [rounds, default 31] [most particles, default 1000000]
#include "../../examples/existing_codes/before_and_after.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <functional>
#include <memory>
#include <numeric>
#include <random>
#include <string>
#include <utility>
#include <vector>

namespace {

using Numbers = std::vector<double>;

struct Row {
  std::string name;
  std::function<void(int)> run;         // so many steps
  std::function<Numbers()> state;       // x, v or u
  std::function<long()> force_calls{};  // where there is a routine
};

[[noreturn]] void stop(const std::string& why) {
  std::fprintf(stderr, "bench_embedding: %s; nothing was timed\n", why.c_str());
  std::exit(1);
}

/// All rows do one run, and have to agree; this warms them up as well. Contraction to FMA may differ between loops.
void compare(const std::vector<Row>& rows, const std::string& title, int steps) {
  Numbers right;
  for (const Row& row : rows) {
    row.run(steps);
    const Numbers found = row.state();
    if (right.empty()) right = found;
    double off = 0, size = 0;
    for (std::size_t i = 0; i < right.size(); ++i)
      off = std::max(off, std::abs(found[i] - right[i])), size = std::max(size, std::abs(right[i]));
    if (!(off <= 1e-12 * size)) stop(title + ", " + row.name + ": is off by " + std::to_string(off));
    if (row.force_calls && row.force_calls() != rows[0].force_calls())
      stop(title + ", " + row.name + ": other force calls");
  }
}

double median(std::vector<double> all) {
  std::sort(all.begin(), all.end());
  const std::size_t n = all.size();
  return n % 2 ? all[n / 2] : (all[n / 2 - 1] + all[n / 2]) / 2;
}

void measure(const std::string& title, std::vector<Row> rows, long particles, int steps, int rounds) {
  compare(rows, title, steps);
  std::vector<std::vector<double>> seconds(rows.size());
  std::vector<std::size_t> order(rows.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::mt19937 random(1);
  for (int round = 0; round < rounds; ++round) {
    std::shuffle(order.begin(), order.end(), random);
    for (const std::size_t k : order) {
      const std::clock_t start = std::clock();
      rows[k].run(steps);
      seconds[k].push_back(static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC);
    }
  }
  const double per = 1e9 / (static_cast<double>(particles) * steps);
  std::printf("\n%s, N = %ld, %d steps a run\n", title.c_str(), particles, steps);
  for (std::size_t k = 0; k < rows.size(); ++k) {
    std::vector<double> ratios;
    for (std::size_t r = 0; r < seconds[k].size(); ++r) ratios.push_back(seconds[k][r] / seconds[0][r]);
    std::printf("  %-36s %10.2f ns a particle-step   %6.3f of the old loop\n", rows[k].name.c_str(),
                per * median(seconds[k]), median(ratios));
  }
  std::fflush(stdout);
}

// ---- the codes' arrays ------------------------------------------------------------------------------------------------

Numbers state_of(const auto& code) {
  Numbers all;
  if constexpr (requires { code.beads; }) {
    for (const auto& b : code.beads) all.insert(all.end(), b.x, b.x + 3), all.insert(all.end(), b.v, b.v + 3);
  } else if constexpr (requires { code.natoms; }) {
    for (int i = 0; i < code.natoms; ++i)
      all.insert(all.end(), code.x[i], code.x[i] + 3), all.insert(all.end(), code.v[i], code.v[i] + 3);
  } else {
    all.assign(code.u, code.u + code.ncells);
  }
  return all;
}

/// A row that steps a code by `run(code, steps)`.
template <class Code>
Row row(const std::string& name, const std::shared_ptr<Code>& code, auto run) {
  return {name, [=](int steps) { run(*code, steps); }, [=] { return state_of(*code); },
          [=] { return code->force_calls; }};
}
/// Without forces: what the arrays hold as forces stays as it is.
template <class Code>
Row bare(const std::string& name, const std::shared_ptr<Code>& code, auto run) {
  return {name, [=](int steps) { run(*code, steps); }, [=] { return state_of(*code); }, nullptr};
}

/// A force routine that does nothing; where it is called, the arrays may have changed for all that the compiler knows.
[[gnu::noinline]] void nothing() { __asm__ __volatile__("" ::: "memory"); }

enum class By { integrate, step };

/// A code, its arrays as a state, a stepper for them.
template <class Code, class MakeState, class MakeStepper>
struct Embedded {
  std::shared_ptr<Code> code;
  decltype(std::declval<MakeState>()(std::declval<Code&>())) state;
  decltype(std::declval<MakeStepper>()(state)) stepper;
  Embedded(std::shared_ptr<Code> c, const MakeState& make_state, const MakeStepper& make_stepper)
      : code{std::move(c)}, state(make_state(*code)), stepper(make_stepper(state)) {}

  void run(By by, int steps, double dt) {
    stepper.reset();  // the first force call, too, is part of a run
    if (by == By::integrate) {
      if (!phistep::integrate(stepper, state, {0, steps * dt}, phistep::fixed(dt))) std::abort();
    } else {
      for (int n = 0; n < steps; ++n)
        if (!stepper.step(state, n * dt, dt)) std::abort();
    }
  }
};
/// A row by a stepper that is kept from run to run. `make_stepper(state, code)`.
template <class Code, class MakeState, class MakeStepper>
Row kept(By by, bool has_forces, double dt, const std::shared_ptr<Code>& code, MakeState make_state,
         MakeStepper make_stepper) {
  const auto make = [=](auto& state) { return make_stepper(state, *code); };
  const auto all = std::make_shared<Embedded<Code, MakeState, decltype(make)>>(code, make_state, make);
  const std::string name = by == By::integrate ? "embedded, integrate" : "embedded, step";
  const auto run = [=](Code&, int steps) { all->run(by, steps, dt); };
  return has_forces ? row(name, code, run) : bare(name, code, run);
}
/// [ms] What the state and the stepper take to be made: the least of five.
template <class Code>
void show_construction(const std::shared_ptr<Code>& code, auto make_state, auto make_stepper) {
  double least = HUGE_VAL;
  for (int n = 0; n < 5; ++n) {
    const std::clock_t start = std::clock();
    {
      auto state = make_state(*code);
      auto stepper = make_stepper(state, *code);
      stepper.reset();
    }
    least = std::min(least, static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC);
  }
  std::printf("  %-36s %10.3f ms\n", "making state and stepper", 1e3 * least);
}

void cloth(int n, int steps, int bare_steps, int rounds) {
  constexpr double dt = 5e-4;
  using phistep::places, after::Bead;
  const auto old = [=] { return std::make_shared<before::Cloth>(n); };
  const auto now = [=] { return std::make_shared<after::Cloth>(n); };
  const long beads = static_cast<long>(old()->beads.size());
  const auto state = [](after::Cloth& c) {
    return phistep::MotionInPlace{places(c.beads, &Bead::x), places(c.beads, &Bead::v), places(c.beads, &Bead::f)};
  };
  const auto by = [](auto scheme) {
    return [=](auto& y, after::Cloth& c) {
      const auto mass = phistep::mass(places(c.beads, &Bead::m));
      return phistep::PhiStepper{y, y.force_of_r([&c] { c.compute_forces(); }), scheme, mass};
    };
  };
  const auto bare_by = [](auto scheme) {
    return [=](auto& y, after::Cloth& c) {
      return phistep::PhiStepper{y, y.force_of_r(nothing), scheme, phistep::mass(places(c.beads, &Bead::m))};
    };
  };
  const auto euler = [](auto& c, int times) { c.run_euler(times, dt); };
  const auto verlet = [](auto& c, int times) { c.run_verlet(times, dt); };
  const auto with_forces = [&](const std::string& title, auto loop, auto scheme) {
    measure(title,
            {row("old loop", old(), loop), row("old loop again", old(), loop),
             row("embedded, the code's own run", now(), loop), kept(By::integrate, true, dt, now(), state, by(scheme)),
             kept(By::step, true, dt, now(), state, by(scheme))},
            beads, steps, rounds);
    show_construction(now(), state, by(scheme));
  };
  with_forces("masses on springs, semi-implicit Euler", euler, phistep::symplectic_euler);
  with_forces("masses on springs, velocity Verlet", verlet, phistep::velocity_verlet);

  const auto without_forces = [&](const std::string& title, auto loop, auto scheme) {
    measure(title,
            {bare("old loop", old(), loop), bare("old loop again", old(), loop),
             kept(By::integrate, false, dt, now(), state, bare_by(scheme)),
             kept(By::step, false, dt, now(), state, bare_by(scheme))},
            beads, bare_steps, rounds);
  };
  const auto bare_euler = [](before::Cloth& c, int times) {
    for (int step = 0; step < times; ++step) {
      nothing();
      for (before::Bead& b : c.beads) {
        for (int k = 0; k < 3; ++k) b.v[k] += dt * b.inv_m * b.f[k];
        for (int k = 0; k < 3; ++k) b.x[k] += dt * b.v[k];
      }
    }
  };
  const auto bare_verlet = [](before::Cloth& c, int times) {
    for (int step = 0; step < times; ++step) {
      for (before::Bead& b : c.beads) {
        for (int k = 0; k < 3; ++k) b.v[k] += 0.5 * dt * b.inv_m * b.f[k];
        for (int k = 0; k < 3; ++k) b.x[k] += dt * b.v[k];
      }
      nothing();
      for (before::Bead& b : c.beads)
        for (int k = 0; k < 3; ++k) b.v[k] += 0.5 * dt * b.inv_m * b.f[k];
    }
  };
  without_forces("the same without forces, semi-implicit Euler", bare_euler, phistep::symplectic_euler);
  without_forces("the same without forces, velocity Verlet", bare_verlet, phistep::velocity_verlet);
}

void atoms(int n, int steps, int bare_steps, int rounds) {
  constexpr double dt = 0.002;
  using phistep::places;
  const auto old = [=] { return std::make_shared<before::MolecularDynamics>(n); };
  const auto now = [=] { return std::make_shared<after::MolecularDynamics>(n); };
  const auto state = [](after::MolecularDynamics& md) {
    return phistep::MotionInPlace{places(md.x, md.natoms), places(md.v, md.natoms), places(md.f, md.natoms)};
  };
  const auto by = [](auto& y, after::MolecularDynamics& md) {
    return phistep::PhiStepper{y, y.force_of_r([&md] { md.compute_forces(); }), phistep::velocity_verlet,
                               phistep::mass(md.mass)};
  };
  const auto bare_by = [](auto& y, after::MolecularDynamics& md) {
    return phistep::PhiStepper{y, y.force_of_r(nothing), phistep::velocity_verlet, phistep::mass(md.mass)};
  };
  const auto run = [](auto& md, int times) { md.run(times, dt); };
  measure(
      "molecular dynamics, velocity Verlet",
      {row("old loop", old(), run), row("old loop again", old(), run), row("embedded, the code's own run", now(), run),
       kept(By::integrate, true, dt, now(), state, by), kept(By::step, true, dt, now(), state, by)},
      n, steps, rounds);
  show_construction(now(), state, by);
  const auto bare_run = [](before::MolecularDynamics& md, int times) {
    const double kick = 0.5 * dt / md.mass;
    for (int step = 0; step < times; ++step) {
      for (int i = 0; i < md.natoms; ++i) {
        for (int k = 0; k < 3; ++k) {
          md.v[i][k] += kick * md.f[i][k];
          md.x[i][k] += dt * md.v[i][k];
        }
      }
      nothing();
      for (int i = 0; i < md.natoms; ++i)
        for (int k = 0; k < 3; ++k) md.v[i][k] += kick * md.f[i][k];
    }
  };
  measure("the same without forces",
          {bare("old loop", old(), bare_run), bare("old loop again", old(), bare_run),
           kept(By::integrate, false, dt, now(), state, bare_by), kept(By::step, false, dt, now(), state, bare_by)},
          n, bare_steps, rounds);
}

void heat(int n, int steps, int bare_steps, int rounds) {
  const double dt = before::HeatPlate(n).largest_stable_step() / 2;
  using phistep::places;
  const auto old = [=] { return std::make_shared<before::HeatPlate>(n); };
  const auto now = [=] { return std::make_shared<after::HeatPlate>(n); };
  const long cells = old()->ncells;
  const auto state = [](after::HeatPlate& plate) {
    return phistep::VectorInPlace{places(plate.u, plate.ncells), places(plate.dudt, plate.ncells)};
  };
  const auto by = [](auto& y, after::HeatPlate& plate) {
    return phistep::PhiStepper{y, y.force([&plate] { plate.compute_rates(); }), phistep::forward_euler};
  };
  const auto bare_by = [](auto& y, after::HeatPlate&) {
    return phistep::PhiStepper{y, y.force(nothing), phistep::forward_euler};
  };
  const auto run = [dt](auto& plate, int times) { plate.run(times, dt); };
  measure(
      "heat, forward Euler",
      {row("old loop", old(), run), row("old loop again", old(), run), row("embedded, the code's own run", now(), run),
       kept(By::integrate, true, dt, now(), state, by), kept(By::step, true, dt, now(), state, by)},
      cells, steps, rounds);
  show_construction(now(), state, by);
  const auto bare_run = [dt](before::HeatPlate& plate, int times) {
    for (int step = 0; step < times; ++step) {
      nothing();
      for (int c = 0; c < plate.ncells; ++c) plate.u[c] += dt * plate.dudt[c];
    }
  };
  measure("the same without forces",
          {bare("old loop", old(), bare_run), bare("old loop again", old(), bare_run),
           kept(By::integrate, false, dt, now(), state, bare_by), kept(By::step, false, dt, now(), state, bare_by)},
          cells, bare_steps, rounds);
}

}  // namespace

int main(int argc, char** argv) {
  const int rounds = argc > 1 ? std::atoi(argv[1]) : 31, most = argc > 2 ? std::atoi(argv[2]) : 1000000;
  if (rounds < 1 || most < 1) stop("usage: bench_embedding [rounds] [most particles]");
  std::printf("compiler %s, %d rounds\n", __VERSION__, rounds);
  cloth(1024, 200, 2000, rounds);
  atoms(1000, 10, 2000, rounds);
  heat(1024, 2000, 10000, rounds);
  if (most < 1000000) return 0;
  cloth(1000000, 5, 10, rounds);
  heat(1000000, 20, 40, rounds);
  atoms(1000000, 2, 10, std::max(rounds / 3, 1));
}

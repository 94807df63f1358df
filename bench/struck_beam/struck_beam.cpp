/// @file
/// bench_struck_beam: time at equal error in the first three modes, and the noise that is left in the tip's velocity; each method
/// at its own steps or tolerances. The answer is checked against the modes: nothing is timed that isn't near them.
#include <phistep/phistep.hpp>
#include <phistep/sparse.hpp>

#include <cstdio>
#include <cstring>

#include "../equal_error.hpp"
#include "problem.hpp"

namespace {

using namespace struck_beam;
using namespace phistep;

/// @param control  of a run, from its number
template <class Scheme, class Solver, class Control>
void ours(const Beam& beam, std::vector<Row>& rows, const char* name, Scheme scheme, Solver solver, int count,
          const Control& control) {
  Row row{name, {}};
  for (int k = 0; k < count; ++k)
    row.runs.push_back(timed(beam, [&](Seen* seen) -> long long {
      Motion<Vec> y{Vec::Zero(n), beam.v0};
      PhiStepper stepper{y, symmetric(linear(Sparse(-beam.K))), scheme, mass(beam.M), solver};
      const RunReport report = seen != nullptr ? integrate(stepper, y, {0, beam.t1}, control(k),
                                                           [seen](double t, const auto& x) { (*seen)(t, x.r, x.v); })
                                               : integrate(stepper, y, {0, beam.t1}, control(k));
      if (!report) std::printf("%s: %s\n", name, report.message().c_str());
      return report.statistics.steps;
    }));
  rows.push_back(row);
}

/// The same formulas at the same Δt, and another start: how far the ways are apart, where the errors are alike.
bool compare(const Row& mine, const Row& theirs) {
  bool agree = true;
  for (std::size_t k = 0; k < theirs.runs.size(); ++k) {
    const Result &a = mine.runs[k], &b = theirs.runs[k];
    double apart = a.way.size() == b.way.size() ? 0 : 1;
    for (std::size_t i = 0; i < std::min(a.way.size(), b.way.size()); ++i)
      apart = std::max(apart, std::abs(a.way[i] - b.way[i]));
    agree = agree && apart < a.error;
    std::printf("%s, %lld steps: %.2g %% apart, errors %.2f and %.2f %%, time ratio %.2f\n", theirs.name.c_str(),
                a.steps, 100 * apart, 100 * a.error, 100 * b.error, b.seconds / a.seconds);
  }
  return agree;
}

}  // namespace

int main(int argc, char** argv) {
  const bool quick = argc > 1 && std::strcmp(argv[1], "--quick") == 0;
  const Beam beam;
  std::vector<Row> rows;
  const int count = quick ? 2 : 6;
  bool agree = true;
  const auto steps = [&](int k) { return fixed(beam.period / (250 << k)); };
  const auto tolerances = [](int k) {
    return tolerance{.rtol = std::pow(10.0, -2 - k), .atol = std::pow(10.0, -4 - k)};
  };
  ours(beam, rows, "trapezoidal", trapezoidal, newton(), count, steps);
  ours(beam, rows, "backward_euler", backward_euler, newton(), count + (quick ? 0 : 1), steps);
  ours(beam, rows, "tr_bdf2", tr_bdf2, newton(), count, steps);
  for (const double rho : {0.0, 0.5, 0.8}) {
    const std::string name = "generalized_alpha(" + std::to_string(rho).substr(0, 3) + ")";
    ours(beam, rows, name.c_str(), generalized_alpha(rho), newton(), count, steps);
    const std::size_t mine = rows.size() - 1;
    petsc(beam, rows, rho, count);
    if (rows.size() > mine + 1) agree = compare(rows[mine], rows.back()) && agree;
  }
  ours(beam, rows, "radau, tolerance", radau, newton(), 1, tolerances);
  cvode(beam, rows);

  std::printf("phistep %d.%d, compiler %s, Eigen %d.%d.%d\n", version_major, version_minor, __VERSION__,
              EIGEN_WORLD_VERSION, EIGEN_MAJOR_VERSION, EIGEN_MINOR_VERSION);
  std::printf("%-24s %9s %10s %10s %10s\n", "", "steps", "error", "noise", "time [ms]");
  for (const Row& row : rows)
    for (const Result& run : row.runs)
      std::printf("%-24s %9lld %8.2f %% %8.1f %% %10.2f\n", row.name.c_str(), run.steps, 100 * run.error,
                  100 * run.noise, 1e3 * run.seconds);
  std::printf("\nat 1 %% of the tip in its first three modes: time, noise of the run next to it\n");
  for (const Row& row : rows) {
    std::vector<std::pair<double, double>> points;
    double noise = 0, best = 1e300;
    for (const Result& run : row.runs) {
      points.emplace_back(run.seconds, run.error);
      if (std::abs(std::log(run.error / 0.01)) < best) best = std::abs(std::log(run.error / 0.01)), noise = run.noise;
    }
    agree = agree && row.runs.back().error < row.runs.front().error * 1.01;
    if (const auto time = bench::time_to_error(0.01, points))
      std::printf("%-24s %10.1f ms %10.1f %%\n", row.name.c_str(), 1e3 * *time, 100 * noise);
    else std::printf("%-24s not reached (best %.2g %%)\n", row.name.c_str(), 100 * row.runs.back().error);
  }
  return agree ? 0 : 1;
}

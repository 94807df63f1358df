/// @file
/// Milliseconds of CPU for one linearized implicit step of a cloth: assembly and solve to a relative residual of 1e-6.
/// Rows in turn, medians; a row whose residual is too large is reported and not timed.
///     bench_implicit_cloth [repeats, default 9]
#include <phistep/phistep.hpp>

#include <time.h>

#include <cstdio>
#include <cstdlib>
#include <string>
#include <utility>

#include "rivals.hpp"

namespace {
using cloth::Answer;
using cloth::Problem;
using cloth::Rival;

/// phistep's own system for networks, given the same clamped springs in the same order as the others.
class Library : public Rival {
 public:
  explicit Library(const Problem& problem) { system_.resize(problem.unknowns()); }
  void step(const Problem& problem, Answer& answer) override {
    system_.clear();
    for (const cloth::Spring& s : problem.springs) {
      double across = 0;
      const Eigen::Vector3d n = problem.direction(s, across);
      system_.edge(s.i, s.j, n.data(), {problem.k, problem.k * across});
    }
    const auto masses = [n = problem.unknowns()](auto&& put) {
      for (Eigen::Index i = 0; i < n; ++i) put(i, i, 1.0);
    };
    const auto before = statistics_;
    // K is the force's derivative: W = M − γ_f γ_d K, and an edge of K couples with B.
    if (!system_.is_finite() || system_.factorize(masses, 1.0, 1.0, statistics_) != phistep::Outcome::success) return;
    answer.x = problem.right_hand_side;
    if (system_.solve(answer.x, cloth::tolerance, statistics_) != phistep::Outcome::success) answer.x.setZero();
    answer.iterations = (statistics_ - before).linear_iterations;
  }

 private:
  phistep::NetworkSystem<double, 3, true, false> system_;
  phistep::Statistics statistics_;
};

/// Of this thread: what else runs on the machine does not count.
double now() {
  timespec t{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

struct Row {
  std::string name;
  std::unique_ptr<Rival> rival;
  int every = 1;  // slow rows run in one round of so many
  std::vector<double> times{};
  Answer answer{};
  double residual = 0;
  [[nodiscard]] double median() {
    std::sort(times.begin(), times.end());
    return times[times.size() / 2];
  }
};

bool run(int side, double k, int repeats) {
  const Problem problem(side, k);
  std::vector<Row> rows;
  rows.push_back({"hand, 6 doubles an edge", cloth::hand_six_doubles(problem)});
  rows.push_back({"hand, 4 doubles an edge", cloth::hand_four_doubles(problem)});
  rows.push_back({"hand, 4 floats an edge", cloth::hand_four_floats(problem)});
  rows.push_back({"hand, padded and sorted", cloth::hand_padded(problem)});
  const std::size_t hands = rows.size();
  rows.push_back({"phistep", std::make_unique<Library>(problem)});
  rows.push_back({"Eigen triplets + CG", cloth::eigen_cg(problem), 5});
  if (side <= 100) rows.push_back({"Eigen triplets + SimplicialLDLT", cloth::eigen_ldlt(problem), 100});
#ifdef BENCH_HAS_CHOLMOD
  rows.push_back({"Eigen triplets + CHOLMOD", cloth::eigen_cholmod(problem), 5});
#endif
  bool right = true;
  for (Row& row : rows) {
    row.rival->step(problem, row.answer);
    row.residual = (problem.product(row.answer.x) - problem.right_hand_side).norm() / problem.right_hand_side.norm();
    // Recursive residuals drift from true ones by rounding; floats move the matrix by 6e-8.
    if (!(row.residual <= 1.5 * cloth::tolerance)) {
      std::printf("%s: residual %.1e, not timed\n", row.name.c_str(), row.residual);
      right = false;
    }
  }
  if (!right) return false;
  for (int round = 0; round < repeats; ++round)
    for (Row& row : rows) {
      if (round % row.every != 0) continue;
      const double start = now();
      row.rival->step(problem, row.answer);
      row.times.push_back(now() - start);
    }
  double best = rows[0].median();
  for (std::size_t i = 0; i < hands; ++i) best = std::min(best, rows[i].median());
  std::printf("\n%d particles, %zu springs, dt^2 k/m = %g\n", side * side, problem.springs.size(), k);
  for (Row& row : rows)
    std::printf("  %-32s %9.2f ms   %5.2f x best hand   %5ld iterations   residual %.1e\n", row.name.c_str(),
                1e3 * row.median(), row.median() / best, row.answer.iterations, row.residual);
  std::fflush(stdout);
  return true;
}
}  // namespace

int main(int argc, char** argv) {
  const int repeats = argc > 1 ? std::max(1, std::atoi(argv[1])) : 9;
  std::printf("%s; %s\n", __VERSION__, Eigen::SimdInstructionSetsInUse());
  bool right = true;
  for (const int side : {100, 200})
    for (const double k : {1.0, 1e2, 1e4}) right = run(side, k, repeats) && right;
  return right ? 0 : 1;
}

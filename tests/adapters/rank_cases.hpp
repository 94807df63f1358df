// Fields on the ranks of MPI, whatever library's: the digits and counts of Eigen's vectors, one decision for all ranks whatever
// happens on one of them, and how often the ranks wait for each other. To be run on 1, 2 and 3 ranks. Included behind a class
// Grid of the Brusselator (brusselator.hpp) a number some_error_code and the library's name. It has
//     Field                 the state
//     start()               the Brusselator's
//     rate(y, out)          its Ψ
//     solver()              its linear solver
//     for_each(y, f)        f(row, column, component, number) for this rank's numbers of y, which f may change
#pragma once

#include <mpi.h>
#include <unistd.h>

#include <Eigen/Core>
#include <Eigen/Sparse>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iostream>
#include <limits>
#include <stdexcept>
#include <string>
#include <vector>

#include "adapters/brusselator.hpp"
#include "phistep/sparse.hpp"
#include "support/catch.hpp"

using namespace phistep;

static long reductions = 0;
// MPI's profiling interface: this one is called, and counts.
#undef MPI_Allreduce  // PETSc counts by a macro
extern "C" int MPI_Allreduce(const void* mine, void* all, int n, MPI_Datatype type, MPI_Op op, MPI_Comm comm) {
  ++reductions;
  return PMPI_Allreduce(mine, all, n, type, op, comm);
}

namespace {
using Handle = Grid::Field::Handle;
template <class F>
struct Force : HandleForce<Grid::Field::Ops, F> {
  using HandleForce<Grid::Field::Ops, F>::HandleForce;
};
template <class F>
Force(F) -> Force<F>;
int rank() {
  int mine = 0;
  MPI_Comm_rank(MPI_COMM_WORLD, &mine);
  return mine;
}
int ranks() {
  int all = 0;
  MPI_Comm_size(MPI_COMM_WORLD, &all);
  return all;
}
/// This rank's last number of y becomes f of itself.
void spoil(const Grid& grid, Handle y, auto&& f) {
  double* last = nullptr;
  grid.for_each(y, [&](int, int, int, double& x) { last = &x; });
  *last = f(*last);
}
/// The largest difference to a state of Eigen's, whole on every rank.
double difference(const Grid& grid, const Grid::Field& y, const Eigen::VectorXd& other) {
  double most = 0;
  grid.for_each(y.handle(), [&](int j, int i, int c, const double& x) {
    most = std::max(most, std::abs(x - other[2 * (j * N + i) + c]));
  });
  Grid::Field::Ops::greatest(y.handle(), std::span<double>{&most, 1});
  return most;
}
/// The same on one of Eigen's vectors.
struct Whole {
  static Eigen::VectorXd start() {
    Eigen::VectorXd y(2 * N * N);
    for (int j = 0; j < N; ++j)
      for (int i = 0; i < N; ++i) y[2 * (j * N + i)] = u0(j), y[2 * (j * N + i) + 1] = v0(i);
    return y;
  }
  static int at(int j, int i) { return 2 * ((j + N) % N * N + (i + N) % N); }
  Eigen::VectorXd operator()(const Eigen::VectorXd& y) const {
    Eigen::VectorXd out(y.size());
    for (int j = 0; j < N; ++j)
      for (int i = 0; i < N; ++i)
        reaction([&](int dj, int di, int c) { return y[at(j + dj, i + di) + c]; }, out[at(j, i)], out[at(j, i) + 1]);
    return out;
  }
  static Eigen::SparseMatrix<double> jacobian(const Eigen::VectorXd& y) {
    std::vector<Eigen::Triplet<double>> entries;
    for (int j = 0; j < N; ++j)
      for (int i = 0; i < N; ++i) {
        const int k = at(j, i);
        const double u = y[k], v = y[k + 1], c = diffusion;
        entries.insert(entries.end(), {{k, k, 2 * u * v - 4.4 - 4 * c},
                                       {k, k + 1, u * u},
                                       {k + 1, k, 3.4 - 2 * u * v},
                                       {k + 1, k + 1, -u * u - 4 * c}});
        for (const int other : {at(j, i + 1), at(j, i - 1), at(j + 1, i), at(j - 1, i)})
          entries.insert(entries.end(), {{k, other, c}, {k + 1, other + 1, c}});
      }
    Eigen::SparseMatrix<double> J(2 * N * N, 2 * N * N);
    J.setFromTriplets(entries.begin(), entries.end());
    return J;
  }
};

/// @param control, of_vectors  they ask for the same
void compare(const Grid& grid, const auto& scheme, double tolerated, const tolerance& control,
             const tolerance& of_vectors) {
  Grid::Field y = grid.start();
  PhiStepper stepper{y, Force{[&](Handle x, Handle out) { grid.rate(x, out); }}, scheme,
                     newton(grid.solver(), {.linear_rtol = 1e-13})};
  const RunReport report = integrate(stepper, y, {0.0, 1.0}, control);
  Eigen::VectorXd z = Whole::start();
  PhiStepper like{z, Whole{}, scheme, newton<Eigen::SparseLU<Eigen::SparseMatrix<double>>>()};
  const RunReport expected = integrate(like, z, {0.0, 1.0}, of_vectors);
  REQUIRE(report);
  CHECK(report.statistics.steps == expected.statistics.steps);
  CHECK(report.statistics.rejections == expected.statistics.rejections);
  CHECK(report.statistics.force_calls == expected.statistics.force_calls);
  CHECK(report.statistics.jacobians == expected.statistics.jacobians);
  CHECK(difference(grid, y, z) <= tolerated * z.lpNorm<Eigen::Infinity>());
}

void compare(const Grid& grid, const auto& scheme, double tolerated) {
  const tolerance control{.rtol = 1e-4, .atol = 1e-4};
  compare(grid, scheme, tolerated, control, control);
}

enum class Fault { none, not_a_number, exception, error_code };
/// The rate, with a fault on one rank from one of its calls on, until it is mended.
struct Faulty {
  const Grid* grid;
  Fault fault;
  int on_rank, at_call;
  const bool* is_mended;
  int calls = 0;
  int operator()(Handle y, Handle out) {
    grid->rate(y, out);
    if (calls++ < at_call || rank() != on_rank || *is_mended) return 0;
    if (fault == Fault::exception) throw std::runtime_error("rank " + std::to_string(on_rank));
    if (fault == Fault::error_code) return some_error_code;
    spoil(*grid, out, [](double) { return std::numeric_limits<double>::quiet_NaN(); });
    return 0;
  }
};
bool same_bits_on_all(const Grid::Field& a, const Grid::Field& b) {
  return Grid::Field::Ops::equal(a.handle(), b.handle());
}
/// Ranks that wait for each other for ever end here, and one of them is heard.
void watch_ranks() {
  alarm(240);
  if (rank() != 0) std::cout.setstate(std::ios::failbit);
}
bool all_alike(int mine) {
  int most = 0, least = 0;
  MPI_Allreduce(&mine, &most, 1, MPI_INT, MPI_MAX, MPI_COMM_WORLD);
  MPI_Allreduce(&mine, &least, 1, MPI_INT, MPI_MIN, MPI_COMM_WORLD);
  return most == least;
}

/// Steps until a fault shows: on all ranks at the same step, with the state as it was before.
void meet(const auto& scheme, Fault fault, int on_rank, int at_call) {
  CAPTURE(static_cast<int>(fault), on_rank, at_call);
  const Grid grid;
  Grid::Field y = grid.start(), before = y;
  bool is_mended = false;
  PhiStepper stepper{y, Force{Faulty{&grid, fault, on_rank, at_call, &is_mended}}, scheme, newton(grid.solver())};
  Outcome outcome = Outcome::success;
  bool thrown = false;
  int steps = 0;
  double t = 0;
  for (; steps < 20 && outcome == Outcome::success && !thrown; ++steps) {
    before = y;
    try {
      outcome = stepper.step(y, t, 0.002).outcome();
    } catch (const std::exception& error) {
      thrown = true;
    }
    if (!thrown && outcome == Outcome::success) t += 0.002;
  }
  CHECK(all_alike(steps));
  CHECK(same_bits_on_all(y, before));
  if (fault == Fault::not_a_number) {
    CHECK_FALSE(thrown);
    CHECK(all_alike(static_cast<int>(outcome)));
    // Not where the force itself was NaN, it made the state so.
    CAPTURE(describe(outcome));
    CHECK((outcome == Outcome::non_finite_force || outcome == Outcome::non_finite_state));
  } else {
    CHECK(thrown == (rank() == on_rank));
    if (!thrown) CHECK(outcome == Outcome::exception_elsewhere);
  }
  is_mended = true;
  const bool goes_on = static_cast<bool>(stepper.step(y, t, 0.002));
  CHECK(goes_on);
  Grid::Field z = before;
  PhiStepper anew{z, Force{Faulty{&grid, Fault::none, 0, 0, &is_mended}}, scheme, newton(grid.solver())};
  const bool does = static_cast<bool>(anew.step(z, t, 0.002));
  CHECK(does);
  CHECK(same_bits_on_all(y, z));
}
void meet_all(const auto& scheme, int calls) {
  for (const Fault fault : {Fault::not_a_number, Fault::exception, Fault::error_code})
    for (int on_rank = 0; on_rank < ranks(); ++on_rank)
      for (int at_call = 0; at_call < calls; ++at_call) meet(scheme, fault, on_rank, at_call);
}
/// The grid's solver, which fails on one rank in one of its calls.
struct FaultySolver {
  static constexpr bool is_field_solver = true;
  decltype(std::declval<const Grid&>().solver()) good;
  bool throws;
  int on_rank, at_call;
  int calls = 0;
  Outcome told(Outcome outcome, Outcome wrong) {
    if (calls++ != at_call || rank() != on_rank) return outcome;
    if (throws) throw std::runtime_error("the solver of this rank");
    return wrong;
  }
  Outcome linearize(double t, const Grid::Field& y) { return told(good.linearize(t, y), Outcome::non_finite_jacobian); }
  Outcome factorize(const Gamma<double>& gamma) { return told(good.factorize(gamma), Outcome::singular_matrix); }
  Outcome solve(Grid::Field& x, double rtol) { return told(good.solve(x, rtol), Outcome::linear_solver_failed); }
  [[nodiscard]] auto iterations() const { return good.iterations(); }
  [[nodiscard]] const char* name() const { return good.name(); }
};
/// A run, controlled or not, whose solver fails once on one rank: all ranks end it alike.
void meet_solver(const auto& scheme, bool is_controlled, bool throws, int on_rank, int at_call) {
  CAPTURE(is_controlled, throws, on_rank, at_call);
  const Grid grid;
  Grid::Field y = grid.start();
  const Grid::Field before = y;
  PhiStepper stepper{y, Force{[&](Handle x, Handle out) { grid.rate(x, out); }}, scheme,
                     newton(FaultySolver{grid.solver(), throws, on_rank, at_call})};
  RunReport report;
  bool thrown = false;
  try {
    if (is_controlled) report = integrate(stepper, y, {0.0, 0.02}, tolerance{.rtol = 1e-3, .atol = 1e-3});
    else report = integrate(stepper, y, {0.0, 0.02}, fixed(0.02));
  } catch (const std::runtime_error&) {
    thrown = true;
  }
  CHECK(thrown == (throws && rank() == on_rank));
  if (throws && !thrown) CHECK(report.outcome == Outcome::exception_elsewhere);
  if (!throws) {
    CHECK(all_alike(static_cast<int>(report.outcome)));
    CHECK(all_alike(static_cast<int>(report.statistics.linear_iterations)));
    CHECK(all_alike(static_cast<int>(report.statistics.factorizations)));
    if (is_controlled) CHECK(report);  // a shorter step
  }
  if (!is_controlled && (throws || !report)) CHECK(same_bits_on_all(y, before));
}
}  // namespace

TEST_CASE("a field on ranks takes the steps of Eigen's vectors, to 12 digits") {
  const Grid grid;
  compare(grid, rodas4, 1e-12);
  compare(grid, rodas5p, 1e-12);
  compare(grid, tsit5, 1e-12);
}
TEST_CASE("absolute tolerances of each number on ranks are those of Eigen's vectors") {
  const Grid grid;
  Grid::Field each = grid.start();
  std::vector<double> of_vectors(static_cast<std::size_t>(2 * N * N));
  for (int k = 0; k < 2 * N * N; ++k) of_vectors[static_cast<std::size_t>(k)] = 1e-6 * (1 + k % 7) * (k % 2 + 1);
  grid.for_each(each.handle(),
                [&](int j, int i, int c, double& x) { x = of_vectors[static_cast<std::size_t>(2 * (j * N + i) + c)]; });
  const tolerance control{.rtol = 1e-4, .atol = each}, like{.rtol = 1e-4, .atol = of_vectors};
  compare(grid, rodas4, 1e-12, control, like);
  // One rank's wrong one is wrong for all.
  if (rank() == ranks() - 1) spoil(grid, each.handle(), [](double x) { return -x; });
  Grid::Field y = grid.start();
  PhiStepper stepper{y, Force{[&](Handle x, Handle out) { grid.rate(x, out); }}, rodas4, newton(grid.solver())};
  CHECK(integrate(stepper, y, {0.0, 1.0}, tolerance{.atol = each}).outcome == Outcome::invalid_tolerance);
}
TEST_CASE("a solver that fails on one rank fails on all") {
  for (const bool is_controlled : {true, false})
    for (const bool throws : {true, false})
      for (int on_rank = 0; on_rank < ranks(); ++on_rank) {
        for (int at_call = 0; at_call < 8; ++at_call) meet_solver(rodas4, is_controlled, throws, on_rank, at_call);
        for (int at_call = 0; at_call < 5; ++at_call) meet_solver(trapezoidal, is_controlled, throws, on_rank, at_call);
      }
}
TEST_CASE("fixed-point iteration on ranks: the digits of Eigen's vectors, and one reduction a step") {
  const Grid grid;
  Grid::Field y = grid.start();
  Eigen::VectorXd z = Whole::start();
  PhiStepper stepper{y, Force{[&](Handle x, Handle out) { grid.rate(x, out); }}, trapezoidal, fixed_point()};
  PhiStepper like{z, Whole{}, trapezoidal, fixed_point({.depth = 0})};
  bool good = true;
  for (int k = 0; k < 10; ++k) good = stepper.step(y, k * 1e-4, 1e-4) && like.step(z, k * 1e-4, 1e-4) && good;
  CHECK(good);
  CHECK(difference(grid, y, z) <= 1e-12 * z.lpNorm<Eigen::Infinity>());
  const long before = reductions;
  for (int k = 10; k < 30; ++k) good = static_cast<bool>(stepper.step(y, k * 1e-4, 1e-4)) && good;
  CHECK(good);
  CHECK(reductions - before <= 22);  // here and there one more, where rounding asks for another iteration
  for (const Fault fault : {Fault::not_a_number, Fault::exception})
    for (int on_rank = 0; on_rank < ranks(); ++on_rank)
      for (int at_call : {0, 1, 5, 9}) {
        CAPTURE(on_rank, at_call);
        Grid::Field x = grid.start(), at_start = x;
        const bool is_mended = false;
        PhiStepper faulty{x, Force{Faulty{&grid, fault, on_rank, at_call, &is_mended}}, trapezoidal, fixed_point()};
        Outcome outcome = Outcome::success;
        bool thrown = false;
        for (int k = 0; k < 10 && outcome == Outcome::success && !thrown; ++k) {
          at_start = x;
          try {
            outcome = faulty.step(x, k * 1e-4, 1e-4).outcome();
          } catch (const std::runtime_error&) {
            thrown = true;
          }
        }
        CHECK(thrown == (fault == Fault::exception && rank() == on_rank));
        if (!thrown) CHECK(outcome != Outcome::success);
        CHECK(same_bits_on_all(x, at_start));
      }
}
TEST_CASE("whatever goes wrong on one rank, all ranks end the step alike") {
  meet_all(trapezoidal, 6);
  meet_all(rodas4, 8);
  meet_all(tsit5, 8);
}
TEST_CASE("an exception on one rank ends the run of all") {
  for (int on_rank = 0; on_rank < ranks(); ++on_rank)
    for (int at_call : {0, 1, 2, 3, 7, 30}) {
      CAPTURE(on_rank, at_call);
      const Grid grid;
      Grid::Field y = grid.start();
      const bool is_mended = false;
      PhiStepper stepper{y, Force{Faulty{&grid, Fault::exception, on_rank, at_call, &is_mended}}, rodas4,
                         newton(grid.solver())};
      bool thrown = false;
      RunReport report;
      try {
        report = integrate(stepper, y, {0.0, 1.0}, tolerance{.rtol = 1e-3, .atol = 1e-3});
      } catch (const std::runtime_error&) {
        thrown = true;
      }
      CHECK(thrown == (rank() == on_rank));
      if (!thrown) CHECK(report.outcome == Outcome::exception_elsewhere);
    }
}
TEST_CASE("an edit on one rank is an edit on all") {
  const Grid grid;
  for (int on_rank = 0; on_rank < ranks(); ++on_rank) {
    Grid::Field y = grid.start();
    PhiStepper stepper{y, Force{[&](Handle x, Handle out) { grid.rate(x, out); }}, phi(0.7), newton(grid.solver())};
    bool good = static_cast<bool>(stepper.step(y, 0.0, 0.002));
    if (rank() == on_rank) {
      spoil(grid, y.handle(), [](double x) { return x + 0.5; });
    }
    Grid::Field z = y;
    good = stepper.step(y, 0.002, 0.002) && good;
    PhiStepper anew{z, Force{[&](Handle x, Handle out) { grid.rate(x, out); }}, phi(0.7), newton(grid.solver())};
    good = anew.step(z, 0.002, 0.002) && good;
    CHECK(good);
    z -= y;
    CHECK(max_abs(z) <= 1e-4);
  }
}
TEST_CASE("a run resumes from the parts of all ranks, with the same bits, or on none of them") {
  const auto file = std::filesystem::temp_directory_path() / ("phistep_" + std::string(library) + "_checkpoint");
  const Grid grid;
  const auto force = [&grid](Handle x, Handle out) { grid.rate(x, out); };
  const auto resume = [&](const auto& scheme, int steps) {
    Grid::Field y = grid.start(), z = y;
    z *= 2;
    PhiStepper stepper{y, Force{force}, scheme, newton(grid.solver())};
    Run run{stepper, y, {0.0, 0.3}, tolerance{.rtol = 1e-4, .atol = 1e-4}};
    for (int k = 0; k < steps; ++k) run.advance();
    save_on_ranks(y, file, run);
    PhiStepper anew{z, Force{force}, scheme, newton(grid.solver())};
    Run resumed{anew, z, {0.0, 0.3}, tolerance{.rtol = 1e-4, .atol = 1e-4}};
    const bool is_there = load_on_ranks(z, file, resumed);
    CHECK(is_there);
    CHECK(same_bits_on_all(y, z));
    const RunReport expected = run.finish(), report = resumed.finish();
    CHECK(report.statistics.steps == expected.statistics.steps);
    CHECK(report.statistics.linear_iterations == expected.statistics.linear_iterations);
    CHECK(same_bits_on_all(y, z));
  };
  resume(rodas4, 5);
  resume(trapezoidal, 9);
  resume(tsit5, 9);

  // What one rank lacks, nobody reads.
  detail::RankManifest manifest;
  static_cast<void>(load_checkpoint(file, manifest));
  const int last = ranks() - 1;
  Grid::Field y = grid.start();
  const Grid::Field before = y;
  MPI_Barrier(MPI_COMM_WORLD);
  if (rank() == last) std::filesystem::remove(manifest.part(file, last));
  CHECK_THROWS_AS(load_on_ranks(y, file, y), CheckpointError);
  CHECK(same_bits_on_all(y, before));
}
TEST_CASE("how often the ranks wait for each other") {
  const Grid grid;
  Grid::Field y = grid.start();
  PhiStepper euler{y, Force{[&](Handle x, Handle out) { grid.rate(x, out); }}, forward_euler};
  REQUIRE(euler.step(y, 0.0, 1e-4));  // the vectors are made
  const long before = reductions;
  for (int k = 1; k < 11; ++k) REQUIRE(euler.step(y, k * 1e-4, 1e-4));
  CHECK(reductions - before == 10);  // whether all of y is finite
}

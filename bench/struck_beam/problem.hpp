/// @file
/// A clamped beam of 200 Hermite elements with consistent mass, struck at its tip: M r'' = −K r, L = EI = ρA = 1. The blow puts as
/// much into each mode, up to 7e5 times as fast as the first; the first three are wanted, the others are noise.
#pragma once

#include <Eigen/Eigenvalues>
#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <functional>
#include <limits>
#include <string>
#include <utility>
#include <vector>

namespace struck_beam {

using Vec = Eigen::VectorXd;
using Sparse = Eigen::SparseMatrix<double>;
inline constexpr int elements = 200, n = 2 * elements, tip = n - 2, wanted = 3;

struct Beam {
  Sparse K{n, n}, M{n, n};
  Vec omega, at_tip, v0;
  Eigen::MatrixXd seen;
  double period, t1;

  Beam() {
    const double h = 1.0 / elements;
    Eigen::Matrix4d k, m;
    k << 12, 6 * h, -12, 6 * h, 6 * h, 4 * h * h, -6 * h, 2 * h * h, -12, -6 * h, 12, -6 * h, 6 * h, 2 * h * h, -6 * h,
        4 * h * h;
    m << 156, 22 * h, 54, -13 * h, 22 * h, 4 * h * h, 13 * h, -3 * h * h, 54, 13 * h, 156, -22 * h, -13 * h, -3 * h * h,
        -22 * h, 4 * h * h;
    std::vector<Eigen::Triplet<double>> of_k, of_m;
    for (int e = 0; e < elements; ++e)
      for (int i = 0; i < 4; ++i)
        for (int j = 0; j < 4; ++j)
          if (const int row = 2 * e - 2 + i, column = 2 * e - 2 + j; row >= 0 && column >= 0) {
            of_k.emplace_back(row, column, k(i, j) / (h * h * h));
            of_m.emplace_back(row, column, h / 420 * m(i, j));
          }
    K.setFromTriplets(of_k.begin(), of_k.end());
    M.setFromTriplets(of_m.begin(), of_m.end());
    const Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::MatrixXd> all{Eigen::MatrixXd(K), Eigen::MatrixXd(M)};
    omega = all.eigenvalues().head(wanted).cwiseSqrt();
    at_tip = all.eigenvectors().row(tip).head(wanted);
    seen = all.eigenvectors().leftCols(wanted).transpose() * M;
    v0 = Eigen::SimplicialLDLT<Sparse>(M).solve(Vec::Unit(n, tip));
    period = 2 * std::acos(-1.0) / omega[0];
    t1 = 5 * period;
  }
};

/// What a run's states at 500 times a period say.
struct Seen {
  const Beam& beam;
  double error = 0, largest = 0, noise = 0, size = 0;
  std::vector<double> way{};  ///< of the tip in the modes that are wanted
  void operator()(double t, const auto& r, const auto& v) {
    double exact = 0;
    for (int i = 0; i < wanted; ++i)
      exact += beam.at_tip[i] * beam.at_tip[i] * std::sin(beam.omega[i] * t) / beam.omega[i];
    way.push_back(beam.at_tip.dot(beam.seen * r));
    error = std::max(error, std::abs(way.back() - exact));
    largest = std::max(largest, std::abs(exact));
    const double slow = beam.at_tip.dot(beam.seen * v);
    if (t > beam.t1 - beam.period) noise += (v[tip] - slow) * (v[tip] - slow), size += slow * slow;
  }
};

struct Result {
  double error, noise, seconds;
  long long steps;
  std::vector<double> way{};
};
/// The best time of three (of a run of seconds: of one), without the looks at states: `go(look)` runs, and calls look(t, r, v)
/// where there is one.
inline Result timed(const Beam& beam, const std::function<long long(Seen*)>& go) {
  Seen seen{beam};
  Result result{1, 0, std::numeric_limits<double>::infinity(), go(&seen)};
  result.error = seen.error / seen.largest;
  result.noise = std::sqrt(seen.noise / seen.size);
  for (int k = 0; k < 3 && !(result.seconds > 1 && result.seconds < 1e300); ++k) {
    const auto start = std::chrono::steady_clock::now();
    static_cast<void>(go(nullptr));
    result.seconds =
        std::min(result.seconds, std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
  }
  for (double& r : seen.way) r /= seen.largest;
  result.way = std::move(seen.way);
  if (!(seen.size > 0)) result.error = result.noise = 1;  // it did not come to the end
  return result;
}
/// A row: the runs of a method from coarse to fine.
struct Row {
  std::string name;
  std::vector<Result> runs;
};

/// Each in a file of its own; without its library it adds nothing.
void cvode(const Beam& beam, std::vector<Row>& rows);
void petsc(const Beam& beam, std::vector<Row>& rows, double rho, int count);

}  // namespace struck_beam

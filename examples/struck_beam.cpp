// A clamped beam struck at its tip: order 2 and damping by one number.
//
// 200 Hermite elements with their consistent mass, M r'' = −K r. The blow puts as much motion into the modes that elements and Δt
// can't resolve, up to 7e5 times as fast as the first, as into those that one wants to hear. The trapezoidal rule (φ = ½) keeps
// them for ever: the tip's velocity is noise. Backward Euler (φ = 1) takes them out, and the wanted modes as well: it is of
// order 1. generalized_alpha(ρ∞) takes them out, is of order 2, and costs one solve a step; tr_bdf2 costs two.
//
// Run: struck_beam [--short] [--out DIR]        Picture: python3 plot/plot_struck_beam.py [DIR]
#include <Eigen/Eigenvalues>
#include <phistep/phistep.hpp>
#include <phistep/sparse.hpp>

#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

#include "command_line.hpp"

using Vec = Eigen::VectorXd;
using Sparse = Eigen::SparseMatrix<double>;

constexpr double length = 1, bending = 175, line_mass = 0.785,
                 blow = 0.01;  // [m] [N m²] [kg/m] [N s]: steel, 1 cm square
constexpr int elements = 200, unknowns = 2 * elements, tip = unknowns - 2,
              wanted = 3;  // deflection and slope of each node but the first

/// K and M of Hermite's cubic elements.
std::pair<Sparse, Sparse> beam() {
  const double h = length / elements;
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
          of_k.emplace_back(row, column, bending / (h * h * h) * k(i, j));
          of_m.emplace_back(row, column, line_mass * h / 420 * m(i, j));
        }
  Sparse K(unknowns, unknowns), M(unknowns, unknowns);
  K.setFromTriplets(of_k.begin(), of_k.end()), M.setFromTriplets(of_m.begin(), of_m.end());
  return {K, M};
}

int main(int argc, char** argv) {
  const CommandLine options(argc, argv);
  const auto [K, M] = beam();
  const Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::MatrixXd> all{Eigen::MatrixXd(K), Eigen::MatrixXd(M)};
  const Vec omega = all.eigenvalues().head(wanted).cwiseSqrt(), at_tip = all.eigenvectors().row(tip).head(wanted);
  const Eigen::MatrixXd seen =
      all.eigenvectors().leftCols(wanted).transpose() * M;  // amplitudes of a motion's wanted modes
  const double period = 2 * M_PI / omega[0], t1 = 5 * period, fastest = std::sqrt(all.eigenvalues()[unknowns - 1]);
  std::printf("First mode: %.1f Hz; the fastest is %.0e times as fast.\n\n", omega[0] / (2 * M_PI), fastest / omega[0]);
  std::printf("%-24s %8s | %14s %14s %8s\n", "", "T1 / dt", "tip r, error", "tip v, noise", "solves");

  auto file = options.file("struck_beam.csv");
  file << "scheme,t_s,v_m_s,wanted_m_s\n";
  double errors[4] = {}, noises[4] = {};
  int row = 0;
  const auto run = [&](const char* name, auto scheme, int steps) {
    phistep::Motion<Vec> y{Vec::Zero(unknowns),
                           blow * Eigen::SimplicialLDLT<Sparse>(M).solve(Vec::Unit(unknowns, tip))};
    phistep::PhiStepper stepper{y, phistep::symmetric(phistep::linear(Sparse(-K))), scheme, phistep::mass(M)};
    double error = 0, largest = 0, noise = 0, size = 0;
    const auto report =
        phistep::integrate(stepper, y, {0, t1}, phistep::fixed(period / steps), [&](double t, const auto& now) {
          const Vec turned = omega * t, swing = blow * at_tip.cwiseAbs2();
          const double r = (swing.array() * turned.array().sin() / omega.array()).sum();
          error = std::max(error, std::abs(at_tip.dot(seen * now.r) - r)), largest = std::max(largest, std::abs(r));
          const double v = at_tip.dot(seen * now.v);
          if (t > t1 - period) noise += std::pow(now.v[tip] - v, 2), size += v * v;
          file << name << ',' << t << ',' << now.v[tip] << ',' << (swing.array() * turned.array().cos()).sum() << '\n';
        });
    errors[row] = error / largest, noises[row] = std::sqrt(noise / size);
    std::printf("%-24s %8d | %12.2f %% %12.0f %% %8lld\n", name, steps, 100 * errors[row], 100 * noises[row],
                static_cast<long long>(report.statistics.solves));
    ++row;
  };
  const int steps = options.is_short ? 400 : 2000;
  run("trapezoidal", phistep::trapezoidal, steps);
  run("backward_euler", phistep::backward_euler, steps);
  run("tr_bdf2", phistep::tr_bdf2, steps / 2);
  run("generalized_alpha(0.5)", phistep::generalized_alpha(0.5), steps);
  const bool as_expected = noises[3] < noises[0] / 10 && errors[3] < errors[1] / 2;
  std::printf("\nError of the tip in its first %d modes, and what else is in its velocity in the last period.%s\n",
              wanted, as_expected ? "" : " They are not what theory asks for.");
  return as_expected ? 0 : 1;
}

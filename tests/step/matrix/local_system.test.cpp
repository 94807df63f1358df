// One small block a particle: the same answers as the dense matrix.
#include <phistep/step/matrix/dense_system.hpp>

#include <limits>
#include <random>

#include "support/catch.hpp"

using namespace phistep;
using Vec = Eigen::VectorXd;
using Mat = Eigen::MatrixXd;

namespace {

/// W = M − γ (C + γ_d K) by blocks, and a right-hand side.
struct Problem {
  static constexpr double gamma = 0.3, drift = 0.7;
  int particles, d;
  Mat K, C, W;
  Vec b;
  Problem(int count, int size) : particles{count}, d{size} {
    std::mt19937 random(static_cast<unsigned>(17 * d + particles));
    std::normal_distribution<double> normal;
    const int n = particles * d;
    K = C = W = Mat::Zero(n, n);
    for (int i = 0; i < n; ++i) W(i, i) = 1 + i % 3;
    for (int p = 0; p < particles; ++p)
      for (int i = p * d; i < p * d + d; ++i)
        for (int j = p * d; j < p * d + d; ++j) {
          K(i, j) = normal(random), C(i, j) = normal(random);
          W(i, j) -= gamma * (C(i, j) + drift * K(i, j));
        }
    b.resize(n);
    for (double& x : b) x = normal(random);
  }
};
struct Solved {
  Outcome factorized, solved;
  Statistics statistics;
  double drift_share;
  Vec x;
};
template <class Scalar, int d>
Solved solve(const Problem& problem) {
  const int n = problem.particles * d;
  LocalSystem<Scalar, d, true, true> system;
  system.resize(n);
  for (int p = 0; p < problem.particles; ++p)
    for (int i = p * d; i < p * d + d; ++i)
      for (int j = p * d; j < p * d + d; ++j) {
        system.position(i, j, static_cast<Scalar>(problem.K(i, j)));
        system.velocity(i, j, static_cast<Scalar>(problem.C(i, j)));
      }
  const auto masses = [n](auto&& put) {
    for (int i = 0; i < n; ++i) put(i, i, 1.0 + i % 3);
  };
  Solved out;
  out.factorized = system.factorize(masses, static_cast<Scalar>(Problem::gamma), static_cast<Scalar>(Problem::drift),
                                    out.statistics);
  out.drift_share = static_cast<double>(system.drift_share());
  Eigen::Matrix<Scalar, Eigen::Dynamic, 1> x = problem.b.cast<Scalar>();
  out.solved = system.solve(x);
  out.x = x.template cast<double>();
  return out;
}

void check_against_dense(const Problem& problem, const Solved& got, double epsilon) {
  const int d = problem.d;
  REQUIRE(got.factorized == Outcome::success);
  CHECK(got.statistics.factorizations == 1);
  CHECK(got.drift_share > 0);
  REQUIRE(got.solved == Outcome::success);
  // Backward error of LU with row pivoting: growth 2^(d-1) at worst, d u each; inputs rounded to Scalar once.
  const double bound = 8.0 * d * (1 << (d - 1)) * epsilon;
  for (int p = 0; p < problem.particles; ++p) {
    const Mat block = problem.W.block(p * d, p * d, d, d);
    const Vec one = got.x.segment(p * d, d), b = problem.b.segment(p * d, d);
    CHECK((block * one - b).norm() <= bound * (block.norm() * one.norm() + b.norm()));
  }
}

}  // namespace

TEMPLATE_TEST_CASE_SIG("blocks of 1 to 7 rows solve as the dense matrix does", "", ((int d), d), 1, 2, 3, 4, 5, 6, 7) {
  for (const int particles : {1, 7, 8, 9, 100}) {
    const Problem problem(particles, d);
    check_against_dense(problem, solve<double, d>(problem), std::numeric_limits<double>::epsilon());
    check_against_dense(problem, solve<float, d>(problem), std::numeric_limits<float>::epsilon());
  }
}

TEST_CASE("rows are exchanged where a pivot is zero") {
  LocalSystem<double, 2, true, false> system;
  system.resize(2);
  system.position(0, 0, 1);  // W = 1 − K = (0 1; 1 1)
  system.position(0, 1, -1);
  system.position(1, 0, -1);
  Statistics statistics;
  const auto unit = [](auto&& put) { put(0, 0, 1), put(1, 1, 1); };
  REQUIRE(system.factorize(unit, 1.0, 1.0, statistics) == Outcome::success);
  Vec x(2);
  x << 3, 5;
  REQUIRE(system.solve(x) == Outcome::success);
  CHECK(x[0] == Approx(2));
  CHECK(x[1] == Approx(3));
}

TEST_CASE("a heavy particle doesn't hide how stiff the others are") {
  LocalSystem<double, 2, true, false> system;
  system.resize(4);
  for (int i = 0; i < 4; ++i) system.position(i, i, -1e4);
  Statistics statistics;
  const auto masses = [](auto&& put) { put(0, 0, 1), put(1, 1, 1), put(2, 2, 1e12), put(3, 3, 1e12); };
  REQUIRE(system.factorize(masses, 1.0, 1.0, statistics) == Outcome::success);
  CHECK(system.drift_share() == Approx(1e4 / (1 + 1e4)));
}

TEST_CASE("a singular block and one that isn't finite are named") {
  LocalSystem<double, 3, true, false> system;
  system.resize(30);
  const auto unit = [](auto&& put) {
    for (int i = 0; i < 30; ++i) put(i, i, 1);
  };
  Statistics statistics;
  SECTION("singular") {
    for (int i = 12; i < 15; ++i) system.position(i, i, 1);
    CHECK(system.factorize(unit, 1.0, 1.0, statistics) == Outcome::singular_matrix);
    CHECK(system.singular_particle() == 4);
  }
  SECTION("not finite") {
    system.position(22, 21, std::numeric_limits<double>::infinity());
    CHECK_FALSE(system.is_finite());
    CHECK(system.factorize(unit, 1.0, 1.0, statistics) == Outcome::singular_matrix);
    CHECK(system.singular_particle() == 7);
  }
}

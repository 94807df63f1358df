// One small block a particle: the same answers as the dense matrix.
#include <phistep/resolve/local_system.hpp>

#include <Eigen/LU>

#include <limits>
#include <random>

#include "support/catch.hpp"

using namespace phistep;
using Vec = Eigen::VectorXd;
using Mat = Eigen::MatrixXd;

namespace {

template <class Scalar, int d>
void check_against_dense(int particles) {
  std::mt19937 random(static_cast<unsigned>(17 * d + particles));
  std::normal_distribution<double> normal;
  const int n = particles * d;
  LocalSystem<Scalar, d, true, true> system;
  system.resize(n);
  const double gamma = 0.3, drift = 0.7;
  Mat W = Mat::Zero(n, n);
  for (int i = 0; i < n; ++i) W(i, i) = 1 + i % 3;
  for (int p = 0; p < particles; ++p)
    for (int i = p * d; i < p * d + d; ++i)
      for (int j = p * d; j < p * d + d; ++j) {
        const double K = normal(random), C = normal(random);
        system.position(i, j, static_cast<Scalar>(K));
        system.velocity(i, j, static_cast<Scalar>(C));
        W(i, j) -= gamma * (C + drift * K);
      }
  Vec b(n);
  for (double& x : b) x = normal(random);
  Statistics statistics;
  const auto masses = [n](auto&& put) {
    for (int i = 0; i < n; ++i) put(i, i, 1.0 + i % 3);
  };
  REQUIRE(system.factorize(masses, static_cast<Scalar>(gamma), static_cast<Scalar>(drift), statistics) ==
          Outcome::success);
  CHECK(statistics.factorizations == 1);
  CHECK(system.drift_share() > 0);
  Eigen::Matrix<Scalar, Eigen::Dynamic, 1> x = b.cast<Scalar>();
  REQUIRE(system.solve(x) == Outcome::success);
  // Backward error of LU with row pivoting: growth 2^(d-1) at worst, d u each; inputs rounded to Scalar once.
  const double bound = 8.0 * d * (1 << (d - 1)) * static_cast<double>(std::numeric_limits<Scalar>::epsilon());
  for (int p = 0; p < particles; ++p) {
    const Mat block = W.block(p * d, p * d, d, d);
    const Vec one = x.template cast<double>().segment(p * d, d);
    CHECK((block * one - b.segment(p * d, d)).norm() <=
          bound * (block.norm() * one.norm() + b.segment(p * d, d).norm()));
  }
}

}  // namespace

TEMPLATE_TEST_CASE_SIG("blocks of 1 to 7 rows solve as the dense matrix does", "", ((int d), d), 1, 2, 3, 4, 5, 6, 7) {
  for (const int particles : {1, 7, 8, 9, 100}) {
    check_against_dense<double, d>(particles);
    check_against_dense<float, d>(particles);
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

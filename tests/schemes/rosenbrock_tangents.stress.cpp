// Rosenbrock schemes with dense, banded and sparse tangents, on problems of their own; in short:
// rosenbrock.test.cpp.
#include <phistep/sparse.hpp>

#include <cmath>

#include "problems/forced.hpp"
#include "problems/march.hpp"
#include "support/catch.hpp"

using namespace phistep;
using problems::distance;
using problems::march;
using Vec = Eigen::VectorXd;

namespace {

/// (r, v) as one first-order vector.
struct FirstOrderForced {
  using Moved = problems::ForcedMotion<>;
  Eigen::Vector4d operator()(const Eigen::Vector4d& y, double t) const {
    Eigen::Vector4d rate;
    rate << y.tail<2>(), Moved{}(y.head<2>(), y.tail<2>(), t) / Moved::mass;
    return rate;
  }
};

/// A chain of springs and dashpots between walls, with K and C entry by entry: as dense, banded and sparse matrices.
struct Chain : ForceTerm {
  static constexpr bool uses_time = false;
  static double pull(double d) { return 40 * d + 30 * d * d * d; }
  static double slope(double d) { return 40 + 90 * d * d; }
  void add(double, const auto& y, auto& out) const {
    const auto n = y.r.size();
    for (Index i = 0; i <= n; ++i) {
      const double d = (i < n ? y.r[i] : 0) - (i > 0 ? y.r[i - 1] : 0),
                   w = (i < n ? y.v[i] : 0) - (i > 0 ? y.v[i - 1] : 0);
      const double f = pull(d) + 0.7 * w;
      if (i < n) out.force[i] -= f;
      if (i > 0) out.force[i - 1] += f;
    }
  }
  void add_jacobian(double, const auto& y, auto& sink) const {
    const auto n = y.r.size();
    const auto put = [&](Index i, Index j, double k, double c) {
      sink.position(i, j, k);
      sink.velocity(i, j, c);
    };
    for (Index i = 0; i <= n; ++i) {
      const double k = slope((i < n ? y.r[i] : 0) - (i > 0 ? y.r[i - 1] : 0));
      if (i < n) put(i, i, -k, -0.7);
      if (i > 0) put(i - 1, i - 1, -k, -0.7);
      if (i < n && i > 0) put(i, i - 1, k, 0.7), put(i - 1, i, k, 0.7);
    }
  }
};
struct BandedChain : Chain {
  static constexpr Structure structure = Structure::banded;
};
struct SparseChain : Chain {
  static constexpr Structure structure = Structure::sparse;
};

}  // namespace

TEST_CASE("a motion of n unknowns is the first-order system of 2n") {
  using Moved = problems::ForcedMotion<>;
  auto motion = Moved::exact(0);
  Eigen::Vector4d y;
  y << motion.r, motion.v;
  motion = march(PhiStepper{motion, Moved{}, rodas4, mass(Moved::mass)}, motion, 0.0, 1.0, 10);
  y = march(PhiStepper{y, FirstOrderForced{}, rodas4}, y, 0.0, 1.0, 10);
  // Jacobians by differences, of other increments: equal to √u of what they change a step by.
  CHECK((motion.r - y.head<2>()).norm() <= 1e-8);
  CHECK((motion.v - y.tail<2>()).norm() <= 1e-8);
}

TEST_CASE("dense, banded and sparse tangents give the same motion, with masses") {
  constexpr int n = 12;
  const Vec masses = Vec::LinSpaced(n, 1, 3);
  const Motion<Vec> start{Vec::LinSpaced(n, -0.3, 0.2), Vec::Ones(n)};
  const auto run = [&](auto force) {
    auto y = start;
    PhiStepper stepper{y, force, rodas4, mass(masses)};
    return march(stepper, y, 0.0, 1.0, 20);
  };
  const auto dense = run(Chain{}), banded = run(BandedChain{}), sparse = run(SparseChain{});
  CHECK(distance(dense, start) > 0.1);
  CHECK(distance(dense, banded) <= 1e-13);
  CHECK(distance(dense, sparse) <= 1e-13);
}

TEST_CASE("an affine force is linearized once, and factorized again only where dt changes") {
  Vec y = Vec::Ones(3);
  const Eigen::MatrixXd K{{-3.0, 1.0, 0.0}, {1.0, -2.0, 0.5}, {0.0, 0.5, -1.0}};
  PhiStepper stepper{y, linear(K), rodas4};
  for (int k = 0; k < 10; ++k) REQUIRE(stepper.step(y, 0.1 * k, 0.1));
  CHECK(stepper.statistics().jacobians == 1);
  CHECK(stepper.statistics().factorizations == 1);
  REQUIRE(stepper.step(y, 1.0, 0.05));
  CHECK(stepper.statistics().jacobians == 1);
  CHECK(stepper.statistics().factorizations == 2);
}

// Rows find what the loop over springs finds, whatever the order, the mesh and the number of threads.
#include <phistep/base/state/motion.hpp>
#include <phistep/particles/springs/spring_rows.hpp>
#include <phistep/particles/springs/springs.hpp>

#include <Eigen/Core>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <random>

#include "support/catch.hpp"

#ifdef _OPENMP
#include <omp.h>
#endif

using namespace phistep;

namespace spring_rows_cases {

enum class Mesh { grid, diagonals, anyhow };

/// A sheet of side × side particles; with diagonals this way or that, rows differ in length; or springs between anybody.
inline std::vector<Spring> springs_of(Mesh mesh, int side) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> about(0.5, 1.5);
  std::vector<Spring> springs;
  const int n = side * side;
  if (mesh == Mesh::anyhow) {
    for (int s = 0; s < 3 * n; ++s) {
      const auto i = static_cast<int>(random() % static_cast<unsigned>(n));
      const auto j = static_cast<int>(random() % static_cast<unsigned>(n));
      if (i != j) springs.push_back({i, j, about(random), about(random)});
    }
    return springs;
  }
  for (int y = 0; y < side; ++y)
    for (int x = 0; x < side; ++x) {
      const int i = y * side + x;
      if (x + 1 < side) springs.push_back({i, i + 1, 3, 1});
      if (y + 1 < side) springs.push_back({i + side, i, 4, 1});
      if (mesh == Mesh::diagonals && x + 1 < side && y + 1 < side) {
        if (random() % 2) springs.push_back({i, i + side + 1, 2, about(random)});
        else springs.push_back({i + 1, i + side, 2, about(random)});
      }
    }
  return springs;
}

/// The same springs in another order, between particles of which each has another number, below `particles`.
inline std::vector<Spring> renumbered(std::vector<Spring> springs, int particles) {
  std::shuffle(springs.begin(), springs.end(), std::mt19937(1));
  std::vector<std::ptrdiff_t> name(static_cast<std::size_t>(particles));
  std::iota(name.begin(), name.end(), 0);
  std::shuffle(name.begin(), name.end(), std::mt19937(2));
  for (Spring& s : springs) s.i = name[static_cast<std::size_t>(s.i)], s.j = name[static_cast<std::size_t>(s.j)];
  return springs;
}

template <class Scalar, int dim>
struct Points {
  using Vectors = Eigen::Matrix<Scalar, dim, Eigen::Dynamic>;
  Vectors r, v;
  explicit Points(Eigen::Index n) : r(dim, n), v(dim, n) {
    std::mt19937 random(5);
    std::uniform_real_distribution<double> uniform(-1, 1);
    for (Eigen::Index k = 0; k < r.size(); ++k) {
      r.data()[k] = static_cast<Scalar>(uniform(random));
      v.data()[k] = static_cast<Scalar>(uniform(random));
    }
  }
};

inline constexpr double damping = 0.75;

template <class Scalar, int dim, bool damped>
typename Points<Scalar, dim>::Vectors forces(const std::vector<Spring>& springs, const Points<Scalar, dim>& y,
                                             const std::uint8_t* still = nullptr) {
  SpringRows<Scalar, dim, damped> rows;
  rows.build(springs, y.r.cols());
  typename Points<Scalar, dim>::Vectors f = Points<Scalar, dim>::Vectors::Zero(dim, y.r.cols());
  rows.add(y.r.data(), y.v.data(), still, static_cast<Scalar>(damping), f.data());
  return f;
}

/// Largest error in units of its bound. To each spring's pull, rounding adds at most 12 ε (k (ℓ + L) + c|Δv|): its
/// dozen operations work on terms of no more than that; to a sum of n pulls n ε times as much.
template <class Scalar, int dim, bool damped>
double error(const std::vector<Spring>& springs, const Points<Scalar, dim>& y,
             const typename Points<Scalar, dim>::Vectors& f) {
  const Eigen::Matrix<double, dim, Eigen::Dynamic> r = y.r.template cast<double>(), v = y.v.template cast<double>();
  Eigen::Matrix<double, dim, Eigen::Dynamic> right = 0 * r;
  Eigen::VectorXd terms = Eigen::VectorXd::Zero(r.cols()), count = terms;
  for (const Spring& s : springs) {
    const Eigen::Matrix<double, dim, 1> d = r.col(s.j) - r.col(s.i), u = v.col(s.j) - v.col(s.i);
    const double length = d.norm();
    for (const auto end : {s.i, s.j}) {
      terms[end] += s.stiffness * (length + s.length) + damping * u.norm();
      count[end] += 1;
    }
    if (length == 0) continue;
    const double pull = s.stiffness * (length - s.length) + (damped ? damping * d.dot(u) / length : 0);
    right.col(s.i) += pull / length * d;
    right.col(s.j) -= pull / length * d;
  }
  const double epsilon = std::numeric_limits<Scalar>::epsilon();
  double worst = 0;
  for (Eigen::Index i = 0; i < r.cols(); ++i) {
    const double off = (f.col(i).template cast<double>() - right.col(i)).norm();
    if (!(off == 0)) worst = std::max(worst, off / (epsilon * (12 + count[i]) * terms[i]));
  }
  return worst;
}

template <class Scalar, int dim>
void check_rows() {
  for (const Mesh mesh : {Mesh::grid, Mesh::diagonals, Mesh::anyhow})
    for (const int side : {2, 5, 23}) {
      auto springs = springs_of(mesh, side);
      Points<Scalar, dim> y(side * side + 3);  // three without springs
      y.r.col(springs[1].i) = y.r.col(springs[1].j), springs[1].length = 0;
      CHECK(error<Scalar, dim, false>(springs, y, forces<Scalar, dim, false>(springs, y)) <= 1);
      CHECK(error<Scalar, dim, true>(springs, y, forces<Scalar, dim, true>(springs, y)) <= 1);
      springs = renumbered(springs, side * side);
      CHECK(error<Scalar, dim, true>(springs, y, forces<Scalar, dim, true>(springs, y)) <= 1);
    }
}

}  // namespace spring_rows_cases

using namespace spring_rows_cases;

#if PHISTEP_QUICK

TEMPLATE_TEST_CASE_SIG("rows are the loop over springs, but for rounding", "", ((class Scalar, int dim), Scalar, dim),
                       (double, 3), (float, 3)) {
  check_rows<Scalar, dim>();
}

TEMPLATE_TEST_CASE_SIG("particles numbered anyhow: those of a large sheet, some without springs", "",
                       ((class Scalar, int dim, bool damped), Scalar, dim, damped), (double, 3, false),
                       (float, 2, true)) {
  const auto springs = renumbered(springs_of(Mesh::diagonals, 60), 3700);
  const Points<Scalar, dim> y(3705);
  const auto f = forces<Scalar, dim, damped>(springs, y);
  CHECK(error<Scalar, dim, damped>(springs, y, f) <= 1);
  CHECK((f.colwise().norm().array() == 0).count() == 105);
  std::vector<std::uint8_t> still(3705, 1);
  still[123] = still[3007] = 0;
  const auto some = forces<Scalar, dim, damped>(springs, y, still.data());
  CHECK(some.col(123) == f.col(123));
  CHECK(some.col(3007) == f.col(3007));
  CHECK((some.colwise().norm().array() == 0).count() > 3600);
}

TEST_CASE("the two ends of a spring find exactly opposite forces") {
  std::vector<Spring> springs;
  for (int i = 0; i < 500; ++i) springs.push_back({i, 999 - i, 1 + i * 0.01, 0.3});
  const Points<double, 3> y(1000);
  const auto f = forces<double, 3, true>(springs, y);
  CHECK(f.colwise().norm().minCoeff() > 0);
  for (int i = 0; i < 500; ++i) CHECK(f.col(i) == -f.col(999 - i));
}

TEST_CASE("other units of length, mass and time by powers of two change no bit of rows") {
  auto springs = springs_of(Mesh::diagonals, 20);
  Points<double, 3> y(400);
  const auto f = forces<double, 3, false>(springs, y);
  for (Spring& s : springs) s.stiffness *= 0x1p-40, s.length *= 0x1p71;
  y.r *= 0x1p71;
  CHECK(forces<double, 3, false>(springs, y) == 0x1p31 * f);
}

TEST_CASE("a NaN reaches those that have a spring to it, nobody else") {
  const auto springs = springs_of(Mesh::grid, 30);
  Points<double, 3> y(900);
  y.r(1, 400) = std::numeric_limits<double>::quiet_NaN();
  const auto f = forces<double, 3, false>(springs, y);
  for (int i = 0; i < 900; ++i) {
    const bool near = i == 400 || i == 399 || i == 401 || i == 370 || i == 430;
    CHECK(f.col(i).hasNaN() == near);
  }
}

TEST_CASE("ends in one point have no direction: where there is a length at rest, no force is made up") {
  auto springs = springs_of(Mesh::grid, 30);
  Points<double, 3> y(900);
  y.r.col(400) = y.r.col(401);
  const auto f = forces<double, 3, false>(springs, y);
  for (int i = 0; i < 900; ++i) CHECK(f.col(i).allFinite() == (i != 400 && i != 401));
  for (Spring& s : springs)
    if (s.i == 400 && s.j == 401) s.length = 0;
  CHECK(forces<double, 3, true>(springs, y).allFinite());
}

TEST_CASE("where nobody moves nothing is worked out, and who moves gets the same force") {
  const auto springs = springs_of(Mesh::diagonals, 20);
  const Points<double, 3> y(400);
  std::vector<std::uint8_t> still(400, 1);
  CHECK(forces<double, 3, false>(springs, y, still.data()).norm() == 0);
  still[123] = still[7] = 0;
  const auto f = forces<double, 3, false>(springs, y), some = forces<double, 3, false>(springs, y, still.data());
  CHECK(some.col(123) == f.col(123));
  CHECK(some.col(7) == f.col(7));
  CHECK((some.colwise().norm().array() == 0).count() > 300);
}

TEST_CASE("a large network takes rows; a copy is its own, and forces are added") {
  const auto springs = springs_of(Mesh::grid, 80);
  if (!SpringRows<double, 3, false>::suits(springs.size(), 6400)) return;  // too few lanes, and no threads

  const Points<double, 3> y(6400);
  struct {
    Eigen::Matrix3Xd force;
  } a{Eigen::Matrix3Xd::Zero(3, 6400)}, b = a;
  const auto network = spring_network<3>(springs);
  const Motion<Eigen::Matrix3Xd> state{y.r, y.v};
  network.add(0.0, state, a);
  CHECK(error<double, 3, false>(springs, y, a.force) <= 1);
  const auto copy = network;
  const Motion<Eigen::Matrix3Xd> other{2 * y.r, y.v};
  copy.add(0.0, other, b);
  CHECK(b.force != a.force);
  b.force.setZero();
  network.add(0.0, state, b);
  CHECK(b.force == a.force);
  copy.add(0.0, state, b);
  CHECK(b.force == 2 * a.force);
}

TEST_CASE("the number of threads changes no bit") {
  for (const Mesh mesh : {Mesh::grid, Mesh::diagonals, Mesh::anyhow}) {
    const auto springs = mesh == Mesh::grid ? renumbered(springs_of(mesh, 90), 8100) : springs_of(mesh, 90);
    REQUIRE(springs.size() >= 10'000);
    const Points<double, 3> y(8100);
    const int before = omp_get_max_threads();
    omp_set_num_threads(1);
    const auto f = forces<double, 3, true>(springs, y);
    for (const int threads : {2, 3, 7, 40}) {
      omp_set_num_threads(threads);
      CHECK(forces<double, 3, true>(springs, y) == f);
    }
    omp_set_num_threads(before);
  }
}

#elif PHISTEP_FULL

TEMPLATE_TEST_CASE_SIG("rows are the loop over springs, but for rounding", "", ((class Scalar, int dim), Scalar, dim),
                       (double, 3), (double, 2), (double, 1), (float, 3)) {
  check_rows<Scalar, dim>();
}

#endif

// Rows find what the loop over springs finds, whatever the order, the mesh and the number of threads.
#include "particles/springs/spring_rows_cases.hpp"

using namespace spring_rows_cases;

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

// The search for pairs of bodies of unequal radii, against all pairs, and what it costs.
#include <phistep/particles.hpp>
#include <phistep/particles/contacts/contact_search.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <random>
#include <set>
#include <utility>
#include <vector>

#include "support/catch.hpp"

using namespace phistep;

namespace {

using Pair = std::pair<std::int32_t, std::int32_t>;

/// The pairs found, by the user's indices; each has to be there once, in the order of slots.
template <class Scalar>
std::set<Pair> found(const ContactPairs<Scalar>& pairs) {
  std::set<Pair> all;
  for (std::size_t k = 0; k < pairs.places(); ++k) {
    REQUIRE(pairs.first[k] < pairs.second[k]);
    REQUIRE(pairs.find(pairs.first[k], pairs.second[k]) == static_cast<std::ptrdiff_t>(k));
    const std::int32_t i = pairs.bodies.particle[static_cast<std::size_t>(pairs.first[k])],
                       j = pairs.bodies.particle[static_cast<std::size_t>(pairs.second[k])];
    REQUIRE(all.insert(std::minmax(i, j)).second);
  }
  return all;
}

template <class Scalar, int dim>
std::set<Pair> by_trying_all(const Particles<Scalar, dim>& y, Scalar skin) {
  std::set<Pair> all;
  const auto& body = y.body();
  for (Eigen::Index j = 1; j < y.r.cols(); ++j)
    for (Eigen::Index i = 0; i < j; ++i) {
      Scalar square{0};
      for (int a = 0; a < dim; ++a) {
        Scalar d = y.r(a, i) - y.r(a, j);
        if (body.box.is_periodic[static_cast<std::size_t>(a)]) {
          const Scalar period = body.box.upper[a] - body.box.lower[a];
          d -= period * std::nearbyint(d / period);
        }
        square += d * d;
      }
      const Scalar reach = body.radius[i] + body.radius[j] + skin;
      if (square < reach * reach) all.emplace(static_cast<std::int32_t>(i), static_cast<std::int32_t>(j));
    }
  return all;
}

/// Radii from 1 / ratio to 1, every decade with as many bodies; a fifth of the bodies held still where `held`.
template <class Scalar, int dim>
Particles<Scalar, dim> mixture(int n, double ratio, double size, std::array<bool, 3> periodic, bool held) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> u(0, 1);
  Eigen::Matrix<Scalar, dim, Eigen::Dynamic> r(dim, n);
  Eigen::Matrix<Scalar, Eigen::Dynamic, 1> radius(n);
  for (int i = 0; i < n; ++i) {
    for (int a = 0; a < dim; ++a)
      r(a, i) = static_cast<Scalar>(size * (1.2 * u(random) - 0.1));  // some outside the box
    radius[i] = static_cast<Scalar>(std::pow(ratio, -u(random)));
  }
  Particles<Scalar, dim> y{r};
  y.set_mass(Scalar{1}).set_radius(radius);
  Box<Scalar, dim> box = Box<Scalar, dim>::periodic(Eigen::Matrix<Scalar, dim, 1>::Zero(),
                                                    Eigen::Matrix<Scalar, dim, 1>::Constant(static_cast<Scalar>(size)));
  for (std::size_t a = 0; a < dim; ++a) box.is_periodic[a] = periodic[a];
  y.set_box(box);
  if (held) {
    std::vector<std::uint8_t> still(static_cast<std::size_t>(n), 0);
    for (std::size_t i = 0; i < still.size(); i += 5) still[i] = 1;
    y.set_still(still);
  }
  return y;
}

}  // namespace

TEMPLATE_TEST_CASE("bodies of unequal radii: the pairs are those of trying all", "", double, float) {
  using Scalar = TestType;
  for (const double ratio : {1.0, 3.0, 10.0, 30.0})
    for (const bool held : {false, true})
      for (const auto& periodic : {std::array{false, false, false}, std::array{true, true, true}}) {
        CAPTURE(ratio, held, periodic[0]);
        const auto check = [&]<int dim>(const Particles<Scalar, dim>& y) {
          ContactSearch<Scalar, dim> search;
          ContactPairs<Scalar> pairs;
          for (const auto skin : {static_cast<Scalar>(0.05), static_cast<Scalar>(0.3)}) {
            search.find(y.r, y.body(), skin, pairs);
            const auto expected = by_trying_all(y, skin);
            CHECK(expected.size() > 100);
            CHECK(found(pairs) == expected);
            CHECK(pairs.bodies.size() == 400);
          }
        };
        check(mixture<Scalar, 3>(400, ratio, 6, periodic, held));
        check(mixture<Scalar, 2>(400, ratio, 12, periodic, held));
      }
}

TEST_CASE("levels of cells: a factor of 2.5 apart, from the largest down") {
  CHECK(level_of_cells(1.0, 1.0) == 0);
  CHECK(level_of_cells(0.41, 1.0) == 0);
  CHECK(level_of_cells(0.4, 1.0) == 1);
  CHECK(level_of_cells(0.17, 1.0) == 1);
  CHECK(level_of_cells(0.15, 1.0) == 2);
  CHECK(level_of_cells(1e-300, 1.0) == 20);
  CHECK(level_of_cells(0.0, 0.0) == 0);
}

TEST_CASE("bodies of unequal radii: what is tried, counted") {
  const auto tried = [](const Eigen::Matrix3Xd& r, const Eigen::VectorXd& radius) {
    Particles<double, 3> y{r};
    y.set_mass(1.0).set_radius(radius);
    ContactSearch<double, 3> search;
    ContactPairs<double> pairs;
    search.find(y.r, y.body(), 0.1, pairs);
    return std::pair{search.pairs_tested(), pairs.places()};
  };
  using Result = std::pair<std::uint64_t, std::size_t>;
  Eigen::Matrix3Xd r(3, 4);  // a large one, two small ones that touch it and each other, one far from all
  r << 0, 11, 11, 0, 0, 0.9, -0.9, 0, 0, 0, 0, 90;
  // One level: three in cells beside each other, each tries two.
  CHECK((tried(r, Eigen::Vector4d(10, 10, 10, 10)) == Result{3 * 2, 3}));
  CHECK((tried(r, Eigen::Vector4d(10, 5, 5, 5)) == Result{3 * 2, 3}));
  // Two: the two try each other, and three the large one, whose cell is the only one of its level.
  CHECK((tried(r, Eigen::Vector4d(10, 1, 1, 1)) == Result{2 + 3, 3}));
  // Three: the far one tries the coarser levels' outermost cells, where those beyond would be.
  CHECK((tried(r, Eigen::Vector4d(10, 1, 1, 0.1)) == Result{2 + 3 + 2, 3}));

  // As many for each body, however many there are: one in 500 is 30 times as large as the others.
  const auto each = [](int n, double ratio) {
    auto y = mixture<double, 3>(n, 1, 0.27 * std::cbrt(n), {true, true, true}, false);
    Eigen::VectorXd radius = Eigen::VectorXd::Constant(n, 1 / ratio);
    for (Eigen::Index i = 0; i < n; i += 500) radius[i] = 1;
    y.set_radius(radius);
    ContactSearch<double, 3> search;
    ContactPairs<double> pairs;
    search.find(y.r, y.body(), 0.01, pairs);
    return static_cast<double>(search.pairs_tested()) / n;
  };
  const double some = each(4000, 30), more = each(32000, 30), one_level = each(4000, 2.4);
  CAPTURE(some, more, one_level);
  CHECK(more > 0.9 * some);
  CHECK(more < 1.1 * some);
  CHECK(some > 1);
  CHECK(one_level > 200 * some);
}

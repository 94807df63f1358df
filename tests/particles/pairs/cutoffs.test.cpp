// A cutoff for each pair of types: against a loop over all pairs, and what a list then holds.
#include <phistep/particles.hpp>
#include <phistep/particles/pairs/pairs.hpp>

#include <cmath>
#include <cstdint>
#include <limits>
#include <random>
#include <stdexcept>
#include <string>
#include <tuple>
#include <vector>

#ifdef _OPENMP
#include <omp.h>
#endif

#include "particles/pairs/pair_view.hpp"
#include "support/catch.hpp"

using namespace phistep;

namespace cutoffs_cases {

using LJ = LennardJones;

/// What a scene has for the pair (a, b) at a·types + b.
struct Mixture {
  std::vector<LJ> laws;
  std::vector<double> cutoffs;
  [[nodiscard]] auto force(PairOptions options = {}) const { return Pairs{ByType{laws, cutoffs}, options}; }
};
/// Kob and Andersen's [Phys. Rev. E 51, 4626 (1995)]: 2.5 σ_ab.
inline Mixture kob_andersen() {
  const LJ AA = LJ{1, 1}.shifted(2.5), AB = LJ{1.5, 0.8}.shifted(2.0), BB = LJ{0.5, 0.88}.shifted(2.2);
  return {{AA, AB, AB, BB}, {2.5, 2.0, 2.0, 2.2}};
}
/// Three types, not shifted: 0 and 1 don't see each other, nor do two of type 2.
inline Mixture with_gaps() {
  return {{{1, 1}, {9, 1}, {0.7, 0.9}, {9, 1}, {0.5, 1.1}, {0.8, 1}, {0.7, 0.9}, {0.8, 1}, {9, 1}},
          {1.7, 0, 2.4, 0, 1.4, 1.9, 2.4, 1.9, 0}};
}

/// Six types, more than the kernel has in registers.
inline Mixture many_types() {
  Mixture all;
  for (int a = 0; a < 6; ++a)
    for (int b = 0; b < 6; ++b)
      all.laws.push_back({1 + 0.1 * (a + b), 1 - 0.02 * (a + b)}), all.cutoffs.push_back(1.3 + 0.04 * (a + b + a * b));
  return all;
}

using pair_view::Out, pair_view::view_of;

/// n^dim on a lattice a apart, shaken, with velocities without momentum: types 0 to `types` − 1 at random, the first one most.
template <class Scalar, int dim>
Particles<Scalar, dim> mixed(int n, double a, int types, bool periodic, unsigned seed = 1) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> shake(-0.12 * a, 0.12 * a);
  std::normal_distribution<double> speed;
  Index count = 1;
  for (int x = 0; x < dim; ++x) count *= n;
  Eigen::Matrix<Scalar, dim, Eigen::Dynamic> r(dim, count), v(dim, count);
  Eigen::VectorXi type(count);
  for (Index k = 0; k < count; ++k) {
    Index rest = k;
    for (int x = 0; x < dim; ++x, rest /= n) {
      r(x, k) = static_cast<Scalar>((static_cast<double>(rest % n) + 0.5) * a + shake(random));
      v(x, k) = static_cast<Scalar>(speed(random));
    }
    type[k] = std::max(0, static_cast<int>(random() % 5) - 5 + types);
  }
  v.colwise() -= v.rowwise().mean().eval();
  Particles<Scalar, dim> y{r, v};
  y.set_mass(Scalar{1});
  y.set_type(type);
  using Corner = Eigen::Matrix<Scalar, dim, 1>;
  if (periodic) y.set_box(Box<Scalar, dim>::periodic(Corner::Zero(), Corner::Constant(static_cast<Scalar>(n * a))));
  return y;
}

/// By a loop over all pairs, in long double; `size` is what the forces on one add up to, for the bound.
template <int dim>
struct Direct {
  using Vectors = Eigen::Matrix<long double, dim, Eigen::Dynamic>;
  Vectors force;
  Eigen::Matrix<long double, 1, Eigen::Dynamic> size;
  long double energy = 0, virial = 0, energy_size = 0, virial_size = 0;
  std::uint64_t inside = 0, listed = 0;
};
template <class Scalar, int dim>
Direct<dim> direct(const Particles<Scalar, dim>& y, const Mixture& mixture, double skin = 0) {
  const auto types = static_cast<Index>(std::lround(std::sqrt(static_cast<double>(mixture.laws.size()))));
  Direct<dim> sum;
  sum.force.setZero(dim, y.size()), sum.size.setZero(y.size());
  const auto& box = y.body().box;
  for (Index i = 0; i < y.size(); ++i)
    for (Index j = 0; j < i; ++j) {
      Eigen::Matrix<long double, dim, 1> d = (y.r.col(i) - y.r.col(j)).template cast<long double>();
      for (int a = 0; a < dim; ++a) {
        const long double length = static_cast<long double>(box.upper[a]) - static_cast<long double>(box.lower[a]);
        if (box.is_periodic[static_cast<std::size_t>(a)]) d[a] -= length * std::round(d[a] / length);
      }
      const auto r2 = static_cast<double>(d.squaredNorm());
      const auto at = static_cast<std::size_t>(y.body().type_of(i) * types + y.body().type_of(j));
      const double cutoff = mixture.cutoffs[at], range = cutoff > 0 ? cutoff + skin : 0;
      sum.listed += r2 < range * range;
      if (r2 >= cutoff * cutoff) continue;
      ++sum.inside;
      const long double g = mixture.laws[at](r2), V = mixture.laws[at].energy(r2);
      sum.force.col(i) += g * d, sum.force.col(j) -= g * d;
      sum.size[i] += std::abs(g) * d.norm(), sum.size[j] += std::abs(g) * d.norm();
      sum.energy += V, sum.energy_size += std::abs(V);
      sum.virial += r2 * g, sum.virial_size += std::abs(r2 * g);
    }
  return sum;
}

template <class Scalar, int dim>
void check_sums(const Particles<Scalar, dim>& y, const Mixture& mixture) {
  CAPTURE(dim, sizeof(Scalar), y.size());
  const auto force = mixture.force();
  Out<Scalar, dim> out{decltype(Out<Scalar, dim>::force)::Zero(dim, y.size())};
  NeighborMemory memory;
  force.add(Scalar{0}, view_of(y), memory, out);
  const Direct<dim> expected = direct(y, mixture);
  // As in pairs.test.cpp: positions of size ≤ 20, r ≥ 0.6 and r^−13.
  constexpr auto rounding = static_cast<long double>(400 * std::numeric_limits<Scalar>::epsilon());
  for (Index i = 0; i < y.size(); ++i)
    REQUIRE((out.force.col(i).template cast<long double>() - expected.force.col(i)).norm() <=
            rounding * expected.size[i]);
  const auto energy = static_cast<long double>(force.energy(Scalar{0}, view_of(y), memory));
  const auto virial = static_cast<long double>(force.virial(Scalar{0}, view_of(y), memory));
  CHECK(std::abs(energy - expected.energy) <= rounding * expected.energy_size);
  CHECK(std::abs(virial - expected.virial) <= rounding * expected.virial_size);
  CHECK(force.pairs_inside(view_of(y), memory) == expected.inside);
}

/// Collects dense tangents.
struct Dense {
  Eigen::MatrixXd K;
  void position(Index i, Index j, double x) { K(i, j) += x; }
  void velocity(Index, Index, double) {}
  void rate(Index, Index, double) {}
};

/// What a checkpoint holds of it.
inline NeighborMemory from_checkpoint(NeighborMemory memory) {
  Writer out;
  out(memory);
  NeighborMemory restored;
  Reader in{out.bytes()};
  in(restored);
  in.finish();
  return restored;
}

}  // namespace cutoffs_cases

using namespace cutoffs_cases;

#if PHISTEP_QUICK

TEST_CASE("forces, energy and virial are those of a sum over all pairs, each to its own cutoff") {
  check_sums(mixed<double, 3>(8, 1.1, 2, true), kob_andersen());
  check_sums(mixed<double, 3>(8, 1.1, 3, true), with_gaps());
  check_sums(mixed<double, 3>(7, 1.1, 3, false), with_gaps());
  check_sums(mixed<double, 3>(8, 1.1, 6, true), many_types());
  check_sums(Particles<double, 3>{Eigen::Matrix3Xd::Zero(3, 0)}, with_gaps());
}

TEST_CASE("one cutoff in all places of the table: the bits of one cutoff") {
  const auto y = mixed<double, 3>(8, 1.1, 2, true);
  const Mixture one{kob_andersen().laws, std::vector<double>(4, 2.5)};
  Out<double, 3> a{Eigen::Matrix3Xd::Zero(3, y.size())}, b = a;
  const auto force = one.force();
  const Pairs plain{ByType{one.laws}, 2.5};
  force.add(0.0, view_of(y), NeighborMemory{}, a);
  plain.add(0.0, view_of(y), NeighborMemory{}, b);
  CHECK(a.force == b.force);
  CHECK(force.energy(0.0, view_of(y)) == plain.energy(0.0, view_of(y)));
  CHECK(force.pairs_listed() == plain.pairs_listed());
}

TEST_CASE("a list holds each pair up to its own cutoff and the skin, a pair without a cutoff never") {
  for (const bool periodic : {false, true}) {
    const auto y = mixed<double, 3>(8, 1.1, 3, periodic);
    const auto force = with_gaps().force({.skin = 0.25});
    CHECK(force.cutoff() == 2.4);
    NeighborMemory memory;
    CHECK(force.pairs_inside(view_of(y), memory) == direct(y, with_gaps()).inside);
    CHECK(force.pairs_listed() == 2 * direct(y, with_gaps(), 0.25).listed);
    std::uint64_t wrong = 0;
    force.for_each_pair(memory, [&](Index i, Index j) {
      const int a = y.body().type_of(i), b = y.body().type_of(j);
      wrong += a + b == 1 || a + b == 4;
    });
    CHECK(wrong == 0);
    auto longer = with_gaps();
    longer.cutoffs[4] = 3;
    auto changed = force;
    changed.law = ByType{longer.laws, longer.cutoffs};
    CHECK(changed.pairs_inside(view_of(y), memory) == direct(y, longer).inside);
  }
}

TEST_CASE("a run keeps energy and momentum, and misses no pair while types mix") {
  const Mixture mixture = kob_andersen();
  auto y = mixed<double, 3>(8, 0.98, 2, true);
  PhiStepper stepper{y, mixture.force(), velocity_verlet};
  const auto go = [&](int from, int to) {
    for (int n = from; n < to; ++n) REQUIRE(stepper.step(y, 0.002 * n, 0.002));
  };
  go(0, 150);  // from the shaken lattice to a liquid
  const auto total = [&] { return 0.5 * y.v.squaredNorm() + static_cast<double>(direct(y, mixture).energy); };
  const double before = total(), exchanged = 0.5 * y.v.squaredNorm();
  go(150, 450);
  // (ωΔt)²/12 with ω² ≈ 2000 of what is exchanged, and the forces' jumps of 0.04 at the cutoffs.
  CHECK(std::abs(total() - before) < 1e-3 * exchanged);
  CHECK((y.v.rowwise().sum().norm()) < 1e-11 * static_cast<double>(y.size()));
  CHECK(stepper.force_to_look_at().rebuilds() > 5);
  const Direct<3> expected = direct(y, mixture);
  CHECK(stepper.force_to_look_at().pairs_inside(view_of(y), stepper.memory()) == expected.inside);
  Out<double, 3> out{Eigen::Matrix3Xd::Zero(3, y.size())};
  stepper.force_to_look_at().add(0.0, view_of(y), stepper.memory(), out);
  for (Index i = 0; i < y.size(); ++i)
    REQUIRE((out.force.col(i).cast<long double>() - expected.force.col(i)).norm() <= 1e-12L * expected.size[i]);
}

TEST_CASE("types that change between steps change the list, and a checkpoint goes on bit for bit") {
  const Mixture mixture = with_gaps();
  auto y = mixed<double, 3>(8, 1.15, 3, true);
  y.v *= 0.5;
  PhiStepper stepper{y, mixture.force({.skin = 0.4}), velocity_verlet};
  for (int n = 0; n < 3; ++n) REQUIRE(stepper.step(y, 0.002 * n, 0.002));
  Eigen::VectorXi type = y.body().type;
  for (Index i = 0; i < y.size(); i += 3) type[i] = 2 - type[i];
  y.set_type(type);
  REQUIRE(stepper.step(y, 0.006, 0.002));
  CHECK(stepper.force_to_look_at().rebuilds() == 2);  // moved by less than the skin
  CHECK(stepper.force_to_look_at().pairs_inside(view_of(y), stepper.memory()) == direct(y, mixture).inside);
  auto z = y;
  PhiStepper other{z, mixture.force({.skin = 0.4}), velocity_verlet};
  other.set_memory(from_checkpoint(stepper.memory()));
  for (int n = 4; n < 40; ++n) {
    REQUIRE(stepper.step(y, 0.002 * n, 0.002));
    REQUIRE(other.step(z, 0.002 * n, 0.002));
  }
  CHECK((y.r == z.r && y.v == z.v));
}

TEST_CASE("the tangent is the slope of the force, and 0 beyond the pair's own cutoff") {
  auto y = mixed<double, 3>(4, 1.15, 3, false, 7);
  const auto force = with_gaps().force();
  Dense dense{Eigen::MatrixXd::Zero(y.r.size(), y.r.size())};
  force.add_jacobian(0.0, view_of(y), NeighborMemory{}, dense);
  const auto psi = [&] {
    Out<double, 3> out{Eigen::Matrix3Xd::Zero(3, y.size())};
    force.add(0.0, view_of(y), NeighborMemory{}, out);
    return out.force;
  };
  constexpr double h = 1e-5;
  for (const Index k : {0, 50, 100, 150}) {
    const double x = y.r.data()[k];
    y.r.data()[k] = x + h;
    const Eigen::Matrix3Xd above = psi();
    y.r.data()[k] = x - h;
    const Eigen::Matrix3Xd slope = (above - psi()) / (2 * h);
    y.r.data()[k] = x;
    const Eigen::Map<const Eigen::VectorXd> column(slope.data(), slope.size());
    CHECK((column - dense.K.col(k)).cwiseAbs().maxCoeff() < 3e-7 * dense.K.cwiseAbs().maxCoeff());
  }
}

TEST_CASE("one thread to four: the same bits") {
  const auto run = [](int threads) {
#ifdef _OPENMP
    omp_set_num_threads(threads);
#else
    static_cast<void>(threads);
#endif
    auto y = mixed<double, 3>(12, 1.0, 3, true);
    y.v *= 0.3;
    const auto measure = with_gaps().force();
    PhiStepper stepper{y, with_gaps().force(), velocity_verlet};
    for (int n = 0; n < 15; ++n) REQUIRE(stepper.step(y, 0.002 * n, 0.002));
    return std::tuple{y.r, y.v, measure.energy(0.0, view_of(y))};
  };
  const auto one = run(1);
  for (const int threads : {2, 3, 4}) CHECK(run(threads) == one);
}

TEST_CASE("a table of cutoffs that can't be is refused, as is a type it lacks") {
  const std::vector<LJ> laws = kob_andersen().laws;
  const auto with = [&](const std::vector<double>& cutoffs) { return Mixture{laws, cutoffs}.force(); };
  const double nan = std::numeric_limits<double>::quiet_NaN();
  CHECK_NOTHROW(with({2.5, 0, 0, 0}));
  CHECK_THROWS_WITH(with({2.5, -2, -2, 2.2}), Catch::Matchers::Contains("cutoffs"));
  CHECK_THROWS_WITH(with({2.5, 2, 2, nan}), Catch::Matchers::Contains("cutoffs"));
  CHECK_THROWS_WITH(with({2.5, 2, 2, HUGE_VAL}), Catch::Matchers::Contains("cutoffs"));
  CHECK_THROWS_WITH(with({2.5, 2, 2}), Catch::Matchers::Contains("cutoffs"));
  CHECK_THROWS_WITH(with({}), Catch::Matchers::Contains("cutoffs"));
  CHECK_THROWS_WITH(with({2.5, 2, 2.1, 2.2}), Catch::Matchers::Contains("types 0 and 1"));
  CHECK_THROWS_AS(with({0, 0, 0, 0}), std::invalid_argument);
  auto y = mixed<double, 3>(4, 1.1, 2, false);
  y.set_type(Eigen::VectorXi(Eigen::VectorXi::LinSpaced(y.size(), 0, 63)));
  CHECK_THROWS_WITH(with({2.5, 2, 2, 2.2}).energy(0.0, view_of(y)), Catch::Matchers::Contains("particle 2 has type 2"));
  const auto narrow = mixed<double, 3>(3, 0.8, 2, true);  // a period of 2.4
  CHECK_THROWS_WITH(with({2.5, 2, 2, 2.2}).energy(0.0, view_of(narrow)), Catch::Matchers::Contains("2.5"));
}

#elif PHISTEP_FULL

TEST_CASE("forces, energy and virial are those of a sum over all pairs, each to its own cutoff") {
  for (const bool periodic : {false, true}) {
    check_sums(mixed<double, 3>(8, 1.1, 3, periodic), with_gaps());
    check_sums(mixed<double, 2>(20, 1.1, 3, periodic), with_gaps());
    check_sums(mixed<float, 3>(8, 1.1, 3, periodic), with_gaps());
    check_sums(mixed<float, 2>(20, 1.1, 3, periodic), with_gaps());
    check_sums(mixed<float, 3>(8, 1.1, 6, periodic), many_types());
  }
}

TEST_CASE("implicit steps, and particles held still") {
  const Mixture mixture = with_gaps();
  auto y = mixed<double, 3>(5, 1.15, 3, false);
  std::vector<std::uint8_t> still(static_cast<std::size_t>(y.size()));
  for (std::size_t i = 0; i < still.size(); i += 4) still[i] = 1;
  y.v.setZero();
  auto free = y;
  y.set_still(still);
  const auto force = mixture.force();
  Out<double, 3> some{Eigen::Matrix3Xd::Zero(3, y.size())}, all = some;
  force.add(0.0, view_of(y), NeighborMemory{}, some);
  force.add(0.0, view_of(free), NeighborMemory{}, all);
  for (Index i = 0; i < y.size(); ++i)
    CHECK((some.force.col(i) - (still[static_cast<std::size_t>(i)] ? 0 : 1) * all.force.col(i)).norm() <=
          1e-12 * all.force.norm());
  PhiStepper stepper{free, mixture.force(), trapezoidal};
  const double before = static_cast<double>(direct(free, mixture).energy);
  for (int n = 0; n < 20; ++n) {
    const auto report = stepper.step(free, 0.001 * n, 0.001);
    CAPTURE(report.message());
    REQUIRE(report);
  }
  const double after = 0.5 * free.v.squaredNorm() + static_cast<double>(direct(free, mixture).energy);
  CHECK(std::abs(after - before) < 0.01 * (0.5 * free.v.squaredNorm()));
}

#endif

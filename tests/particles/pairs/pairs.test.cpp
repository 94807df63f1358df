// Pair forces: against all pairs, differences, known counts; their lists as memory of a stepper.
#include <phistep/particles.hpp>
#include <phistep/particles/pairs/pairs.hpp>

#include <array>
#include <atomic>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <functional>
#include <limits>
#include <new>
#include <random>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#ifdef _OPENMP
#include <omp.h>
#endif

#include "particles/pairs/pair_view.hpp"
#include "support/catch.hpp"

namespace heap {
inline bool counting = false;
inline std::int64_t count = 0;              // calls
inline std::atomic<std::int64_t> live = 0;  // bytes
inline constexpr std::size_t head = 16;     // before each block: its size
}  // namespace heap
// Not inlined: g++ 12 otherwise sees free() meet new.
[[gnu::noinline]] void* operator new(std::size_t n) {
  heap::count += heap::counting;
  auto* const block = static_cast<std::size_t*>(std::malloc(n + heap::head));
  if (block == nullptr) throw std::bad_alloc();
  *block = n;
  heap::live += static_cast<std::int64_t>(n);
  return reinterpret_cast<char*>(block) + heap::head;
}
[[gnu::noinline]] void operator delete(void* p) noexcept {
  if (p == nullptr) return;
  auto* const block = reinterpret_cast<std::size_t*>(static_cast<char*>(p) - heap::head);
  heap::live -= static_cast<std::int64_t>(*block);
  std::free(block);
}
[[gnu::noinline]] void operator delete(void* p, std::size_t) noexcept { operator delete(p); }

using namespace phistep;

namespace pairs_cases {

using pair_view::Out, pair_view::view_of;

/// Points on a lattice a apart, shaken: nobody closer than half of it.
template <class Scalar, int dim>
Particles<Scalar, dim> shaken(int n, double a, unsigned seed, std::array<bool, 3> periodic, double amount = 0.2) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> shake(-amount * a, amount * a);
  const int count = dim == 3 ? n * n * n : n * n;
  Eigen::Matrix<Scalar, dim, Eigen::Dynamic> r(dim, count);
  for (int k = 0; k < count; ++k) {
    const std::array site{k % n, k / n % n, k / n / n};
    for (int x = 0; x < dim; ++x)
      r(x, k) = static_cast<Scalar>((site[static_cast<std::size_t>(x)] + 0.5) * a + shake(random));
  }
  Particles<Scalar, dim> y{r};
  y.set_mass(Scalar{1});
  Box<Scalar, dim> box;
  for (int x = 0; x < dim; ++x) {
    box.is_periodic[static_cast<std::size_t>(x)] = periodic[static_cast<std::size_t>(x)];
    box.upper[x] = static_cast<Scalar>(n * a);
  }
  y.set_box(box);
  return y;
}

/// Σ_j g d over all j and the images around the nearest, in long double; and the sum of what was added, for the bound.
template <class Scalar, int dim>
void check_forces(const Particles<Scalar, dim>& y, auto law, double cutoff) {
  const Pairs force{law, cutoff};
  Out<Scalar, dim> out{Eigen::Matrix<Scalar, dim, Eigen::Dynamic>::Zero(dim, y.size())};
  NeighborMemory memory;
  force.add(Scalar{0}, view_of(y), memory, out);
  const auto& box = y.body().box;
  for (Index i = 0; i < y.size(); ++i) {
    Eigen::Matrix<long double, dim, 1> sum = Eigen::Matrix<long double, dim, 1>::Zero();
    long double size = 0;
    for (Index j = 0; j < y.size(); ++j) {
      if (i == j) continue;  // an own image pulls as the one on the other side pushes
      Eigen::Matrix<long double, dim, 1> d = (y.r.col(i) - y.r.col(j)).template cast<long double>();
      for (int a = 0; a < dim; ++a) {
        if (!box.is_periodic[static_cast<std::size_t>(a)]) continue;
        const long double length = static_cast<long double>(box.upper[a]) - static_cast<long double>(box.lower[a]);
        d[a] -= length * std::round(d[a] / length);
      }
      if (d.squaredNorm() >= cutoff * cutoff) continue;
      const auto g = static_cast<long double>(law(static_cast<double>(d.squaredNorm())));
      sum += g * d;
      size += std::abs(g) * d.norm();
    }
    // Rounding: positions of size ≤ 20 have errors of 20 ε/2, which r ≥ 0.6 turn into 14·20 ε of an r^−13; sums add a few.
    const auto bound = static_cast<long double>(400 * std::numeric_limits<Scalar>::epsilon()) * size;
    CAPTURE(i, dim, sizeof(Scalar));
    REQUIRE((out.force.col(i).template cast<long double>() - sum).norm() <= bound);
  }
}

/// Collects dense tangents.
struct Dense {
  Eigen::MatrixXd K;
  void position(Index i, Index j, double x) { K(i, j) += x; }
  void velocity(Index, Index, double) {}
  void rate(Index, Index, double) {}
};

inline Particles<double, 3> hot(unsigned seed) {
  auto y = shaken<double, 3>(6, 1.2, seed, {true, true, true}, 0.05);
  std::mt19937 random(seed);
  std::normal_distribution<double> speed;
  for (Index i = 0; i < y.v.size(); ++i) y.v.data()[i] = speed(random);
  return y;
}
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

void check_slopes(const auto& law, double cutoff) {
  auto y = shaken<double, 3>(4, 1.15, 7, {true, true, false});
  y.set_charge(Eigen::VectorXd(Eigen::VectorXd::LinSpaced(y.size(), -1, 1)));
  Eigen::VectorXi type(y.size());
  for (Index i = 0; i < y.size(); ++i) type[i] = static_cast<int>(i % 2);
  y.set_type(type);
  // Nobody crosses the cutoff, where laws jump, by h = 1e-5: the test's own condition.
  const Pairs force{law, cutoff};
  const auto psi = [&] {
    Out<double, 3> out{Eigen::Matrix3Xd::Zero(3, y.size())};
    force.add(0.0, view_of(y), NeighborMemory{}, out);
    return out.force;
  };
  Dense dense{Eigen::MatrixXd::Zero(y.r.size(), y.r.size())};
  force.add_jacobian(0.0, view_of(y), NeighborMemory{}, dense);
  const Eigen::Matrix3Xd at = psi();
  const double size = at.cwiseAbs().maxCoeff(), stiffness = dense.K.cwiseAbs().maxCoeff();
  CHECK(dense.K.isApprox(dense.K.transpose(), 1e-12));
  constexpr double h = 1e-5;
  for (const Index k : {0, 7, 50, 100}) {
    const double x = y.r.data()[k];
    y.r.data()[k] = x + h;
    const double up = force.energy(0.0, view_of(y));
    const Eigen::Matrix3Xd above = psi();
    y.r.data()[k] = x - h;
    const double down = force.energy(0.0, view_of(y));
    const Eigen::Matrix3Xd below = psi();
    y.r.data()[k] = x;
    // Central differences: h² F''/6 with F'' ≈ 200 F/r² for r^−13, r ≥ 0.7: 1e-8; rounding ε V/h with V ≈ 100 F: 2e-9.
    CHECK(std::abs((down - up) / (2 * h) - at.data()[k]) < 3e-8 * (size + stiffness));
    const Eigen::Matrix3Xd slope = (above - below) / (2 * h);
    const Eigen::Map<const Eigen::VectorXd> column(slope.data(), slope.size());
    CHECK((column - dense.K.col(k)).cwiseAbs().maxCoeff() < 3e-7 * stiffness);
  }
}

/// A law that is Lennard-Jones' with ε = σ = 1.
void check_own(const auto& own) {
  const auto y = shaken<double, 3>(6, 1.2, 5, {true, true, true});
  Out<double, 3> a{Eigen::Matrix3Xd::Zero(3, y.size())}, b = a;
  NeighborMemory memory;
  Pairs{own, 2.0}.add(0.0, view_of(y), memory, a);
  Pairs{LennardJones{}, 2.0}.add(0.0, view_of(y), NeighborMemory{}, b);
  CHECK(a.force == b.force);
}

inline std::atomic<long> law_calls{0};
/// Throws when it is called for the 2000th time.
inline const auto throwing = [](auto r2) {
  if (++law_calls == 2000) throw std::runtime_error("no such distance");
  return decltype(r2){1} / (r2 * r2);
};

void check_throws(auto force) {
  Eigen::Matrix3Xd r(3, 4096);
  for (Eigen::Index k = 0; k < r.cols(); ++k)
    r.col(k) << 1.1 * static_cast<double>(k % 16), 1.1 * static_cast<double>(k / 16 % 16),
        1.1 * static_cast<double>(k / 256);
  Particles<double, 3> atoms{r}, twin{r};
  PhiStepper stepper{atoms, force, velocity_verlet}, other{twin, force, velocity_verlet};
  law_calls = 0;
  CHECK_THROWS_WITH(stepper.step(atoms, 0, 1e-3), "no such distance");
  CHECK((atoms.r == r && atoms.v.isZero(0)));
  REQUIRE(stepper.step(atoms, 0, 1e-3));
  REQUIRE(other.step(twin, 0, 1e-3));
  CHECK((atoms.r == twin.r && atoms.v == twin.v));
}

/// How a stepper gets its force.
inline const auto copied = [](const auto& force) { return force; };
inline const auto referred_to = [](auto& force) { return std::ref(force); };

void check_quiet(auto hand) {
  auto y = hot(1);
  Pairs force{LennardJones{}, 2.5, {.skin = 0.3}};
  PhiStepper stepper{y, hand(force), velocity_verlet};
  REQUIRE(stepper.step(y, 0, 0.004));
  std::int64_t quiet = 0;
  for (int n = 1; n < 200; ++n) {
    const std::uint64_t before = stepper.force_to_look_at().rebuilds();
    heap::count = 0;
    heap::counting = true;
    const bool good = static_cast<bool>(stepper.step(y, 0.004 * n, 0.004));
    heap::counting = false;
    REQUIRE(good);
    if (stepper.force_to_look_at().rebuilds() != before) continue;
    ++quiet;
    CHECK(heap::count == 0);
  }
  CHECK(stepper.statistics().force_calls == 201);
  CHECK(quiet > 150);
  CHECK(stepper.force_to_look_at().rebuilds() == 200u - static_cast<std::uint64_t>(quiet));
}

/// Pairs that a list misses in 40 steps.
std::uint64_t missed(int unchecked_every, auto hand) {
  auto y = hot(8);
  Pairs force{LennardJones{}, 2.5, {.skin = 0.1, .unchecked_every = unchecked_every}};
  const Pairs all{LennardJones{}, 2.5};
  PhiStepper stepper{y, hand(force), velocity_verlet};
  std::uint64_t sum = 0;
  for (int n = 0; n < 40; ++n) {
    REQUIRE(stepper.step(y, 0.004 * n, 0.004));
    sum += all.pairs_inside(view_of(y)) - stepper.force_to_look_at().pairs_inside(view_of(y), stepper.memory());
  }
  return sum;
}

/// Positions after 40 steps, between which somebody asks for the energy of other ones.
Eigen::Matrix3Xd end(bool asks, auto hand) {
  auto y = hot(9);
  Pairs force{LennardJones{}, 2.5};
  PhiStepper stepper{y, hand(force), velocity_verlet};
  for (int n = 0; n < 40; ++n) {
    REQUIRE(stepper.step(y, 0.004 * n, 0.004));
    auto elsewhere = y;
    elsewhere.r.col(n).array() += 3;
    if (asks) CHECK(std::isfinite(stepper.force_to_look_at().energy(0.0, view_of(elsewhere), stepper.memory())));
  }
  return y.r;
}

}  // namespace pairs_cases

using namespace pairs_cases;

#if PHISTEP_QUICK

TEST_CASE("pair forces are those of a sum over all pairs") {
  const LennardJones law{0.7, 1.1};
  for (const auto& periodic :
       {std::array{false, false, false}, std::array{true, true, true}, std::array{true, false, true}}) {
    check_forces(shaken<double, 3>(7, 1.25, 1, periodic), law, 2.5);
    check_forces(shaken<float, 2>(13, 1.25, 4, periodic), law, 2.5);
  }
}

TEST_CASE("a long strip, whose list counts neighbours in all of its ways: the forces of its lattice") {
  constexpr Index length = 40000,
                  n = 3 * length;  // as in particles/neighbors/neighbors: from three slots, and whole numbers
  Eigen::Matrix2Xd r(2, n);
  for (Index i = 0; i < n; ++i)
    r.col(i) << static_cast<double>(i % length) + 0.05 * std::sin(static_cast<double>(7 * i)),
        1.1 * static_cast<double>(i / length) + 0.05 * std::sin(static_cast<double>(5 * i));
  const LennardJones law{};
  for (const Index moves_each : {Index{1}, Index{300}}) {
    CAPTURE(moves_each);
    Particles<double, 2> y{r};
    std::vector<std::uint8_t> still;
    for (Index i = 0; i < n; ++i) still.push_back(i % moves_each != 0);
    if (moves_each > 1) y.set_still(still);
    double energy = 0;
    Eigen::Matrix2Xd expected = Eigen::Matrix2Xd::Zero(2, n);
    const auto add = [&](Index i, Index j) {
      const bool a = still[static_cast<std::size_t>(i)] == 0, b = still[static_cast<std::size_t>(j)] == 0;
      const Eigen::Vector2d d = r.col(i) - r.col(j), f = law(d.squaredNorm()) * d;
      if (a) expected.col(i) += f;
      if (b) expected.col(j) -= f;
      if (a || b) energy += law.energy(d.squaredNorm());
    };
    for (Index i = 0; i < n; ++i) {
      if (i % length + 1 < length) add(i, i + 1);
      if (i + length < n) add(i, i + length);
    }
    const Pairs force{law, 1.25, {.skin = 0.05}};
    NeighborMemory memory;
    Out<double, 2> out{Eigen::Matrix2Xd::Zero(2, n)};
    force.add(0.0, view_of(y), memory, out);
    CHECK((out.force - expected).cwiseAbs().maxCoeff() < 1e-9);
    CHECK(std::abs(force.energy(0.0, view_of(y), memory) - energy) < 1e-9 * std::abs(energy));
  }
}

TEST_CASE("no law is asked beyond the cutoff, where it may under- or overflow") {
  double farthest = 0;
  const auto law = [&farthest](auto r2) {
    if constexpr (is_pack<decltype(r2)>)
      for (int l = 0; l < decltype(r2)::width; ++l) farthest = std::max(farthest, static_cast<double>(r2[l]));
    return 1 / (r2 * r2);
  };
  const auto y = shaken<double, 3>(3, 1.0, 8, {}, 0);  // neighbours at 1, listed also those at √2 and √3
  const Pairs force{law, 1.25, {.skin = 0.5}};
  NeighborMemory memory;
  Out<double, 3> out{Eigen::Matrix3Xd::Zero(3, 27)};
  force.add(0.0, view_of(y), memory, out);
  CHECK(force.pairs_listed() > 27 * 6);
  CHECK(force.pairs_inside(y) == 54);
  CHECK(out.force.col(13).norm() < 1e-12);
  CHECK(out.force.col(0).isApprox(Eigen::Vector3d::Constant(-1)));
  CHECK(farthest == 1.25 * 1.25);
  farthest = 0;
  CHECK(force.virial(0.0, view_of(y)) > 0);
  CHECK(farthest == 1.25 * 1.25);
}

TEST_CASE("a law of the user's own is as good") {
  const auto own = [](auto r2) {
    const auto y = 1 / r2, y3 = y * y * y;
    return y * y3 * (12 * 4.0 * y3 - 6 * 4.0);
  };
  check_own(own);
}

TEST_CASE("momentum is conserved, to rounding") {
  const auto y = shaken<double, 3>(8, 1.1, 6, {true, true, true});
  Out<double, 3> out{Eigen::Matrix3Xd::Zero(3, y.size())};
  Pairs{LennardJones{}, 2.5}.add(0.0, view_of(y), NeighborMemory{}, out);
  // Each pair's two forces differ by the rounding of its two distances (see above); some 20 forces act on each.
  const double bound = 400 * 20 * 2.3e-16 * static_cast<double>(y.size()) * out.force.cwiseAbs().maxCoeff();
  CHECK(out.force.rowwise().sum().norm() < bound);
}

TEST_CASE("forces are minus the slope of the energy, tangents that of the forces") {
  check_slopes(LennardJones{0.5, 0.9}.shifted(2.1), 2.1);
  check_slopes(ScreenedCharges{2.0, 0.8}, 2.1);
}

TEST_CASE("laws at known distances") {
  CHECK(LennardJones{2, 3}.energy(9.0) == Approx(0).margin(1e-15));
  const double r2 = 9 * std::cbrt(2.0);  // (2^(1/6) σ)²
  CHECK(LennardJones{2, 3}.energy(r2) == Approx(-2).epsilon(1e-14));
  CHECK(LennardJones{2, 3}(r2) == Approx(0).margin(1e-14));
  CHECK(LennardJones{2, 3}.shifted(7).energy(49.0) == Approx(0).margin(1e-16));
  CHECK(Yukawa{3, 2}.energy(4.0) == Approx(1.5 * std::exp(-1.0)).epsilon(1e-15));
  CHECK(NearField{5, 2, 7, 4}(4.0) * 2 == Approx(7 / 16. - 5 / 4.).epsilon(1e-15));
  CHECK(SoftSphere{3, 2}.energy(0.0) == 3);
  CHECK(SoftSphere{3, 2}(4.0) == 0);
}

TEST_CASE("Lennard-Jones in any units whose squares a number can hold", "[pairs]") {
  // Argon in SI units, in float: σ¹² = 2.4e-114 is none, nor is r⁻⁶.
  const float metre = 3.4e-10F, joule = 1.65e-21F;
  for (const float r : {0.9F, 1.1F, 2.0F}) {
    Particles<float, 3> y{Eigen::Matrix3Xf{{0, r * metre}, {0, 0}, {0, 0}}};
    Out<float, 3> out{Eigen::Matrix3Xf::Zero(3, 2)};
    Pairs{LennardJones{joule, metre}, 3 * metre}.add(0.0F, view_of(y), NeighborMemory{}, out);
    const double force = LennardJones{}(static_cast<double>(r) * static_cast<double>(r)) * static_cast<double>(r);
    CHECK(static_cast<double>(out.force(0, 1)) * static_cast<double>(metre / joule) == Approx(force).epsilon(1e-4));
  }
  for (const double unit : {1e-60, 1e-30, 1e30, 1e60}) {
    const LennardJones law{1, unit};
    CHECK(law(1.21 * unit * unit) * unit * unit == Approx(LennardJones{}(1.21)).epsilon(1e-12));
    CHECK(law.energy(1.21 * unit * unit) == Approx(LennardJones{}.energy(1.21)).epsilon(1e-12));
  }
}

TEST_CASE("types have the law of their pair") {
  auto y = shaken<double, 3>(2, 1.0, 8, {}, 0);
  y.r = y.r.leftCols(3).eval();
  Eigen::Matrix3Xd r(3, 3);
  r << 0, 1, 3, 0, 0, 0, 0, 0, 0;
  Particles<double, 3> three{r};
  three.set_type(Eigen::Vector3i(0, 1, 1));
  const Pairs force{ByType<LennardJones>{{{1, 1}, {2, 1.1}, {2, 1.1}, {3, 1.2}}}, 10.0};
  const double expected =
      LennardJones{2, 1.1}.energy(1.0) + LennardJones{2, 1.1}.energy(9.0) + LennardJones{3, 1.2}.energy(4.0);
  CHECK(force.energy(0.0, view_of(three)) == Approx(expected).epsilon(1e-14));
  CHECK_THROWS_AS((ByType<LennardJones>{{{1, 1}, {2, 1.1}, {2, 1.2}, {3, 1.2}}}), std::invalid_argument);
  CHECK_THROWS_AS((ByType<LennardJones>{{{1, 1}, {2, 1.1}, {2, 1.2}}}), std::invalid_argument);
  three.set_type(Eigen::Vector3i(0, 2, 1));
  CHECK_THROWS_AS(force.energy(0.0, view_of(three)), std::invalid_argument);
}

TEST_CASE("the tangent is that of all pairs of which one moves, whichever has the smaller index") {
  Eigen::Matrix3Xd r(3, 3);
  r << 0, 1.1, 0.2, 0, 0.1, 1.2, 0, -0.2, 0.3;
  const auto tangent = [&](const std::vector<std::uint8_t>& still) {
    Particles<double, 3> y{r};
    y.set_still(still);
    Dense dense{Eigen::MatrixXd::Zero(9, 9)};
    Pairs{LennardJones{}, 3.0}.add_jacobian(0.0, view_of(y), NeighborMemory{}, dense);
    return dense.K;
  };
  const Eigen::MatrixXd all = tangent({0, 0, 0});
  for (unsigned held = 0; held < 8; ++held) {
    CAPTURE(held);
    const auto is_still = [held](Index i) { return held >> i & 1u; };
    const Eigen::MatrixXd K = tangent({static_cast<std::uint8_t>(is_still(0)), static_cast<std::uint8_t>(is_still(1)),
                                       static_cast<std::uint8_t>(is_still(2))});
    for (Index i = 0; i < 3; ++i) {
      Eigen::Matrix3d others = Eigen::Matrix3d::Zero();
      for (Index j = 0; j < 3; ++j) {
        if (i == j) continue;
        const Eigen::Matrix3d pair = K.block<3, 3>(3 * i, 3 * j);
        CHECK(pair == (is_still(i) && is_still(j) ? Eigen::Matrix3d(Eigen::Matrix3d::Zero())
                                                  : Eigen::Matrix3d(all.block<3, 3>(3 * i, 3 * j))));
        others += pair;
      }
      CHECK(K.block<3, 3>(3 * i, 3 * i) == -others);
    }
  }
  CHECK(all.block<3, 3>(0, 3).norm() > 1);
}

TEST_CASE("still particles push, and are not pushed") {
  auto y = shaken<double, 3>(5, 1.1, 9, {true, true, true});
  Out<double, 3> all{Eigen::Matrix3Xd::Zero(3, y.size())}, some = all;
  const Pairs force{LennardJones{}, 2.0};
  force.add(0.0, view_of(y), NeighborMemory{}, all);
  const double energy = force.energy(0.0, view_of(y));
  const auto inside = force.pairs_inside(view_of(y));
  std::vector<std::uint8_t> still(static_cast<std::size_t>(y.size()));
  for (std::size_t i = 0; i < still.size(); i += 2) still[i] = 1;
  y.set_still(still);
  force.add(0.0, view_of(y), NeighborMemory{}, some);
  for (Index i = 0; i < y.size(); ++i)
    if (still[static_cast<std::size_t>(i)]) CHECK(some.force.col(i).norm() == 0);
    else CHECK((some.force.col(i) - all.force.col(i)).norm() <= 1e-13 * all.force.col(i).norm());
  // What is left out are the pairs of two still ones.
  double left_out = 0;
  std::uint64_t pairs = 0;
  for (Index i = 0; i < y.size(); i += 2)
    for (Index j = 0; j < i; j += 2) {
      const double r2 = y.body().box.nearest(y.r.col(i) - y.r.col(j)).squaredNorm();
      if (r2 < 4) left_out += LennardJones{}.energy(r2), ++pairs;
    }
  CHECK(force.energy(0.0, view_of(y)) == Approx(energy - left_out).epsilon(1e-12));
  CHECK(force.pairs_inside(view_of(y)) == inside - pairs);
  // All asleep: nothing is tested, listed or added.
  y.set_still(std::vector<std::uint8_t>(still.size(), 1));
  force.add(0.0, view_of(y), NeighborMemory{}, some);
  CHECK(force.pairs_tested() == 0);
}

TEST_CASE("counts on a lattice: neighbours of face-centred cubes") {
  // Neighbours at a/√2 (12), a (6), a √(3/2) (24), a √2 (12), a √(5/2) (24).
  constexpr int n = 4;
  Eigen::Matrix3Xd r(3, 4 * n * n * n);
  Index k = 0;
  for (int z = 0; z < n; ++z)
    for (int y = 0; y < n; ++y)
      for (int x = 0; x < n; ++x)
        for (const auto& q : {std::array{0., 0., 0.}, {.5, .5, 0.}, {.5, 0., .5}, {0., .5, .5}})
          r.col(k++) = 1.6 * Eigen::Vector3d(x + q[0], y + q[1], z + q[2]);
  Particles<double, 3> y{r};
  y.set_box(Box<double, 3>::periodic({0, 0, 0}, Eigen::Vector3d::Constant(1.6 * n)));
  const Pairs force{LennardJones{}, 1.6 * 1.3, {.skin = 1.6 * 0.2}};
  Out<double, 3> out{Eigen::Matrix3Xd::Zero(3, y.size())};
  force.add(0.0, view_of(y), NeighborMemory{}, out);
  CHECK(force.pairs_listed() == 54u * 256);
  CHECK(force.pairs_inside(view_of(y)) == 42u * 256 / 2);
  CHECK(force.rebuilds() == 1);
  // By symmetry there is no force: what remains are roundings of 42 forces F ≤ 40.
  CHECK(out.force.cwiseAbs().maxCoeff() < 42 * 40 * 14 * 6.4 * 2.3e-16);
}

TEST_CASE("the virial is the energy's answer to a change of volume") {
  auto y = shaken<double, 3>(5, 1.15, 10, {true, true, true});
  const Pairs force{SoftSphere{3.0, 2.0}, 2.0};  // smooth at the cutoff
  const double virial = force.virial(0.0, view_of(y));
  const auto scaled = [&](double s) {
    auto z = y;
    z.r *= s;
    z.set_box(Box<double, 3>::periodic({0, 0, 0}, s * y.body().box.upper));
    return force.energy(0.0, view_of(z));
  };
  constexpr double h = 1e-5;  // −dV/d ln s = Σ r·f; error h² V''' ≈ 1e-10 · 1e3 V
  CHECK((scaled(1 - h) - scaled(1 + h)) / (2 * h) == Approx(virial).epsilon(1e-7));
}

TEST_CASE("velocity Verlet asks once a step, and allocates nothing between lists") { check_quiet(copied); }

TEST_CASE("what a list takes of memory, a particle") {
  // 20³ of density 0.85 in a periodic box, 20.7 + 5.8 across with the images: 2.1 slots a particle, 83 neighbours. Eigen's
  // vectors are not counted: state, Ψ, what the kernel reads.
  auto y = shaken<double, 3>(20, 1.056, 3, {true, true, true}, 0.05);
  const std::int64_t before = heap::live;
  Pairs force{LennardJones{}, 2.5, {.skin = 0.4}};
  PhiStepper stepper{y, std::ref(force), velocity_verlet};
  for (int n = 0; n < 30; ++n) REQUIRE(stepper.step(y, 0.002 * n, 0.002));
  const double bytes = static_cast<double>(heap::live - before) / static_cast<double>(y.size());
  CAPTURE(bytes, force.rebuilds(), force.pairs_listed() / 8000);
  CHECK(bytes > 300);
  CHECK(bytes < 380);
}

TEST_CASE("a rejected step leaves no trace, and a checkpoint continues bit for bit") {
  auto y = hot(2);
  PhiStepper stepper{y, Pairs{LennardJones{}, 2.5, {.skin = 0.3}}, velocity_verlet};
  for (int n = 0; n < 13; ++n) REQUIRE(stepper.step(y, 0.004 * n, 0.004));
  auto z = y;
  PhiStepper other{z, Pairs{LennardJones{}, 2.5, {.skin = 0.3}}, velocity_verlet};
  other.set_memory(from_checkpoint(stepper.memory()));
  // A trial that is far too long: lists are made for where it goes, and go with it.
  const auto kept = y;
  const auto memory = stepper.memory();
  REQUIRE(stepper.step(y, 0.052, 0.06));
  REQUIRE(stepper.memory().reference != memory.reference);
  y = kept;
  stepper.set_memory(memory);
  for (int n = 13; n < 60; ++n) {
    REQUIRE(stepper.step(y, 0.004 * n, 0.004));
    REQUIRE(other.step(z, 0.004 * n, 0.004));
  }
  CHECK((y.r == z.r && y.v == z.v));
}

namespace {
/// n³ atoms far apart, that fly.
Particles<double, 3> gas(int n) {
  auto y = shaken<double, 3>(n, 3.5, 3, {true, true, true}, 0.05);
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  y.v = y.v.unaryExpr([&](double) { return 1.5 * normal(random); });
  return y;
}
}  // namespace

TEST_CASE("a skin finds its width: fewer lists, no pair missed, the same bits from a checkpoint") {
  const double cutoff = 1.5;
  auto y = gas(8), fixed_y = gas(8);
  PhiStepper stepper{y, Pairs{LennardJones{}, cutoff}, velocity_verlet};
  PhiStepper fixed_one{fixed_y, Pairs{LennardJones{}, cutoff, {.skin = 0.16 * cutoff}}, velocity_verlet};
  CHECK(stepper.force_to_look_at().skin() == 0.16 * cutoff);
  const auto go = [](auto& one, auto& state, int from, int to) {
    for (int n = from; n < to; ++n) REQUIRE(one.step(state, 0.005 * n, 0.005));
  };
  go(stepper, y, 0, 150), go(fixed_one, fixed_y, 0, 150);
  CHECK(stepper.force_to_look_at().skin() > 2 * 0.16 * cutoff);
  CHECK(3 * stepper.force_to_look_at().rebuilds() < fixed_one.force_to_look_at().rebuilds());
  const Pairs all{LennardJones{}, cutoff};
  CHECK(all.pairs_inside(view_of(y)) == stepper.force_to_look_at().pairs_inside(view_of(y), stepper.memory()));
  CHECK((y.r - fixed_y.r).cwiseAbs().maxCoeff() < 1e-9);  // the same but for rounding

  auto z = y;
  PhiStepper resumed{z, Pairs{LennardJones{}, cutoff}, velocity_verlet};
  resumed.set_memory(from_checkpoint(stepper.memory()));
  go(stepper, y, 150, 300), go(resumed, z, 150, 300);
  CHECK((y.r == z.r && y.v == z.v));
  CHECK(stepper.force_to_look_at().skin() == resumed.force_to_look_at().skin());
}

TEST_CASE("a matrix with an entry for each pair keeps the skin") {
  auto y = gas(3);
  PhiStepper stepper{y, Pairs{LennardJones{}, 1.5}, trapezoidal};
  for (int n = 0; n < 100; ++n) REQUIRE(stepper.step(y, 0.005 * n, 0.005));
  CHECK(stepper.force_to_look_at().rebuilds() > 5);
  CHECK(stepper.force_to_look_at().skin() == 0.16 * 1.5);
}

TEST_CASE("an unchecked list misses pairs, and they can be counted") {
  CHECK(missed(0, copied) == 0);
  CHECK(missed(20, copied) > 0);
}

TEST_CASE("who asks for an energy elsewhere does not change the run") {
  CHECK(end(false, copied) == end(true, copied));
}

TEST_CASE("what cannot be is refused, or named") {
  CHECK_THROWS_AS((Pairs{LennardJones{}, 0.0}), std::invalid_argument);
  CHECK_THROWS_AS((Pairs{LennardJones{}, -1.0}), std::invalid_argument);
  CHECK_THROWS_AS((Pairs{LennardJones{}, std::nan("")}), std::invalid_argument);
  CHECK_THROWS_AS((Pairs{LennardJones{}, HUGE_VAL}), std::invalid_argument);
  for (const double cutoff : {1e-30, 1e30}) {
    const auto few = shaken<float, 3>(2, 1.0, 12, {});
    CHECK_THROWS_AS((Pairs{LennardJones{}, cutoff}.energy(0.0, view_of(few))), std::invalid_argument);
  }
  CHECK_THROWS_AS((Pairs{LennardJones{}, 2.5, {.skin = -0.1}}), std::invalid_argument);
  CHECK_THROWS_AS((Pairs{LennardJones{}, 2.5, {.skin = std::nan("")}}), std::invalid_argument);
  {
    auto small = shaken<double, 3>(2, 1.0, 12, {true, true, true});
    PhiStepper stepper{small, Pairs{LennardJones{}, 2.5}, velocity_verlet};
    CHECK_THROWS_AS(stepper.step(small, 0, 0.001), std::invalid_argument);
  }
  {  // two at one place
    auto y = hot(4);
    y.r.col(100) = y.r.col(57);
    const auto kept = y;
    PhiStepper stepper{y, Pairs{LennardJones{}, 2.5}, velocity_verlet};
    const auto report = stepper.step(y, 0, 0.001);
    REQUIRE_FALSE(report);
    CHECK(report.outcome() == Outcome::non_finite_force);
    CHECK(report.message().find("57") != std::string::npos);
    CHECK((y.r == kept.r && y.v == kept.v));
  }
  {
    auto y = hot(5);
    y.r(1, 33) = std::nan("");
    PhiStepper stepper{y, Pairs{LennardJones{}, 2.5}, velocity_verlet};
    const auto report = stepper.step(y, 0, 0.001);
    REQUIRE_FALSE(report);
    CHECK(report.outcome() == Outcome::non_finite_state);
    CHECK(report.message().find("33") != std::string::npos);
  }
  for (const int n : {0, 1}) {
    Particles<double, 3> few{Eigen::Matrix3Xd::Zero(3, n)};
    PhiStepper stepper{few, Pairs{LennardJones{}, 2.5}, velocity_verlet};
    CHECK(stepper.step(few, 0, 0.001));
  }
}

TEST_CASE("units are free: powers of two change no bit") {
  const auto run = [](double length, double energy) {
    auto y = hot(6);
    y.r *= length;
    y.set_box(Box<double, 3>::periodic({0, 0, 0}, length * y.body().box.upper));
    const double time = 0.5 * length;  // v in units of 2: energy is m v² = 4
    y.v *= length / time;
    PhiStepper stepper{y, Pairs{LennardJones{energy, length}, 2.5 * length}, velocity_verlet};
    for (int n = 0; n < 40; ++n) REQUIRE(stepper.step(y, n * 0.004 * time, 0.004 * time));
    return Eigen::Matrix3Xd(y.r / length);
  };
  CHECK(run(0x1p-20, 4.0) == run(0x1p30, 4.0));
}

TEST_CASE("one thread and two: the same bits") {
  const auto run = [](int threads) {
    omp_set_num_threads(threads);
    auto y = hot(7);
    const Pairs measure{LennardJones{}, 2.5};
    PhiStepper stepper{y, Pairs{LennardJones{}, 2.5}, velocity_verlet};
    for (int n = 0; n < 100; ++n) REQUIRE(stepper.step(y, n * 0.004, 0.004));
    return std::tuple{y.r, y.v, measure.energy(0.0, view_of(y))};
  };
  CHECK(run(1) == run(2));
  CHECK(run(1) == run(3));
}

TEST_CASE("a law that throws in a thread of many: the exception passes, the atoms stay, the next step goes on") {
  check_throws(Pairs{throwing, 1.8});
}

#elif PHISTEP_FULL

TEST_CASE("pair forces are those of a sum over all pairs") {
  const LennardJones law{0.7, 1.1};
  for (const auto& periodic :
       {std::array{false, false, false}, std::array{true, true, true}, std::array{true, false, true}}) {
    check_forces(shaken<double, 3>(7, 1.25, 1, periodic), law, 2.5);
    check_forces(shaken<double, 2>(13, 1.25, 2, periodic), law, 2.5);
    check_forces(shaken<float, 3>(7, 1.25, 3, periodic), law, 2.5);
    check_forces(shaken<float, 2>(13, 1.25, 4, periodic), law, 2.5);
  }
}

TEST_CASE("a law of the user's own is as good") {
  const auto own = [](auto r2) {
    const auto y = reciprocal(r2), y3 = y * y * y;
    return y * y3 * (12 * 4.0 * y3 - 6 * 4.0);
  };
  check_own(own);
  const auto y = shaken<double, 3>(6, 1.2, 5, {true, true, true});
  check_forces(
      y, [](auto r2) { return 1 / (r2 * r2); }, 2.0);
  check_forces(
      y, [](auto) { return 2.0; }, 2.0);  // springs of length 0
}

TEST_CASE("forces are minus the slope of the energy, tangents that of the forces") {
  check_slopes(LennardJones{0.5, 0.9}, 2.1);
  check_slopes(LennardJones{0.5, 0.9}.shifted(2.1), 2.1);
  check_slopes(Yukawa{2.0, 0.8}, 2.1);
  check_slopes(ScreenedCharges{2.0, 0.8}, 2.1);
  check_slopes(NearField{1.0, 2.0, 0.5, 4.0}, 2.1);
  check_slopes(NearField{1.0, 1.0, 0.5, 3.5}, 2.1);
  check_slopes(SoftSphere{3.0, 2.1}, 2.1);
  check_slopes(lorentz_berthelot({{1.0, 0.8}, {0.3, 1.0}}), 2.1);
}

TEST_CASE("velocity Verlet asks once a step, and allocates nothing between lists") { check_quiet(referred_to); }

TEST_CASE("an unchecked list misses pairs, and they can be counted") {
  CHECK(missed(0, referred_to) == 0);
  CHECK(missed(20, referred_to) > 0);
}

TEST_CASE("who asks for an energy elsewhere does not change the run") {
  CHECK(end(false, referred_to) == end(true, referred_to));
}

TEST_CASE("implicit steps see the list as their sparsity") {
  auto y = hot(3);
  y.v *= 0.1;
  Pairs force{SoftSphere{50.0, 1.6}, 1.6};
  PhiStepper stepper{y, std::ref(force), trapezoidal};
  const auto view = [&] { return view_of(y); };
  const Pairs measure{SoftSphere{50.0, 1.6}, 1.6};
  const double before = 0.5 * y.v.squaredNorm() + measure.energy(0.0, view());
  for (int n = 0; n < 20; ++n) {
    const auto report = stepper.step(y, 0.005 * n, 0.005);
    CAPTURE(report.message());
    REQUIRE(report);
  }
  const double after = 0.5 * y.v.squaredNorm() + measure.energy(0.0, view());
  CHECK(after == Approx(before).epsilon(1e-3));  // (ωΔt)²/12, ω² ≈ 1500: 0.3 % of what is exchanged
  CHECK(stepper.statistics().analyses <= 1 + static_cast<std::int64_t>(force.rebuilds()));
}

TEST_CASE("positions in one flat vector") {
  const auto y = shaken<double, 3>(4, 1.2, 11, {});
  Motion<Eigen::VectorXd> flat{Eigen::Map<const Eigen::VectorXd>(y.r.data(), y.r.size()),
                               Eigen::VectorXd::Zero(y.r.size())};
  Particles<double, 3> z = y;
  PhiStepper a{flat, pairs<3>(LennardJones{}, 2.5), velocity_verlet};
  PhiStepper b{z, Pairs{LennardJones{}, 2.5}, velocity_verlet};
  for (int n = 0; n < 10; ++n) {
    REQUIRE(a.step(flat, 0.001 * n, 0.001));
    REQUIRE(b.step(z, 0.001 * n, 0.001));
  }
  CHECK(flat.r == Eigen::Map<const Eigen::VectorXd>(z.r.data(), z.r.size()));
}

TEST_CASE("a law that throws in a thread of many: the exception passes, the atoms stay, the next step goes on") {
  check_throws(Pairs{throwing, 1.8});
  check_throws(AllPairs{throwing});
}

#endif

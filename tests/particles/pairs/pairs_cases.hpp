// What pairs.test.cpp and pairs.full.cpp share.
#pragma once

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

template <class Scalar, int dim>
auto view_of(const Particles<Scalar, dim>& y) {
  return ParticleView<Scalar, dim, UnitMass>{y, UnitMass{}};
}
template <class Scalar, int dim>
struct Out {
  Eigen::Matrix<Scalar, dim, Eigen::Dynamic> force;
};

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
std::uint64_t missed(ListPolicy policy, auto hand) {
  auto y = hot(8);
  Pairs force{LennardJones{}, 2.5, {.skin = 0.1, .policy = policy}};
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

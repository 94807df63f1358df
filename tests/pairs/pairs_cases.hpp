// What pairs.test.cpp and pairs.full.cpp share.
#pragma once

#include <phistep/pairs/pairs.hpp>
#include <phistep/particles.hpp>

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

}  // namespace pairs_cases

namespace pairs_cases {
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
}  // namespace pairs_cases

#ifdef _OPENMP

#endif

/// @file
/// Sums over all pairs of particles, for particles/pairs/all_pairs.hpp: Σ_j w_j f(r²) (r_i − r_j) for every i.
///
/// As in the best of the kernels written by hand (bench/particles/gravity_hand.cpp), one array a coordinate; of a pair one
/// particle stands in a lane, the other, of four taken at once, in all lanes, so that each f serves both and nothing is
/// scattered. Blocks of particles meet as teams in a tournament, where none plays twice in a round: a round's games may run
/// on any number of threads, and every sum is taken in the same order.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "phistep/base/machine/loop_hints.hpp"
#include "phistep/base/machine/shares.hpp"
#include "phistep/base/numbers/pack.hpp"
#include "phistep/base/numbers/pack_math.hpp"

namespace phistep { inline namespace PHISTEP_ABI { namespace detail {

/// Particles in slots: coordinates, weights, sums. Those that move come first, filled up to whole packs by slots of weight 0,
/// then those that only act.
template <class Scalar, int dim>
class PairTournament {
 public:
  using P = Pack<Scalar, native_width<Scalar>>;
  static constexpr std::ptrdiff_t width = P::width;
  static constexpr int at_once = 4;  ///< particles in all lanes: their sums and coordinates fill the registers
  static constexpr std::ptrdiff_t granule = std::max<std::ptrdiff_t>(width, at_once);
  static constexpr std::ptrdiff_t team = 256;  ///< slots at most: the arrays of two teams stay in L1

  /// Room for so many particles; `memory` is kept by the caller, and grows only.
  PairTournament(std::ptrdiff_t movers, std::ptrdiff_t others, std::vector<unsigned char>& memory)
      : movers_{movers}, moving_{up(movers)}, slots_{moving_ + up(others)}, others_{others} {
    // A line more than needed between arrays: at a power of two apart they would share the cache's sets.
    stride_ = slots_ + 64 / static_cast<std::ptrdiff_t>(sizeof(Scalar));
    const std::size_t bytes = static_cast<std::size_t>(stride_ * (2 * dim + 1)) * sizeof(Scalar) + 64;
    if (memory.size() < bytes) memory.resize(bytes);
    const auto address = reinterpret_cast<std::uintptr_t>(memory.data());
    data_ = reinterpret_cast<Scalar*>(memory.data() + (64 - address % 64) % 64);
  }

  /// Arrays over the slots; particle number k of those that don't move is in slot first_still() + k.
  [[nodiscard]] Scalar* r(int a) const { return data_ + a * stride_; }
  [[nodiscard]] Scalar* weight() const { return r(dim); }
  [[nodiscard]] Scalar* sum(int a) const { return r(dim + 1 + a); }
  [[nodiscard]] std::ptrdiff_t first_still() const { return moving_; }

  /// Once the slots hold particles: fills the others with weight 0, at a place where no particle is, so that the law stays finite. Likewise
  /// particles at no finite place.
  void pad() const {
    Scalar outside[dim];
    for (int a = 0; a < dim; ++a) {
      Scalar low = std::numeric_limits<Scalar>::max(), high = -low;
      for_each_particle([&](std::ptrdiff_t s) {
        const Scalar x = r(a)[s];
        if (x - x == 0) low = std::min(low, x), high = std::max(high, x);
      });
      // By the particles' extent, where that is 0 by anything.
      outside[a] = high > low ? high + (high - low) : high != 0 ? 2 * high : Scalar{1};
    }
    const auto empty = [&](std::ptrdiff_t s) {
      for (int a = 0; a < dim; ++a) r(a)[s] = outside[a];
      weight()[s] = 0;
    };
    for_each_particle([&](std::ptrdiff_t s) {
      for (int a = 0; a < dim; ++a)
        if (!(r(a)[s] - r(a)[s] == 0)) return empty(s);
    });
    for (std::ptrdiff_t s = movers_; s < moving_; ++s) empty(s);
    for (std::ptrdiff_t s = moving_ + others_; s < slots_; ++s) empty(s);
  }

  /// sum(·)[i] = Σ_j w_j f(r²) (r_i − r_j) for those that move
  template <class Law>
  void play(const Law& f) const {
    const std::ptrdiff_t teams = (moving_ + team - 1) / team;
    if (teams == 0) return;
    const std::ptrdiff_t size = up((moving_ + teams - 1) / teams);
    const auto first = [&](std::ptrdiff_t k) { return std::min(k * size, moving_); };
    // Rounds of the circle method: the last team stays, the others turn around it; of an odd number one rests.
    const std::ptrdiff_t seats = teams + teams % 2;
    Relay relay;
    PHISTEP_DETAIL_OMP("omp parallel if (teams > 1)") {
      PHISTEP_DETAIL_OMP("omp for schedule(static)")
      for (std::ptrdiff_t k = 0; k < teams; ++k) relay.run([&] { train(f, first(k), first(k + 1)); });
      for (std::ptrdiff_t round = 0; round + 1 < seats; ++round) {
        PHISTEP_DETAIL_OMP("omp for schedule(static)")
        for (std::ptrdiff_t k = 0; k < seats / 2; ++k) {
          const std::ptrdiff_t a = k == 0 ? seats - 1 : (round + k) % (seats - 1);
          const std::ptrdiff_t b = (round + (seats - 1) - k) % (seats - 1);
          if (a >= teams || b >= teams) continue;
          relay.run([&] {
            for (std::ptrdiff_t j = first(b); j < std::min(first(b + 1), movers_); j += at_once)
              serve(f, j, first(a), first(a + 1));
          });
        }
      }
    }
    relay.rethrow();
  }

  /// Σ w_i w_j U(r²) over pairs of which one moves at least. The sums' arrays are overwritten.
  template <class Potential>
  [[nodiscard]] Scalar total(const Potential& U) const {
    const std::ptrdiff_t packs = moving_ / width;
    PHISTEP_DETAIL_OMP("omp parallel for schedule(static, 16) if (moving_ > team)")
    for (std::ptrdiff_t k = 0; k < packs; ++k) {
      const std::ptrdiff_t i = k * width;
      const Lane lane = at(i);
      P whole{0};
      const auto add = [&](std::ptrdiff_t j, auto counts) {
        P d[dim];
        const P u = U(square(lane, j, d));
        whole = fma(counts(u), P{weight()[j]}, whole);
      };
      for (std::ptrdiff_t j = 0; j < i; ++j) add(j, [](P u) { return u; });
      for (std::ptrdiff_t j = i; j < i + width; ++j) add(j, [&](P u) { return select(lanes() > P{j - i}, u, P{0}); });
      for (std::ptrdiff_t j = moving_; j < slots_; ++j) add(j, [](P u) { return u; });
      // The filling's lanes may hold anything.
      select(first_lanes<P>(movers_ - i), whole * P::load_aligned(weight() + i), P{0}).store_aligned(sum(0) + i);
    }
    Scalar all{0};
    for (std::ptrdiff_t i = 0; i < moving_; i += width) all += phistep::sum(P::load_aligned(sum(0) + i));
    return all;
  }

 private:
  using Lane = std::array<P, dim>;
  [[nodiscard]] static std::ptrdiff_t up(std::ptrdiff_t n) { return (n + granule - 1) / granule * granule; }
  [[nodiscard]] static P lanes() {
    return P::make([](int l) { return static_cast<Scalar>(l); });
  }
  void for_each_particle(auto&& f) const {
    for (std::ptrdiff_t s = 0; s < movers_; ++s) f(s);
    for (std::ptrdiff_t s = moving_; s < moving_ + others_; ++s) f(s);
  }
  [[nodiscard]] Lane at(std::ptrdiff_t i) const {
    Lane lane;
    unrolled<dim>([&](auto a) { lane[a] = P::load_aligned(r(a) + i); });
    return lane;
  }
  /// d = r_i − r_j and its square
  [[nodiscard]] P square(const Lane& lane, std::ptrdiff_t j, P* d) const {
    unrolled<dim>([&](auto a) { d[a] = lane[a] - P{r(a)[j]}; });
    P r2 = d[0] * d[0];
    unrolled<dim - 1>([&](auto a) { r2 = fma(d[a + 1], d[a + 1], r2); });
    return r2;
  }

  /// `at_once` particles j and those in [first, last) act on each other. The law comes as a copy: through a reference its
  /// numbers would be read again after each store.
  template <class Law>
  [[gnu::flatten]] void serve(Law f, std::ptrdiff_t j, std::ptrdiff_t first, std::ptrdiff_t last) const {
    P theirs[at_once][dim];
    unrolled<at_once>([&](auto b) { unrolled<dim>([&](auto a) { theirs[b][a] = P{0}; }); });
    for (std::ptrdiff_t i = first; i < last; i += width) {
      const Lane lane = at(i);
      const P w = P::load_aligned(weight() + i);
      P mine[dim];
      unrolled<dim>([&](auto a) { mine[a] = P::load_aligned(sum(a) + i); });
      unrolled<at_once>([&](auto b) {
        P d[dim];
        const P k = f(square(lane, j + b, d)), to_mine = k * P{weight()[j + b]}, to_theirs = k * w;
        unrolled<dim>([&](auto a) {
          mine[a] = fma(to_mine, d[a], mine[a]);
          theirs[b][a] = fma(to_theirs, d[a], theirs[b][a]);
        });
      });
      unrolled<dim>([&](auto a) { mine[a].store_aligned(sum(a) + i); });
    }
    unrolled<at_once>([&](auto b) { unrolled<dim>([&](auto a) { sum(a)[j + b] -= phistep::sum(theirs[b][a]); }); });
  }
  /// Sums over pairs inside a team, and over particles that don't move. Runs first: it sets sums, games add to them.
  template <class Law>
  [[gnu::flatten]] void train(Law f, std::ptrdiff_t first, std::ptrdiff_t last) const {
    const P numbers = lanes();
    for (std::ptrdiff_t i = first; i < last; i += width) {
      const Lane lane = at(i);
      P mine[dim];
      unrolled<dim>([&](auto a) { mine[a] = P{0}; });
      const auto take = [&](std::ptrdiff_t j, auto counts) {
        P d[dim];
        const P k = counts(f(square(lane, j, d))) * P{weight()[j]};
        unrolled<dim>([&](auto a) { mine[a] = fma(k, d[a], mine[a]); });
      };
      // The square on the diagonal, one by one; `serve` does what lies beside it.
      const std::ptrdiff_t square_first = first + (i - first) / granule * granule;
      for (std::ptrdiff_t j = square_first; j < std::min(square_first + granule, movers_); ++j)
        take(j, [&](P k) { return select(numbers == P{j - i}, P{0}, k); });  // no force on itself
      for (std::ptrdiff_t j = moving_; j < moving_ + others_; ++j) take(j, [](P k) { return k; });
      unrolled<dim>([&](auto a) { mine[a].store_aligned(sum(a) + i); });
    }
    for (std::ptrdiff_t j = first; j < std::min(last, movers_); j += at_once)
      serve(f, j, first, first + (j - first) / granule * granule);
  }

  Scalar* data_ = nullptr;
  std::ptrdiff_t movers_, moving_, slots_, others_, stride_ = 0;
};

}}}  // namespace phistep::PHISTEP_ABI::detail

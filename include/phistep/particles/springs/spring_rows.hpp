/// @file
/// The forces of many springs, row by row: each particle sums over all its springs, so that every spring is computed twice and nothing is
/// scattered. Threads then change no bit, and a row's arithmetic fills whole registers.
///
/// Particles are renumbered once, so that neighbours stand close (linear/network/node_order.hpp); positions are copied into that order a
/// little before they are needed, and sums added to the user's force. As many rows as a register has lanes make a chunk, padded to its
/// longest row (SELL: Kreutzer et al., SIAM J. Sci. Comput. 36 (2014) C401). In a regular mesh the other ends of a column of a chunk
/// mostly are consecutive particles: these need neither indices nor a gather.
#pragma once

#include <Eigen/Core>

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <utility>
#include <vector>

#include "phistep/base/machine/loop_hints.hpp"
#include "phistep/base/machine/shares.hpp"
#include "phistep/base/numbers/pack.hpp"
#include "phistep/base/numbers/pack_math.hpp"
#include "phistep/particles/springs/spring_layout.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// First positions, and velocities where damped, in the rows' order; then the sums of forces in place of them. Needed where that order
/// leads all over the user's arrays (0.4 of the time of a shuffled sheet of 490,000): these are read and written in their own order, and
/// random access goes to this array of whole particles, which is still in the caches.
template <class Scalar, int dim, bool damped>
class SpringStage {
  using Slot = std::int32_t;

 public:
  /// Of one particle to the next: so many numbers lie within one line of the cache.
  static constexpr std::ptrdiff_t stride = std::bit_ceil(static_cast<unsigned>(dim * (damped ? 2 : 1)));

  SpringStage() = default;
  /// @param place_of  where each of the user's particles stands among the rows, −1: nowhere; empty: no stage is needed
  /// @param places    of rows
  SpringStage(std::vector<Slot> place_of, std::size_t places)
      : place_of_{std::move(place_of)},
        stage_{Numbers::Zero(place_of_.empty() ? 0 : stride * static_cast<Eigen::Index>(places))} {}

  [[nodiscard]] bool empty() const { return place_of_.empty(); }
  /// What the calling thread takes of the user's particles.
  [[nodiscard]] Share share() const { return own_share(place_of_.size()); }
  [[nodiscard]] const Scalar* r() const { return stage_.data(); }
  [[nodiscard]] const Scalar* v() const { return stage_.data() + dim; }
  [[nodiscard]] Scalar* sum(std::size_t place) { return stage_.data() + stride * static_cast<std::ptrdiff_t>(place); }

  void bring(const Share& share, const Scalar* r, const Scalar* v) {
    move(share, r, stage_.data());
    if constexpr (damped) move(share, v, stage_.data() + dim);
  }
  /// f += the sums
  void give(const Share& share, Scalar* f) const {
    for_each(share, stage_.data(), [&](const Scalar* sum, std::size_t i) {
      for (std::size_t a = 0; a < dim; ++a) f[dim * i + a] += sum[a];
    });
  }

 private:
  using Numbers = Eigen::Matrix<Scalar, Eigen::Dynamic, 1>;

  void move(const Share& share, const Scalar* from, Scalar* to) const {
    for_each(share, to, [&](Scalar* x, std::size_t i) {
      for (std::size_t a = 0; a < dim; ++a) x[a] = from[dim * i + a];
    });
  }
  /// f(place of particle i in the stage, i)
  void for_each(const Share& share, auto* stage, auto&& f) const {
    constexpr std::size_t ahead = 48;
    for (std::size_t i = share.begin; i < share.end; ++i) {
      if (const Slot later = place_of_[std::min(i + ahead, share.end - 1)]; later >= 0)
        prefetch(stage + stride * later);
      if (place_of_[i] >= 0) f(stage + stride * place_of_[i], i);
    }
  }

  std::vector<Slot> place_of_;
  Numbers stage_;
};

/// Has a workspace: one object serves one caller at a time, a copy has its own.
template <class Scalar, int dim, bool damped>
class SpringRows {
  static constexpr std::size_t lanes = native_width<Scalar>;
  using P = Pack<Scalar, native_width<Scalar>>;
  using Vector = std::array<P, dim>;
  using Slot = std::int32_t;  // a particle's new number
  using Stage = SpringStage<Scalar, dim, damped>;
  static constexpr bool may_be_quads = dim > 1 && dim <= 4;
  /// Springs from which threads are woken: that takes some 5 µs, a spring 3 ns.
  static constexpr std::size_t parallel_from = 10'000;

 public:
  /// Whether rows take less time than a loop over the springs, which works out each spring once. With 4 and more lanes they
  /// do from some 100 springs on (0.55 … 0.8 of it at 1000); 2 lanes need a tenth to a quarter more time, and serve where
  /// threads share it. Numbers without lanes are left to the loop.
  [[nodiscard]] static bool suits(std::size_t springs, std::ptrdiff_t particles) {
#ifdef _OPENMP
    constexpr bool threads = true;
#else
    constexpr bool threads = false;
#endif
    constexpr std::size_t least = lanes >= 4 ? 256 : parallel_from;
    return (lanes >= 4 || (lanes > 1 && threads)) && springs >= least && springs < std::size_t{1} << 25 &&
           particles < std::numeric_limits<Slot>::max();
  }
  [[nodiscard]] bool empty() const { return place_.empty(); }

  /// @param particles  more than any spring names
  void build(const auto& springs, std::ptrdiff_t particles) {
    at_ = SpringLayout<Scalar, lanes>(springs, particles, may_be_quads);
    is_parallel_ = springs.size() >= parallel_from;
    // A gather from arrays of coordinates takes longer than one of whole particles.
    quads_ = at_.mixed;
    stride_ = (at_.chunk.size() - 1) * lanes;
    stage_ = Stage{std::move(at_.place_of), stride_};
    place_.assign(stride_ * (quads_ ? 4 : dim) * (damped ? 2 : 1), Scalar{0});
  }

  /// f += the springs' forces; arrays of dim components a particle in the user's order.
  /// @param still  not null: flags of particles whose force is not wanted
  /// @param c      of the dashpots [force·time/length]
  void add(const Scalar* r, const Scalar* v, const std::uint8_t* still, Scalar c, Scalar* f) {
    if constexpr (may_be_quads)
      if (quads_) return add_to<true>(r, v, still, c, f);
    add_to<false>(r, v, still, c, f);
  }

 private:
  template <bool quads>
  void add_to(const Scalar* r, const Scalar* v, const std::uint8_t* still, Scalar c, Scalar* f) {
    PHISTEP_DETAIL_OMP("omp parallel if (is_parallel_)") {
      const Share chunks = own_share(at_.chunk.size() - 1), particles = stage_.share();
      const std::size_t first = chunks.begin, last = chunks.end;
      // Positions a little ahead, while they are in the cache; what neighbouring threads need, before anything else.
      const std::size_t shared = last - first > at_.lead ? last - at_.lead : first;
      std::size_t next = std::min(first + at_.lead, shared);
      if (!stage_.empty()) {
        stage_.bring(particles, r, v);
        PHISTEP_DETAIL_OMP("omp barrier")
      }
      for (std::size_t b = first; b < next; ++b) take<quads>(b, r, v);
      for (std::size_t b = shared; b < last; ++b) take<quads>(b, r, v);
      PHISTEP_DETAIL_OMP("omp barrier")
      for (std::size_t b = first; b < last; ++b) {
        if (next < shared) take<quads>(next++, r, v);
        add_chunk<quads>(b, still, c, f);
      }
      if (!stage_.empty()) {
        PHISTEP_DETAIL_OMP("omp barrier")
        stage_.give(particles, f);
      }
    }
  }

  template <bool quads>
  void take(std::size_t chunk, const Scalar* r, const Scalar* v) {
    const std::size_t first = chunk * lanes, last = std::min(first + lanes, at_.user.size());
    const auto copy = [&](const Scalar* user, const Scalar* staged, Scalar* to) {
      const bool is_staged = !stage_.empty();
      for (std::size_t s = first; s < last; ++s) {
        const Scalar* const x = is_staged ? staged + Stage::stride * static_cast<std::ptrdiff_t>(s)
                                          : user + std::ptrdiff_t{dim} * at_.user[s];
        for (std::size_t a = 0; a < dim; ++a) to[quads ? 4 * s + a : a * stride_ + s] = x[a];
      }
    };
    copy(r, stage_.r(), place_.data());
    if constexpr (damped) copy(v, stage_.v(), place_.data() + stride_ * (quads ? 4 : dim));
  }
  template <bool quads>
  [[nodiscard]] Vector consecutive(const Scalar* from, std::size_t slot) const {
    if constexpr (quads) {
      std::array<Slot, lanes> slots;
      for (std::size_t l = 0; l < lanes; ++l) slots[l] = static_cast<Slot>(slot + l);
      return gather<true>(from, slots.data());
    } else {
      Vector x;
      unrolled<dim>([&](auto a) { x[a] = P::load(from + a * stride_ + slot); });
      return x;
    }
  }
  template <bool quads>
  [[nodiscard]] Vector gather(const Scalar* from, const Slot* slots) const {
    Vector x;
    if constexpr (quads) {
      const FourPacks<P> four = gather4<P>(from, slots);
      const P all[] = {four.x, four.y, four.z, four.w};
      unrolled<dim>([&](auto a) { x[a] = all[a]; });
    } else {
      unrolled<dim>([&](auto a) { x[a] = P::gather(from + a * stride_, slots); });
    }
    return x;
  }
  template <bool quads>
  [[nodiscard]] Vector others(const Scalar* from, const typename SpringLayout<Scalar, lanes>::Column& column) const {
    if constexpr (!quads)
      if (column.at >= 0) return consecutive<false>(from, static_cast<std::size_t>(column.at));
    return gather<quads>(from, at_.index.data() + ~column.at);
  }
  [[nodiscard]] P constant(std::int32_t at) const {
    return at >= 0 ? P::load(at_.constant.data() + at) : P{at_.constant[static_cast<std::size_t>(~at)]};
  }

  /// Each operation is odd or even in r_j − r_i: what two ends find are exact opposites.
  template <bool quads>
  [[gnu::flatten]] void add_chunk(std::size_t chunk, const std::uint8_t* still, Scalar c, Scalar* f) {
    const std::size_t first = chunk * lanes, last = std::min(first + lanes, at_.user.size());
    const bool skips = still != nullptr &&
                       std::all_of(&at_.user[first], &at_.user[0] + last, [still](Slot i) { return still[i] != 0; });
    if (skips && !stage_.empty()) std::fill_n(stage_.sum(first), Stage::stride * lanes, Scalar{0});
    if (skips) return;
    const Scalar* const place = place_.data();
    [[maybe_unused]] const Scalar* const velocity = place + stride_ * (quads ? 4 : dim);
    const Vector r = consecutive<quads>(place, first);
    [[maybe_unused]] Vector v;
    if constexpr (damped) v = consecutive<quads>(velocity, first);
    Vector sum;
    unrolled<dim>([&](auto a) { sum[a] = P{0}; });
    for (std::size_t w = at_.chunk[chunk]; w < at_.chunk[chunk + 1]; ++w) {
      const auto column = at_.column[w];
      Vector d = others<quads>(place, column);
      P square{0};
      unrolled<dim>([&](auto a) {
        d[a] -= r[a];
        square = fma(d[a], d[a], square);
      });
      // f/ℓ = k − k L/ℓ + c d·Δv/ℓ²
      const P inverse = rsqrt(square);
      P pull = fma(-constant(column.kL), inverse, constant(column.k));
      if constexpr (damped) {
        const Vector u = others<quads>(velocity, column);
        P along{0};
        unrolled<dim>([&](auto a) { along = fma(d[a], u[a] - v[a], along); });
        pull += P{c} * along * (inverse * inverse);
      }
      // Ends in one point: k d = 0 where L = 0; else no direction: infinity times d = 0, which the step reports.
      pull = select(square + constant(column.kL) == P{0}, P{0}, pull);
      unrolled<dim>([&](auto a) { sum[a] = fma(pull, d[a], sum[a]); });
    }
    std::array<std::array<Scalar, lanes>, dim> sums;
    unrolled<dim>([&](auto a) { sum[a].store(sums[a].data()); });
    if (!stage_.empty()) {
      for (std::size_t s = first; s < last; ++s)
        for (std::size_t a = 0; a < dim; ++a) stage_.sum(s)[a] = sums[a][s - first];
      return;
    }
    for (std::size_t s = first; s < last; ++s) {
      Scalar* const to = f + std::ptrdiff_t{dim} * at_.user[s];
      for (std::size_t a = 0; a < dim; ++a) to[a] += sums[a][s - first];
    }
  }

  SpringLayout<Scalar, lanes> at_;
  bool is_parallel_ = false;
  bool quads_ = false;         // whole particles side by side, four numbers each, rather than arrays of coordinates
  std::size_t stride_ = 0;     // places
  std::vector<Scalar> place_;  // positions, and velocities where damped, in the new order
  Stage stage_;
};

}}  // namespace phistep::PHISTEP_ABI

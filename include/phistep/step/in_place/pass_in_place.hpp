/// @file
/// One explicit pass over arrays in place: piece by piece, what it overwrites kept in a log, from which it can be put back, results
/// written where their arguments were.
#pragma once

#include <Eigen/Core>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <tuple>
#include <type_traits>
#include <utility>

#include "phistep/base/numbers/fingerprint.hpp"
#include "phistep/base/numbers/update.hpp"
#include "phistep/base/state/blocks.hpp"
#include "phistep/base/state/strided_block.hpp"
#include "phistep/step/equation/explicit_update.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// How arrays that are worked on together lie: all in one piece each, a piece for each component, or anyhow.
enum class Layout { contiguous, components, strided };
template <class... Block>
[[nodiscard]] Layout layout_of(const Block&... places) {
  if ((places.is_contiguous() && ...)) return Layout::contiguous;
  return ((places.stride == 1) && ...) ? Layout::components : Layout::strided;
}

/// The numbers of the solved block, of the positions where the state has them, and of the forces. In each piece of
/// places_chunk vectors they are sorted as the layout has them: vector by vector, or by components.
template <State S>
class UndoLog {
 public:
  using Scalar = ScalarOf<S>;
  static constexpr bool drifts = Blocks<S>::drifts;
  static constexpr std::size_t solved = drifts ? 1 : 0;  ///< which block

  /// A step begins. False where the arrays have another length than in the step before.
  bool begin(const S& state) {
    const auto rate = state.rate();
    const Index n = rate.size();
    const Layout now = layout(state);
    const bool same = n == psi_.size() && now == layout_;
    if (!same) {
      for (Numbers* all : {&v_, &psi_, &psi_next_}) all->resize(n);
      if constexpr (drifts) r_.resize(n);
      layout_ = now;
      forget();
    }
    has_state_ = has_next_ = false;
    return same;
  }
  /// The forces of the arrays have changed since.
  void forget() { has_psi_ = false; }
  /// The step is done.
  void accept() {
    if (has_next_) psi_.swap(psi_next_);
    has_psi_ = has_next_;
  }
  /// Keeps the forces as the arrays have them, unless the last step has done so.
  void keep_rate(S& state) {
    if (std::exchange(has_psi_, true)) return;
    take(state.rate(), psi_);
  }
  /// Keeps r and v likewise.
  void keep_state(S& state) {
    if (std::exchange(has_state_, true)) return;
    auto blocks = Blocks<S>::all(state);
    if constexpr (drifts) take(std::get<0>(blocks), r_);
    take(std::get<solved>(blocks), v_);
  }
  void put_back_state(S& state) {
    if (!std::exchange(has_state_, false)) return;
    auto blocks = Blocks<S>::all(state);
    if constexpr (drifts) give(r_, std::get<0>(blocks));
    give(v_, std::get<solved>(blocks));
  }
  void put_back(S& state) {
    put_back_state(state);
    if (has_psi_) give(psi_, state.rate());
  }

  [[nodiscard]] Layout layout() const { return layout_; }
  [[nodiscard]] const Scalar* psi() const { return psi_.data(); }

  /// For a pass: where it keeps what it overwrites, from number `at` on. (To stream it past the caches gains nothing.)
  struct Piece {
    Scalar *r, *v, *psi;
  };
  [[nodiscard]] Piece piece(Index at) {
    return {drifts ? r_.data() + at : nullptr, v_.data() + at, psi_next_.data() + at};
  }
  /// A pass has kept these.
  void kept(bool state, bool psi) {
    has_state_ = has_state_ || state;
    has_next_ = has_next_ || psi;
  }

 private:
  using Numbers = Eigen::Matrix<Scalar, Eigen::Dynamic, 1>;

  [[nodiscard]] static Layout layout(const S& state) {
    auto blocks = Blocks<S>::all(state);
    if constexpr (drifts) return layout_of(std::get<0>(blocks), std::get<1>(blocks), state.rate());
    else return layout_of(std::get<0>(blocks), state.rate());
  }
  void take(const auto& from, Numbers& to) const {
    each(from, [&to](const auto& places, Index p, Index m, Index at) { places.gather(p, m, to.data() + at); });
  }
  void give(const Numbers& from, const auto& to) const {
    each(to, [&from](const auto& places, Index p, Index m, Index at) { places.scatter(from.data() + at, p, m); });
  }
  template <class T, int D>
  void each(const StridedBlock<T, D>& places, auto&& f) const {
    for (Index p = 0; p < places.count; p += places_chunk<D>) {
      const Index m = std::min(places_chunk<D>, places.count - p);
      if (layout_ != Layout::components) f(places, p, m, p * D);
      else
        for (Index d = 0; d < D; ++d)
          f(StridedBlock<T, 1>{{places.at[static_cast<std::size_t>(d)]}, 1, places.count}, p, m, p * D + d * m);
    }
  }

  Numbers r_, v_, psi_, psi_next_;
  Layout layout_ = Layout::strided;
  bool has_state_ = false, has_psi_ = false, has_next_ = false;
};

/// @tparam Factor  component ↦ h/m, components counted vector by vector
template <State S, class Factor, class By>
class PassInPlace {
  static constexpr bool drifts = Blocks<S>::drifts;
  using Block = std::remove_cvref_t<decltype(std::declval<S&>().rate())>;
  static constexpr Index dim = Block::dim, chunk = places_chunk<Block::dim>;

 public:
  using Scalar = ScalarOf<S>;
  using Piece = typename UndoLog<S>::Piece;

  /// @param psi  Ψ from a log of this layout, null: from the arrays
  PassInPlace(S& state, Factor factor, const By& by, const Scalar* psi)
      : v_{std::get<UndoLog<S>::solved>(Blocks<S>::all(state))},
        r_{std::get<0>(Blocks<S>::all(state))},
        psi_{state.rate()},
        factor_{factor},
        by_{by},
        known_{psi} {}

  /// False where a result isn't finite.
  /// @tparam keeps_state  it is a step's first pass: r and v are kept, and positions move
  /// @param looks         the bits of the positions are checked
  template <bool keeps_state, bool keeps_psi>
  [[nodiscard]] bool run(UndoLog<S>& log, bool looks) {
    bool finite = true;
    for (Index p = 0; p < psi_.count; p += chunk) {
      const Index m = std::min(chunk, psi_.count - p), at = p * dim;
      const Piece kept = log.piece(at);
      switch (log.layout()) {
        case Layout::contiguous:
          finite = span<keeps_state, keeps_psi>(0, at, m * dim, at, 1, kept) && finite;
          break;
        case Layout::components:
          for (Index d = 0; d < dim; ++d)
            finite = span<keeps_state, keeps_psi>(d, p, m, at + d * m, dim, from(kept, d * m)) && finite;
          break;
        case Layout::strided:
          finite = vectors<keeps_state, keeps_psi>(p, m, kept) && finite;
          break;
      }
      if (keeps_state && drifts && looks) {
        found_ = fingerprint(kept.r, m * dim, found_);
        Scalar moved[chunk * dim];
        look_at(log.layout(), p, m, moved);
        left_ = fingerprint(moved, m * dim, left_);
      }
    }
    log.kept(keeps_state, keeps_psi);
    return finite;
  }
  /// The positions before and after, by their bits.
  [[nodiscard]] std::uint64_t found() const { return found_; }
  [[nodiscard]] std::uint64_t left() const { return left_; }

 private:
  [[nodiscard]] static Piece from(const Piece& piece, Index i) {
    return {drifts ? piece.r + i : nullptr, piece.v + i, piece.psi + i};
  }

  /// Neighbours in each array from these on, and where the log keeps them.
  struct At {
    Scalar *v, *r;
    const Scalar* psi;
    Piece kept;
  };
  /// The update of number i, from such places on, which keeps what it overwrites; as (v⁺, r⁺) or as v⁺ alone.
  template <bool keeps_state, bool keeps_psi>
  [[nodiscard, gnu::always_inline]] auto update_from(const At& at, const auto& factor) const {
    const By by = by_;
    return [=](auto i, auto& v1, auto&... r1) PHISTEP_DETAIL_INLINED {
      if constexpr (keeps_state) keep(i, at.v, at.kept.v);
      if constexpr (keeps_psi) keep(i, at.psi, at.kept.psi);
      if constexpr (sizeof...(r1) == 0) {
        phistep::Kick{Input<Scalar>{at.v}, Input<Scalar>{at.psi}, factor}(i, v1);
      } else {
        keep(i, at.r, at.kept.r);
        KickAndDrift{Input<Scalar>{at.r}, Input<Scalar>{at.v}, Input<Scalar>{at.psi}, factor, by.before, by.after}(
            i, v1, r1...);
      }
    };
  }
  static void keep(auto i, const Scalar* from, Scalar* to) { put(i, Input{from}[i], to); }
  static void put(Index i, Scalar x, Scalar* to) { to[i] = x; }
  template <int width>
  static void put(From<Scalar, width> i, Pack<Scalar, width> x, Scalar* to) {
    x.store(to + i.i);
  }

  /// n neighbours in each array, from number `at` of component d on; `logged`: where the log has them.
  template <bool keeps_state, bool keeps_psi>
  [[nodiscard]] bool span(Index d, Index at, Index n, Index logged, Index stride, const Piece& kept) const {
    const auto c = static_cast<std::size_t>(d);
    Scalar* const v = v_.at[c] + at;
    Scalar* const r = r_.at[c] + at;
    const At all{v, r, known_ != nullptr ? known_ + logged : psi_.at[c] + at, kept};
    const auto update = [&](const auto& kernel) {
      if constexpr (keeps_state && drifts) return update_in_place(n, kernel, v, r);
      else return update_in_place(n, kernel, v);
    };
    if (stride == 1)
      return update(update_from<keeps_state, keeps_psi>(all, [f = factor_, at](auto i) { return f(i + at); }));
    // Factors of a component alone are no neighbours: no packets.
    const auto apart = [f = factor_, first = at * stride + d, stride](Index i) { return f(first + i * stride); };
    return update(
        [kernel = update_from<keeps_state, keeps_psi>(all, apart)](Index i, auto&... out) { kernel(i, out...); });
  }

  /// m vectors from p on, wherever their numbers are.
  template <bool keeps_state, bool keeps_psi>
  [[nodiscard]] bool vectors(Index p, Index m, const Piece& kept) const {
    Witness witness;
    if (v_.is_adjacent() && r_.is_adjacent() && psi_.is_adjacent()) {
      At at{v_.at[0] + p * v_.stride, r_.at[0] + p * r_.stride,
            known_ != nullptr ? known_ + p * dim : psi_.at[0] + p * psi_.stride, kept};
      const Index psi_stride = known_ != nullptr ? dim : psi_.stride;
      for (Index i = 0; i < m; ++i) {
        vector<keeps_state, keeps_psi>(at, (p + i) * dim, witness);
        at = {at.v + v_.stride, at.r + r_.stride, at.psi + psi_stride, from(at.kept, dim)};
      }
    } else {
      for (Index i = 0, k = 0; i < m; ++i)
        for (std::size_t d = 0; d < dim; ++d, ++k) {
          const At at{v_.at[d] + (p + i) * v_.stride, r_.at[d] + (p + i) * r_.stride,
                      known_ != nullptr ? known_ + p * dim + k : psi_.at[d] + (p + i) * psi_.stride, from(kept, k)};
          numbers<keeps_state, keeps_psi, Scalar>(at, p * dim + k, Index{0}, witness);
        }
    }
    return witness.all_finite();
  }
  /// Whether all numbers seen, alone or in packets, are finite.
  struct Witness {
    FiniteWitness<Scalar> scalars;
#if PHISTEP_DETAIL_STREAMS
    static constexpr bool has_packets = sizeof(Scalar) == 8;
    std::conditional_t<has_packets, Packet<double>, int> packets{0};
    void see(Packet<double> x) { packets = bit_or(packets, x - x); }
    [[nodiscard]] bool all_finite() const {
      FiniteWitness<Scalar> all = scalars;
      if constexpr (has_packets) all.see(packets[0]), all.see(packets[1]);
      return all.all_finite();
    }
#else
    static constexpr bool has_packets = false;
    [[nodiscard]] bool all_finite() const { return scalars.all_finite(); }
#endif
    void see(Scalar x) { scalars.see(x); }
  };
  /// One vector of adjacent numbers, two at a time where there are registers for that.
  template <bool keeps_state, bool keeps_psi>
  [[gnu::always_inline]] void vector(const At& at, Index component, Witness& witness) const {
#if PHISTEP_DETAIL_STREAMS
    if constexpr (Witness::has_packets && dim == 3) {
      numbers<keeps_state, keeps_psi, Packet<Scalar>>(at, component, PacketPlace<Scalar>{0}, witness);
      numbers<keeps_state, keeps_psi, Scalar>(at, component, Index{2}, witness);
      return;
    }
#endif
    [&]<std::size_t... d>(std::index_sequence<d...>) PHISTEP_DETAIL_INLINED {
      (numbers<keeps_state, keeps_psi, Scalar>(at, component, Index{d}, witness), ...);
    }
    (std::make_index_sequence<static_cast<std::size_t>(dim)>{});
  }
  template <bool keeps_state, bool keeps_psi, class Number>
  [[gnu::always_inline]] void numbers(const At& at, Index component, auto i, Witness& witness) const {
    const Factor f = factor_;
    const auto factor = [=](auto j) PHISTEP_DETAIL_INLINED { return f(j + component); };
    const auto update = update_from<keeps_state, keeps_psi>(at, factor);
    Number v1{};
    if constexpr (keeps_state && drifts) {
      Number r1{};
      update(i, v1, r1);
      put(i, r1, at.r);
      witness.see(r1);
    } else {
      update(i, v1);
    }
    put(i, v1, at.v);
    witness.see(v1);
  }
  /// The positions, in the log's order.
  void look_at(Layout layout, Index p, Index m, Scalar* to) const {
    if (layout != Layout::components) return r_.gather(p, m, to);
    for (std::size_t d = 0; d < dim; ++d) std::copy_n(r_.at[d] + p, m, to + static_cast<Index>(d) * m);
  }

  Block v_, r_, psi_;
  Factor factor_;
  By by_;
  const Scalar* known_;
  std::uint64_t found_ = 0, left_ = 0;
};

}}  // namespace phistep::PHISTEP_ABI

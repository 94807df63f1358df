/// @file
/// What a step in place has overwritten, to put it back: r, v and the forces of the arrays, piece by piece.
#pragma once

#include <Eigen/Core>

#include <algorithm>
#include <cstddef>
#include <utility>

#include "phistep/base/state/blocks.hpp"
#include "phistep/base/state/strided_block.hpp"
#include "phistep/base/version.hpp"

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
  template <class T, int D>
  void take(const StridedBlock<T, D>& from, Numbers& to) const {
    each(
        from, to.data(), [](const T* place, T* kept, Index n) { std::copy_n(place, n, kept); },
        [&from](T* kept, Index p, Index m) { from.gather(p, m, kept); });
  }
  template <class T, int D>
  void give(const Numbers& from, const StridedBlock<T, D>& to) const {
    each(
        to, from.data(), [](T* place, const T* kept, Index n) { std::copy_n(kept, n, place); },
        [&to](const T* kept, Index p, Index m) { to.scatter(kept, p, m); });
  }
  template <class T, int D>
  void each(const StridedBlock<T, D>& places, auto* kept, auto&& span, auto&& vectors) const {
    for (Index p = 0; p < places.count; p += places_chunk<D>) {
      const Index m = std::min(places_chunk<D>, places.count - p);
      if (layout_ != Layout::components) vectors(kept + p * D, p, m);
      else
        for (Index d = 0; d < D; ++d) span(places.at[static_cast<std::size_t>(d)] + p, kept + p * D + d * m, m);
    }
  }

  Numbers r_, v_, psi_, psi_next_;
  Layout layout_ = Layout::strided;
  bool has_state_ = false, has_psi_ = false, has_next_ = false;
};

}}  // namespace phistep::PHISTEP_ABI

/// @file
/// The automatic atol: of a vector's component
///
///     atol_i = rtol max_t |y_i|,   and rtol/100 max_t ‖y‖∞ while |y_i| has always been less than ‖y‖∞/100:      (1)
///
/// components may differ in units and sizes, but one that is zero has errors of the size of the others' errors, and nothing
/// can be asked relative to those. In a matrix, whose columns are particles, all components are of one kind: rtol max_t ‖y‖∞.
/// Never less than the least normal number, where y isn't 0: what grows out of zero passes through subnormal numbers, in which
/// nothing is right to rtol.
#pragma once

#include <Eigen/Core>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <tuple>
#include <type_traits>
#include <utility>

#include "phistep/base/numbers/arithmetic.hpp"
#include "phistep/base/state/blocks.hpp"
#include "phistep/base/version.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

template <State Plain>
class AutomaticAtol {
 public:
  using Scalar = ScalarOf<Plain>;
  static constexpr std::size_t blocks = std::tuple_size_v<decltype(Blocks<Plain>::all(std::declval<Plain&>()))>;
  static constexpr int size_of_few = static_numbers<Plain>;
  static constexpr bool is_small = size_of_few > 0 && fits_registers<Plain>;
  /// What a step that may be rejected changes, by block.
  struct Sizes {
    std::array<Scalar, blocks> atol{}, largest{};  ///< of components of no size of their own; max_t ‖y‖∞
  };

  void begin(Scalar rtol) {
    rtol_ = rtol;
    sizes_ = {};
    own_.setZero();
  }
  [[nodiscard]] const Sizes& sizes() const { return sizes_; }
  void restore(const Sizes& sizes) { sizes_ = sizes; }

  /// A step of length dt [time] is to be tried.
  void begin_try(double dt) {
    dt_ = dt;
    longest_ = std::max(longest_, dt);
  }
  /// y is a state of the run.
  void remember(const Plain& y) {
    see(y);
    if constexpr (has_vectors) {
      if (const Index n = count_of(Blocks<Plain>::all(y)); own_.size() != n)
        own_.setZero(n);  // or y's size has changed
      Index at = 0;
      for_each_block(
          [&](auto k, const auto& block) {
            if constexpr (by_component<decltype(block)>)
              for (Index i = 0; i < block.size(); ++i) {
                const Scalar size = std::abs(block.data()[i]), own = own_[at + i];
                own_[at + i] = own > 0 || size >= faint * sizes_.largest[k] ? std::max(own, size) : Scalar{0};
              }
            at += block.size();
          },
          Blocks<Plain>::all(y));
    }
  }
  /// y⁺ may become one: until restore() its size counts, too.
  void see_end(const Plain& next, const Plain& error) {
    const auto before = sizes_.largest;
    see(next);
    if (dt_ > 0) leave_zero(before, error);
  }
  /// @tparam Block     the block it is in
  /// @param component  its number, over all blocks; block: that of its block
  /// @param size       |y_i|, the larger of both ends
  template <class Block>
  [[nodiscard]] Scalar at(std::size_t block, Index component, Scalar size) const {
    if constexpr (by_component<Block>) {
      const Scalar own = own_[component];
      return at_least(size, std::max(own > 0 ? Scalar{0} : sizes_.atol[block], rtol_ * std::max(own, size)));
    } else {
      return at_least(size, sizes_.atol[block]);
    }
  }

  void archive(auto& ar) {
    ar("largest", sizes_.largest, "longest", longest_);
    for (const Scalar x : sizes_.largest) ar.check(x >= 0 && std::isfinite(x));
    ar.check(longest_ >= 0 && std::isfinite(longest_));
    if constexpr (has_vectors) {
      ar("own", own_);
      for (const Scalar x : own_) ar.check(x >= 0 && std::isfinite(x));
    }
  }

 private:
  [[nodiscard]] static Scalar at_least(Scalar size, Scalar atol) {
    return size > 0 ? at_least_normal<Scalar>(atol) : atol;
  }
  template <class Block>
  static constexpr bool by_component = std::remove_cvref_t<Block>::IsVectorAtCompileTime && !FieldBlock<Block>;
  static constexpr bool has_vectors = []<class... B>(std::type_identity<std::tuple<B...>>) {
    return (by_component<B> || ...);
  }(std::type_identity<decltype(Blocks<Plain>::all(std::declval<Plain&>()))>{});
  /// Of the block's largest magnitude: a component that has never been more may be nothing but errors.
  static constexpr Scalar faint{Scalar(0.01L)};

  void see(const Plain& y) {
    for_each_block(
        [this](auto k, const auto& block) {
          if (block.size() == 0) return;
          sizes_.largest[k] = std::max(sizes_.largest[k], max_abs(block));
          sizes_.atol[k] = rtol_ * (by_component<decltype(block)> ? faint : Scalar{1}) * sizes_.largest[k];
        },
        Blocks<Plain>::all(y));
  }
  /// A block that leaves zero has no size yet. Where its error is a share of y⁺ at any Δt, as behind a jump of the force or
  /// under one that grows as a power of t, no step would do: what the slope y⁺/Δt makes of it in a tenth of the longest step
  /// tried is a size, too.
  void leave_zero(const auto& largest_before, const Plain& error) {
    for_each_block(
        [&](auto k, const auto& e) {
          if (largest_before[k] != 0 || e.size() == 0) return;
          const Scalar moved = std::max(sizes_.largest[k], max_abs(e));
          sizes_.atol[k] = rtol_ * moved * static_cast<Scalar>(std::max(1.0, 0.1 * longest_ / dt_));
        },
        Blocks<Plain>::all(error));
  }

  Scalar rtol_{0};
  Sizes sizes_;
  Eigen::Matrix<Scalar, is_small ? size_of_few : Eigen::Dynamic, 1> own_ =
      decltype(own_)::Zero(is_small ? size_of_few : 0);  // (1), by component: 0 where there is none
  double dt_ = 0, longest_ = 0;                          // [time] of the try, of all tries
};

}}  // namespace phistep::PHISTEP_ABI

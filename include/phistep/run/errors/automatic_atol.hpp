/// @file
/// The scales of errors where no atol is given. Each component has a size of its own, in its own units,
///
///     scale_i = rtol max(s_i, min(|y_i|, |y⁺_i|, 10 s_i)) + n_i,                                                (1)
///     s_i ← max(|y⁺_i|, 0.2^{Δt/H} s_i, 1e-9 max_t |y_i|)    after a step                                        (2)
///
/// where |y_i|, |y⁺_i| stands for the larger of both, H for the longest of the steps of late, and n_i for what
/// a rounding of y makes of y⁺, below which no error shows (0 until a probe has measured it). What a component was is forgotten by time, not by steps: else a
/// bisection towards a jump forgets it as fast as Δt falls, and never ends. The factor of 10 keeps a y⁺ that runs away from
/// loosening the test that it is to fail.
///
/// Numbers of one kind are one quantity: none is smaller than 1e-3 of the largest among them. A row of a matrix is one, a motion's
/// matrices as a whole, a field as a whole (there s is max |y|), and what `quantity` says. A component that has never been
/// anything but zero has no size: the first try says how large it gets of which the force at the end says that it has made it
/// (ErrorPace::runs_away).
#pragma once

#include <Eigen/Core>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <span>
#include <tuple>
#include <type_traits>
#include <utility>

#include "phistep/base/numbers/arithmetic.hpp"
#include "phistep/base/state/blocks.hpp"
#include "phistep/run/errors/tolerance.hpp"
#include "phistep/step/transaction/trace.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

template <State Plain>
class AutomaticAtol {
 public:
  using Scalar = ScalarOf<Plain>;
  static constexpr std::size_t blocks = std::tuple_size_v<decltype(Blocks<Plain>::all(std::declval<Plain&>()))>;
  static constexpr int size_of_few = static_numbers<Plain>;
  static constexpr bool is_small = size_of_few > 0 && fits_registers<Plain>;

  /// @param kinds  quantities besides those that the state's shape says; they must outlive the run
  void begin(Scalar rtol, std::span<const Quantity> kinds) {
    *this = {};
    rtol_ = rtol;
    kinds_ = kinds;
  }
  [[nodiscard]] bool fits(Index n) const { return are_within(kinds_, n); }
  /// A step of length dt [time] is to be tried.
  void begin_try(double dt) {
    dt_ = dt;
    longest_try_ = std::max(longest_try_, dt);
  }
  void accepted() { is_done_ = true; }
  /// y is a state of the run: (2), where a step has led there.
  [[gnu::noinline]] void remember(const Plain& y) {
    double passed = 0;  // in units of H
    if (std::exchange(is_done_, false)) {
      longest_ = std::max(longest_try_, 0.8 * longest_);
      longest_try_ = 0;
      passed = dt_ < longest_ ? dt_ / longest_ : 1;
    }
    const auto keeps = static_cast<Scalar>(std::pow(fade, passed));
    if constexpr (FieldState<Plain>) {
      for_each_block(
          [&](auto k, const auto& block) {
            fields_[k] = block.size() == 0 ? Scalar{0} : std::max(keeps * fields_[k], max_abs(block));
          },
          Blocks<Plain>::all(y));
    } else {
      if (const Index n = count_of(Blocks<Plain>::all(y)); own_.size() != n || largest_.size() != n)
        for (Numbers* numbers : {&own_, &largest_, &noise_, &power_, &begun_}) numbers->setZero(n);
      below_ = leapt_ = -1;
      if (passed > 0) noise_ *= static_cast<Scalar>(std::pow(fade_noise, passed));
      Index before = 0;  // numbers of the blocks before
      for_each_block(
          [&](auto, const auto& block) {
            for_each_pack<Scalar, pack_width<std::remove_cvref_t<decltype(block)>>>(
                block.size(), [&]<int width>(From<Scalar, width> from) {
                  Scalar* const own = own_.data() + before;
                  Scalar* const largest = largest_.data() + before;
                  const auto size = abs(from(block.data())), was = from(own) * keeps, most = from(largest);
                  const auto now = larger(larger(size, was), larger(most, size) * least_share);
                  const auto leaps = size > select(most > 0, most * leap, size);
                  const auto falls = now > larger(size, was), drowns = from(noise_.data() + before) > now * rtol_;
                  larger(most, size).store(largest + from.i);
                  now.store(own + from.i);
                  if (any(leaps) || any(falls) || any(drowns)) [[unlikely]]
                    for (int lane = 0; lane < width; ++lane) {
                      if (leaps[lane]) leapt_ = before + from.i + lane;
                      if (falls[lane] || drowns[lane]) below_ = before + from.i + lane;
                    }
                });
            before += block.size();
          },
          Blocks<Plain>::all(y));
      level_kinds(y);
      all_sized_ = (own_.array() > 0).all();
    }
  }

  /// The last step led to `before`, and the state is y now: what has been set begins anew.
  void edited(const Plain& before, const Plain& y) {
    for_each_number(
        [&](std::size_t at, Scalar was, Scalar is) {
          const auto i = static_cast<Index>(at);
          if (was == is || is == 0 || own_.size() == 0) return;
          own_[i] = largest_[i] = std::abs(is);
        },
        Blocks<Plain>::all(before), Blocks<Plain>::all(y));
  }

  /// s of a field: (1) of its numbers is rtol (s + |y|).
  [[nodiscard]] Scalar of_field(std::size_t block) const { return fields_[block]; }
  /// scale_i by (1). @param i  the component's number, over all blocks   @param size  |y_i|, |y⁺_i|
  [[nodiscard, gnu::always_inline]] inline Scalar scale(Index i, Scalar size) const {
    if (own_[i] > 0) return scale_of_sized(i, size);
    return size > 0 ? at_least_normal<Scalar>(rtol_ * size + noise_[i]) : noise_[i];
  }
  /// Of a solve's corrections: what they stall at is more than an error estimate shows of it.
  [[nodiscard, gnu::always_inline]] inline auto scales_of_solve(Index before, auto from, auto size) const {
    const auto scale = larger(from(own_.data() + before), size) * rtol_ + from(noise_.data() + before) * 64;
    return select(scale > 0, larger(scale, {least_normal<Scalar>}), scale);
  }
  /// The same where it has a size.
  [[nodiscard, gnu::always_inline]] inline Scalar scale_of_sized(Index i, Scalar size) const {
    return at_least_normal<Scalar>(rtol_ * std::max(own_[i], std::min(size, 10 * own_[i])) + noise_[i]);
  }
  /// The same for some numbers of a block. @param before  numbers of the blocks before
  [[nodiscard, gnu::always_inline]] inline auto scales_from(Index before, auto from, auto size) const {
    const auto own = from(own_.data() + before), noise = from(noise_.data() + before);
    using P = std::remove_const_t<decltype(own)>;
    return larger(larger(own, -larger(-size, own * -10)) * rtol_ + noise, P{least_normal<Scalar>});
  }
  /// What components usually are, over all blocks, or would have to be to matter: between s and the most that they have been. A
  /// small one's differences must not drown in what rounding does to the large ones beside it.
  void tell_usual(Plain& usual) const {
    for_each_number(
        [this](std::size_t at, Scalar& to) {
          const auto i = static_cast<Index>(at);
          const Scalar most = largest_[i] > 0 ? largest_[i] : own_[i];  // nothing yet, but for a try
          to = std::max(std::sqrt(own_[i]) * std::sqrt(most), noise_[i] / rtol_);
        },
        Blocks<Plain>::all(usual));
  }
  /// The last component of which less is asked than rtol of its size, and that has leapt in the step before; −1: none. Over all blocks.
  [[nodiscard]] Index below() const { return below_; }
  [[nodiscard]] Index leapt() const { return leapt_; }
  [[nodiscard]] bool all_sized() const { return all_sized_; }
  [[nodiscard]] bool is_sized(Index i) const { return own_[i] > 0; }
  /// Until the step is done, the size of a component that had none is |y⁺_i| of this try.
  void bear(Index i, Scalar next) { own_[i] = at_least_normal<Scalar>(std::max(next, std::abs(begun_[i]))); }
  /// Whether a component that had no size, and is `next` at the end of this try, has begun there as Δt^k: k = Δt y'/y⁺ is what powers
  /// are, or what it was in the try before, which was longer and led farther: that tells its size. Where k is about 0, something
  /// holds y⁺ or, if it has blown up, no longer does: then the rate at the start tells.
  /// @param change, at_start  Δt y' at both ends
  [[nodiscard]] bool begins(Index i, Scalar next, Scalar change, Scalar at_start, bool damps) {
    const Scalar k = change / next, k_before = std::exchange(power_[i], k), before = std::exchange(begun_[i], next);
    const Scalar rates = std::max(std::abs(change), std::abs(at_start));
    const bool is_held = rates == 0 || std::abs(next) <= 16 * rates;
    if (damps ? std::abs(k) <= most_power : -1 <= k && k <= 16 && is_held) return true;
    if (!is_held || 8 * std::abs(k - k_before) > std::abs(k) || 2 * std::abs(next) > std::abs(before)) return false;
    begun_[i] = before;
    before_ = true;
    return true;
  }
  [[nodiscard]] bool has_begun_before() { return std::exchange(before_, false); }
  [[nodiscard]] Scalar most(Index i) const { return largest_[i]; }
  /// Errors below this do not show.
  void learn_noise(Index i, Scalar least) { noise_[i] = std::max(noise_[i], least); }
  /// A try has failed to be solved: sizes that none but tries have shown are none.
  void unbear() {
    own_ = (largest_.array() > 0).select(own_, Scalar{0});
    all_sized_ = (own_.array() > 0).all();
  }
  /// Sizes of a run before.
  void go_on_from(const AutomaticAtol& before) {
    const auto rtol = rtol_;
    const auto kinds = kinds_;
    *this = before;
    rtol_ = rtol, kinds_ = kinds;
  }
  void archive(auto& ar) {
    ar("longest", longest_, "longest_try", longest_try_, "dt", dt_, "done", is_done_);
    for (const double x : {longest_, longest_try_, dt_}) ar.check(x >= 0 && std::isfinite(x));
    if constexpr (FieldState<Plain>) {
      ar("sizes", fields_);
      for (const Scalar x : fields_) ar.check(x >= 0 && std::isfinite(x));
    } else {
      ar("sizes", own_, "largest", largest_, "noise", noise_);
      for (const Numbers* numbers : {&own_, &largest_, &noise_}) {
        ar.check(numbers->size() == own_.size());
        for (const Scalar x : *numbers) ar.check(x >= 0 && std::isfinite(x));
      }
      all_sized_ = (own_.array() > 0).all();
      power_ = begun_ = Numbers::Zero(own_.size());
    }
  }

 private:
  using Numbers = Eigen::Matrix<Scalar, is_small ? size_of_few : Eigen::Dynamic, 1>;
  static constexpr double fade = 0.2, fade_noise = 0.9;  // what the longest step leaves of a size, of the noise
  static constexpr Scalar least_share{Scalar(1e-9L)};    // of its own largest size, …
  static constexpr Scalar leap{Scalar(1e3L)};            // of the largest that it has been, in one step
  static constexpr Scalar least_of_kind{Scalar(1e-3L)};  // of the largest of its kind: no component is less

  void level_kinds(const Plain& y) {
    Index before = 0;
    for_each_block(
        [&](auto k, const auto& block) {
          using Block = std::remove_cvref_t<decltype(block)>;
          if constexpr (!Block::IsVectorAtCompileTime) {
            if constexpr (Blocks<Plain>::drifts && k < 2) level({before, block.size()});
            else
              for (Index row = 0; row < block.rows(); ++row)
                level(Block::IsRowMajor ? Quantity{before + row * block.cols(), block.cols()}
                                        : Quantity{before + row, block.cols(), block.rows()});
          }
          before += block.size();
        },
        Blocks<Plain>::all(y));
    for (const Quantity& one : kinds_) level(one);
  }
  void level(const Quantity& kind) {
    Scalar largest{0};
    for (Index n = 0, i = kind.first; n < kind.count; ++n, i += kind.stride) largest = std::max(largest, own_[i]);
    for (Index n = 0, i = kind.first; n < kind.count; ++n, i += kind.stride) {
      if (own_[i] >= least_of_kind * largest) continue;
      if (own_[i] > 0) below_ = i;
      own_[i] = least_of_kind * largest;
    }
  }

  Scalar rtol_{0};
  std::span<const Quantity> kinds_;
  std::array<Scalar, FieldState<Plain> ? blocks : 0> fields_{};                              // s
  Numbers own_ = Numbers::Zero(is_small ? size_of_few : 0), largest_ = own_, noise_ = own_;  // s, max_t |y|, n
  Numbers power_ = own_, begun_ = own_;                                                      // k, y⁺ of the last try
  Index below_ = -1, leapt_ = -1;
  bool all_sized_ = false, is_done_ = false, before_ = false;
  double dt_ = 0, longest_try_ = 0, longest_ = 0;  // [time] of the try, the longest of this step, H
};

/// What a stepper keeps of a run's sizes: a run that goes on from the very state the last one ended with has them again.
template <State Plain>
class KeptSizes {
 public:
  KeptSizes() { set_zero(Blocks<Plain>::all(y_)); }
  void keep(const Plain& y, const AutomaticAtol<Plain>& sizes) {
    is_there_ = true;
    copy_blocks<Plain>(y_, y);
    sizes_ = sizes;
  }
  /// A run begins. There is room for what it will leave.
  [[gnu::noinline]] void go_on(const Plain& y, AutomaticAtol<Plain>& sizes) {
    if (is_there_ && same_shape<Plain>(y_, y) && equal_blocks<Plain>(y_, y)) sizes.go_on_from(sizes_);
    else keep(y, sizes);
  }
  void forget() { is_there_ = false; }
  void archive(auto& ar) {
    ar("is_there", is_there_);
    if (is_there_) ar("y", y_, "sizes", sizes_);
  }

 private:
  Plain y_;
  AutomaticAtol<Plain> sizes_;
  bool is_there_ = false;
};

}}  // namespace phistep::PHISTEP_ABI

/// @file
/// What a controlled run's errors are measured by: of each number the scale
///
///     atol_i + rtol |y_i|                                                                                       (1)
///
/// with atol as the run's tolerance has it: one for all, by block or by component; or as automatic_atol.hpp has it.
#pragma once

#include <Eigen/Core>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <tuple>
#include <type_traits>

#include "phistep/base/machine/loop_hints.hpp"
#include "phistep/base/machine/memory.hpp"
#include "phistep/base/numbers/pack.hpp"
#include "phistep/base/numbers/pack_math.hpp"
#include "phistep/base/state/blocks.hpp"
#include "phistep/run/errors/automatic_atol.hpp"
#include "phistep/run/errors/tolerance.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

template <State Plain>
class ErrorScales {
 public:
  using Scalar = ScalarOf<Plain>;
  using Automatic = AutomaticAtol<Plain>;
  static constexpr std::size_t blocks = Automatic::blocks;

  /// False where rtol or atol can't work for a state like y.
  [[nodiscard]] bool begin(const tolerance& wanted, const Plain& y) {
    using enum AbsoluteTolerance::Kind;
    kind_ = wanted.atol.kind();
    rtol_ = static_cast<Scalar>(wanted.rtol);
    if (!(wanted.rtol > 0 && wanted.rtol < 1)) return false;
    const auto given = wanted.atol.values();
    if (!std::all_of(given.begin(), given.end(), [](double x) { return x >= 0 && std::isfinite(x); })) return false;
    if (kind_ == per_block && given.size() != blocks) return false;
    if constexpr (FieldState<Plain>) {
      fields_ = {};
      if (kind_ == per_component && !take_fields(wanted.atol, y)) return false;
    } else if (kind_ == per_component && static_cast<Index>(given.size()) != count_of(Blocks<Plain>::all(y))) {
      return false;
    }
    const Index n = static_cast<Index>(given.size());
    components_.resize(kind_ == per_component ? n : 0);
    for (Index i = 0; i < components_.size(); ++i)
      components_[i] = static_cast<Scalar>(given[static_cast<std::size_t>(i)]);
    for (std::size_t k = 0; k < blocks; ++k)
      if (kind_ == everywhere || kind_ == per_block) atol_[k] = static_cast<Scalar>(given[kind_ == per_block ? k : 0]);
    const auto kinds = wanted.atol.quantities();
    if (!kinds.empty() && (FieldState<Plain> || !are_within(kinds, count_of(Blocks<Plain>::all(y))))) return false;
    if (!is_automatic()) return true;
    automatic_.begin(rtol_, kinds);
    remember(y);
    return true;
  }

  /// Whether y, whose size has changed, is still one that the atol given can be for.
  [[nodiscard]] bool fits(const Plain& y) const {
    if (is_automatic()) return automatic_.fits(count_of(Blocks<Plain>::all(y)));
    if (kind_ != AbsoluteTolerance::Kind::per_component) return true;
    if constexpr (FieldState<Plain>)
      return count_of(Blocks<Plain>::all(y)) == count_of(Blocks<Plain>::all(fields_.atol));
    else return components_.size() == count_of(Blocks<Plain>::all(y));
  }

  /// weight = 1/(atol + rtol |y|), and 0 where both are 0: the error of such a component is measured with y⁺. False where
  /// there are any, unless they wait for a size (AutomaticAtol::bear).
  bool weigh(const Plain& y, Plain& weight) {
    remember(y);
    bool all = true;
    if constexpr (FieldState<Plain>) {
      for_each_block(
          [&](auto k, const auto& from, auto& to) {
            with_atol(k, [&](auto atol) {
              std::remove_cvref_t<decltype(from)>::Ops::weigh(to.handle(), from.handle(), atol, rtol_);
            });
            all = all && (kind_ == AbsoluteTolerance::Kind::per_component ? fields_.is_positive : block_atol(k) > 0);
          },
          Blocks<Plain>::all(y), Blocks<Plain>::all(weight));
    } else {
      Index before = 0;  // numbers of the blocks before
      for_each_block(
          [&](auto k, const auto& from, auto& to) {
            for_each_pack<Scalar, pack_width<std::remove_cvref_t<decltype(from)>>>(
                from.size(), [&](auto at) PHISTEP_DETAIL_INLINED {
                  const auto size = abs(at(from.data()));
                  const auto allowed = is_automatic()           ? automatic_.scales_of_solve(before, at, size)
                                       : components_.size() > 0 ? at(components_.data() + before) + size * rtol_
                                                                : size * rtol_ + atol_[k];
                  const auto positive = allowed > 0;
                  all = all && phistep::all(positive);
                  select(positive, 1 / select(positive, allowed, 1), 0).store(to.data() + at.i);
                });
            before += from.size();
          },
          Blocks<Plain>::all(y), Blocks<Plain>::all(weight));
    }
    return all || (is_automatic() && !FieldState<Plain>);
  }

  /// An automatic atol follows what the components have been.
  void remember(const Plain& y) {
    if (is_automatic()) automatic_.remember(y);
  }
  [[nodiscard]] bool is_automatic() const { return kind_ == AbsoluteTolerance::Kind::automatic; }
  [[nodiscard]] Automatic& automatic() { return automatic_; }
  [[nodiscard]] const Automatic& automatic() const { return automatic_; }
  [[nodiscard]] Scalar rtol() const { return rtol_; }
  /// (1). @param i  the component's number, over all blocks   @param block  that it is in   @param size  |y_i|
  [[nodiscard]] Scalar scale(std::size_t block, Index i, Scalar size) const {
    if (components_.size() > 0) return components_[i] + rtol_ * size;
    if (is_automatic()) return automatic_.scale(i, size);
    return atol_[block] + rtol_ * size;
  }
  /// Whether there is an atol > 0 for each block and none for single components, or a size for each component: then
  /// `scale_by_block` is `scale`.
  [[nodiscard]] bool are_of_blocks() const {
    if (is_automatic()) return automatic_.all_sized();
    return components_.size() == 0 && std::all_of(atol_.begin(), atol_.end(), [](Scalar atol) { return atol > 0; });
  }
  /// (1), without a branch
  template <bool automatic>
  [[nodiscard, gnu::always_inline]] inline Scalar scale_by_block(std::size_t block, Index i, Scalar size) const {
    return automatic ? automatic_.scale_of_sized(i, size) : atol_[block] + rtol_ * size;
  }
  /// The same for some numbers of a block. @param before  numbers of the blocks before
  template <bool automatic>
  [[nodiscard, gnu::always_inline]] inline auto scales_from(std::size_t block, Index before, auto from,
                                                            auto size) const {
    if constexpr (automatic) return automatic_.scales_from(before, from, size);
    else return size * rtol_ + atol_[block];
  }
  /// f(atol of a field's numbers): one for all, or the handle of theirs.
  void with_atol(auto block, auto&& f) const {
    if (kind_ == AbsoluteTolerance::Kind::per_component)
      f(std::get<block()>(Blocks<Plain>::all(fields_.atol)).handle());
    else f(block_atol(block));
  }

  void archive(auto& ar) { automatic_.archive(ar); }

 private:
  /// The atol of a field's numbers, all alike.
  [[nodiscard]] Scalar block_atol(std::size_t block) const {
    return is_automatic() ? rtol_ * automatic_.of_field(block) : atol_[block];
  }
  /// All ranks come to the same answer.
  [[nodiscard]] bool take_fields(const AbsoluteTolerance& wanted, const Plain& y) {
    const Plain* const given = wanted.template fields<Plain>();
    if (given == nullptr) return false;
    int worst = 0;
    for_each_block(
        [&worst](auto, const auto& atol, const auto& like) {
          const bool is_there = atol.handle() != typename std::remove_cvref_t<decltype(atol)>::Handle{};
          worst = std::max(
              worst, is_there ? std::remove_cvref_t<decltype(atol)>::Ops::allowed(atol.handle(), like.handle()) : 2);
        },
        Blocks<Plain>::all(*given), Blocks<Plain>::all(y));
    if (worst == 2) return false;
    fields_.atol = *given;
    fields_.is_positive = worst == 0;
    return true;
  }

  AbsoluteTolerance::Kind kind_ = AbsoluteTolerance::Kind::automatic;
  Scalar rtol_{0};
  std::array<Scalar, blocks> atol_{};  // given
  Automatic automatic_;
  Eigen::Matrix<Scalar, Eigen::Dynamic, 1> components_;
  struct Fields {
    Plain atol;
    bool is_positive = true;
  };
  [[no_unique_address]] Only<FieldState<Plain>, Fields> fields_;
};

}}  // namespace phistep::PHISTEP_ABI

/// @file
/// The weighted norm in which a controlled run measures its errors:
///
///     ‖e‖ = √(1/n Σ (e_i/(atol_i + rtol |y_i|))²)                                                                (1)
///
/// over all n components of all blocks (Hairer, Nørsett & Wanner, Solving ODEs I, eq. II.4.11), or the largest such mean
/// over one particle's components.
#pragma once

#include <Eigen/Core>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <span>
#include <tuple>
#include <type_traits>
#include <utility>

#include "phistep/control/automatic_atol.hpp"
#include "phistep/control/measured.hpp"
#include "phistep/control/tolerance.hpp"
#include "phistep/control/trace.hpp"
#include "phistep/core/arithmetic.hpp"
#include "phistep/core/version.hpp"
#include "phistep/state/blocks.hpp"
#include "phistep/state/ranks.hpp"

namespace phistep::inline PHISTEP_ABI {

template <State Plain>
class ErrorNorm {
 public:
  using Scalar = ScalarOf<Plain>;

  /// False where rtol or atol can't work for a state like y.
  [[nodiscard]] bool begin(const tolerance& wanted, const Plain& y) {
    using enum AbsoluteTolerance::Kind;
    kind_ = wanted.atol.kind();
    norm_ = wanted.norm;
    rtol_ = static_cast<Scalar>(wanted.rtol);
    if (!(wanted.rtol > 0 && wanted.rtol < 1)) return false;
    const auto given = wanted.atol.values();
    if (!std::all_of(given.begin(), given.end(), [](double x) { return x >= 0 && std::isfinite(x); })) return false;
    if (kind_ == per_block && given.size() != blocks) return false;
    if constexpr (FieldState<Plain>) {
      if (norm_ != Norm::rms) return false;
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
    automatic_.begin(rtol_);
    return true;
  }

  /// Whether y, whose size has changed, is still one that the atol given can be for.
  [[nodiscard]] bool fits(const Plain& y) const {
    if (kind_ != AbsoluteTolerance::Kind::per_component) return true;
    if constexpr (FieldState<Plain>)
      return count_of(Blocks<Plain>::all(y)) == count_of(Blocks<Plain>::all(fields_.atol));
    else return components_.size() == count_of(Blocks<Plain>::all(y));
  }

  /// weight = 1/(atol + rtol |y|), and 0 where both are 0: the error of such a component is measured with y⁺. False where
  /// there are any.
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
    } else
      each(
          y,
          [&all](Scalar scale) {
            all = all && scale > 0;
            return scale > 0 ? 1 / scale : Scalar{0};
          },
          weight);
    return all;
  }

  /// An automatic atol follows the largest magnitudes so far.
  void remember(const Plain& y) {
    if (kind_ == AbsoluteTolerance::Kind::automatic) automatic_.remember(y);
  }
  /// A step of length dt [time] is to be tried.
  void begin_try(double dt) { automatic_.begin_try(dt); }
  /// ‖e‖ with |y| the larger of |y(t)| and |y(t+Δt)|. An automatic atol forgets y⁺ again: the step may be rejected.
  [[nodiscard, gnu::always_inline]] inline Measured operator()(const Plain& error, const Plain& y, const Plain& next) {
    if (kind_ != AbsoluteTolerance::Kind::automatic) return measure(error, y, next);
    const auto before = automatic_.sizes();
    automatic_.see_end(next, error);
    const Measured all = measure(error, y, next);
    automatic_.restore(before);
    return all;
  }
  /// The largest ratio of one particle's error to the RMS norm over all components, which implicit solves use: √(n/components).
  [[nodiscard]] double spread(const Plain& y) const {
    if (norm_ == Norm::rms) return 1;
    Index n = 0, fewest = std::numeric_limits<Index>::max();
    for_each_block(
        [&](auto, const auto& block) {
          n += block.size();
          const bool is_vector = std::remove_cvref_t<decltype(block)>::IsVectorAtCompileTime;
          if (block.size() > 0) fewest = std::min(fewest, is_vector ? Index{1} : block.rows());
        },
        Blocks<Plain>::all(y));
    return n == 0 ? 1 : std::sqrt(static_cast<double>(n) / static_cast<double>(fewest));
  }
  /// ‖x‖ with given weights.
  [[nodiscard]] double operator()(const Plain& x, const Plain& weight) const { return weighted_rms(x, weight); }

  void archive(auto& ar) { automatic_.archive(ar); }

 private:
  using Automatic = AutomaticAtol<Plain>;
  static constexpr std::size_t blocks = Automatic::blocks;
  static constexpr int size_of_few = Automatic::size_of_few;
  static constexpr bool is_small = Automatic::is_small;
  using Wide = std::common_type_t<Scalar, double>;  // squares of floats soon leave their range
  static constexpr Wide square(Scalar x) { return static_cast<Wide>(x) * static_cast<Wide>(x); }

  /// @param size  the component's magnitude now
  template <class Block>
  [[nodiscard]] Scalar atol(std::size_t block, Index component, Scalar size) const {
    if (components_.size() > 0) return components_[component];
    if (kind_ == AbsoluteTolerance::Kind::automatic) return automatic_.template at<Block>(block, component, size);
    return atol_[block];
  }
  /// Of a field's numbers, all alike.
  [[nodiscard]] Scalar block_atol(std::size_t block) const {
    return kind_ == AbsoluteTolerance::Kind::automatic ? automatic_.sizes().atol[block] : atol_[block];
  }
  /// f(atol of a field's numbers): one for all, or the handle of theirs.
  void with_atol(auto block, auto&& f) const {
    if (kind_ == AbsoluteTolerance::Kind::per_component)
      f(std::get<block()>(Blocks<Plain>::all(fields_.atol)).handle());
    else f(block_atol(block));
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
  void each(const Plain& y, auto&& f, Plain& out) {
    Index at = 0;
    for_each_block(
        [&](auto k, const auto& from, auto& to) {
          for (Index i = 0; i < from.size(); ++i) {
            const Scalar size = std::abs(from.data()[i]);
            to.data()[i] = f(atol<decltype(from)>(k, at + i, size) + rtol_ * size);
          }
          at += from.size();
        },
        Blocks<Plain>::all(y), Blocks<Plain>::all(out));
  }
  /// f(block number, block of e, row, storage index, (e/(atol + rtol |y|))²), column by column
  void for_each_square(const Plain& error, const Plain& y, const Plain& next, auto&& f) const {
    Index at = 0;
    for_each_block(
        [&](auto k, const auto& e, const auto& a, const auto& b) {
          for (Index column = 0; column < e.cols(); ++column)
            for (Index row = 0; row < e.rows(); ++row) {
              const Index i = e.IsRowMajor ? row * e.cols() + column : column * e.rows() + row;
              const Scalar size = std::max(std::abs(a.data()[i]), std::abs(b.data()[i]));
              const Scalar x = e.data()[i], allowed = atol<decltype(e)>(k, at + i, size) + rtol_ * size;
              // Less than the least normal number: no estimate of an error can be told from zero.
              if (size > 0 && allowed < least_normal<Scalar>) f(k, e, row, i, std::numeric_limits<Wide>::infinity());
              else f(k, e, row, i, x == 0 ? Wide{0} : square(x / allowed));
            }
          at += e.size();
        },
        Blocks<Plain>::all(error), Blocks<Plain>::all(y), Blocks<Plain>::all(next));
  }
  [[nodiscard, gnu::always_inline]] inline Measured measure(const Plain& error, const Plain& y,
                                                            const Plain& next) const {
    if constexpr (FieldState<Plain>) return over_fields(error, y, next);
    else return over_numbers(error, y, next);
  }
  [[nodiscard]] Measured over_fields(const Plain& error, const Plain& y, const Plain& next) const {
    double sum = 0;
    for_each_block(
        [&](auto k, const auto& e, const auto& a, const auto& b) {
          with_atol(k, [&](auto atol) {
            sum += std::remove_cvref_t<decltype(e)>::Ops::square(e.handle(), a.handle(), b.handle(), atol, rtol_);
          });
        },
        Blocks<Plain>::all(error), Blocks<Plain>::all(y), Blocks<Plain>::all(next));
    total_of_ranks(error, std::span<double>{&sum, 1});
    const Index n = count_of(Blocks<Plain>::all(error));
    return {n == 0 ? 0 : sum / static_cast<double>(n), {}};
  }
  [[nodiscard, gnu::always_inline]] inline Measured over_numbers(const Plain& error, const Plain& y,
                                                                 const Plain& next) const {
    if (norm_ != Norm::rms) return over_particles(error, y, next);
    if constexpr (is_small) {
      const bool automatic = kind_ == AbsoluteTolerance::Kind::automatic;
      bool has_scales = components_.size() == 0;
      for (const Scalar atol : automatic ? automatic_.sizes().atol : atol_) has_scales = has_scales && atol > 0;
      if (has_scales) return automatic ? over_few<true>(error, y, next) : over_few<false>(error, y, next);
    }
    return over_all(error, y, next);
  }
  [[nodiscard]] Measured over_all(const Plain& error, const Plain& y, const Plain& next) const {
    Wide sum{0}, most{-1};
    Index n = 0;
    Measured all;
    for_each_square(error, y, next, [&](auto k, const auto&, Index, Index i, Wide x) {
      sum += x;
      ++n;
      if (x > most) most = x, all.worst = {static_cast<std::int64_t>(k()), i};
    });
    all.square = n == 0 ? 0 : static_cast<double>(sum) / static_cast<double>(n);
    return all;
  }
  /// The same without a branch, for the few numbers of a small fixed state: no scale is 0 here. Numbers that are not
  /// negative are ordered as their bits are, of which the last six give way to the place of the number.
  template <bool automatic>
  [[nodiscard, gnu::always_inline]] inline Measured over_few(const Plain& error, const Plain& y,
                                                             const Plain& next) const {
    double sum = 0;
    std::uint64_t most = 0, place = 0;
    Index at = 0;
    Measured all;
    for_each_block(
        [&](auto k, const auto& e, const auto& a, const auto& b) {
          constexpr int n = std::remove_cvref_t<decltype(e)>::SizeAtCompileTime;
          const std::uint64_t before = most;
          const auto look = [&](int i) {
            const Scalar size = std::max(std::abs(a.data()[i]), std::abs(b.data()[i]));
            const Scalar atol = automatic ? automatic_.template at<decltype(e)>(k, at + i, size) : atol_[k];
            const Scalar allowed = atol + rtol_ * size;
            const auto x = static_cast<double>(square(e.data()[i] / allowed));
            sum += x;
            most = std::max(most, (std::bit_cast<std::uint64_t>(x) & ~std::uint64_t{63}) | static_cast<unsigned>(i));
          };
          if constexpr (n <= 8) {
            [&look]<int... i>(std::integer_sequence<int, i...>) { (look(i), ...); }
            (std::make_integer_sequence<int, n>{});
          } else {
            for (int i = 0; i < n; ++i) look(i);
          }
          if (k == 0 || most > before) place = k;
          at += n;
        },
        Blocks<Plain>::all(error), Blocks<Plain>::all(y), Blocks<Plain>::all(next));
    all.square = sum * (1.0 / size_of_few);
    all.worst = {static_cast<std::int64_t>(place), static_cast<std::int64_t>(most & 63)};
    return all;
  }
  [[nodiscard]] Measured over_particles(const Plain& error, const Plain& y, const Plain& next) const {
    Wide sum{0}, most{-1}, most_of_one{0};
    Index worst_of_one = 0;
    Measured all;
    for_each_square(error, y, next, [&](auto k, const auto& block, Index row, Index i, Wide x) {
      // In a vector each component stands for itself.
      const Index rows = std::remove_cvref_t<decltype(block)>::IsVectorAtCompileTime ? 1 : block.rows();
      const bool begins = rows == 1 || row == 0;
      sum = begins ? x : sum + x;
      if (begins || x > most_of_one) most_of_one = x, worst_of_one = i;
      if (rows > 1 && row != rows - 1) return;
      const Wide mean = sum / static_cast<Wide>(rows);
      if (mean > most || std::isnan(mean)) {
        all.worst = {static_cast<std::int64_t>(k()), worst_of_one};
        most = std::isnan(most) ? most : mean;  // once NaN, for good
      }
    });
    all.square = most < 0 ? 0 : static_cast<double>(most);
    return all;
  }

  AbsoluteTolerance::Kind kind_ = AbsoluteTolerance::Kind::automatic;
  Norm norm_ = Norm::rms;
  Scalar rtol_{0};
  std::array<Scalar, blocks> atol_{};  // given
  Automatic automatic_;
  Eigen::Matrix<Scalar, Eigen::Dynamic, 1> components_;
  struct Fields {
    Plain atol;
    bool is_positive = true;
  };
  struct Nothing {};
  [[no_unique_address]] std::conditional_t<FieldState<Plain>, Fields, Nothing> fields_;
};

}  // namespace phistep::inline PHISTEP_ABI

/// @file
/// The weighted norm in which a controlled run measures its errors:
///
///     ‖e‖ = √(1/n Σ (e_i/(atol_i + rtol |y_i|))²)                                                                (1)
///
/// over all n components of all blocks (Hairer, Nørsett & Wanner, Solving ODEs I, eq. II.4.11), or the largest such mean
/// over one particle's components.
#pragma once

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <span>
#include <type_traits>
#include <utility>

#include "phistep/base/machine/loop_hints.hpp"
#include "phistep/base/numbers/arithmetic.hpp"
#include "phistep/base/numbers/pack.hpp"
#include "phistep/base/numbers/pack_math.hpp"
#include "phistep/base/state/blocks.hpp"
#include "phistep/base/state/ranks.hpp"
#include "phistep/run/errors/automatic_atol.hpp"
#include "phistep/run/errors/error_scales.hpp"
#include "phistep/run/errors/tolerance.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// Σ x_i, and the first of the largest of them.
template <class Scalar>
struct SumAndMost {
  Scalar sum{0}, most{-1};
  std::ptrdiff_t place = 0;
};
/// @param f  (From) → the x there, ≥ 0
template <class Scalar>
[[nodiscard]] SumAndMost<Scalar> sum_and_most(std::ptrdiff_t n, const auto& f) {
  constexpr int width = native_width<Scalar>;
  using P = Pack<Scalar, width>;
  PackSum<Scalar> sum;
  SumAndMost<Scalar> found;
  P most{-1}, place{0}, here = P::make([](int lane) { return static_cast<Scalar>(lane); });
  const auto put = [&found](Scalar x, std::ptrdiff_t i) {
    if (x > found.most || (x == found.most && i < found.place)) found.most = x, found.place = i;
  };
  for_each_pack<Scalar>(n, [&]<int w>(From<Scalar, w> from) PHISTEP_DETAIL_INLINED {
    const auto x = f(from);
    sum.add(x);
    if constexpr (w == width) {
      place = select(x > most, here, place);
      most = larger(x, most);
      here += P{width};
    } else {
      put(x[0], from.i);
    }
  });
  found.sum = sum.total();
  for (int lane = 0; lane < width; ++lane) put(most[lane], static_cast<std::ptrdiff_t>(place[lane]));
  return found;
}

template <State Plain>
class ErrorNorm : public ErrorScales<Plain> {
 public:
  using Scalar = ScalarOf<Plain>;

  /// False where rtol or atol can't work for a state like y, or a field is to be measured particle by particle.
  [[nodiscard]] bool begin(const tolerance& wanted, const Plain& y) {
    norm_ = wanted.norm;
    if (FieldState<Plain> && norm_ != Norm::rms) return false;
    return ErrorScales<Plain>::begin(wanted, y);
  }

  /// ‖e‖ with |y| the larger of |y(t)| and |y(t+Δt)|
  [[nodiscard, gnu::always_inline]] inline Measured operator()(const Plain& error, const Plain& y,
                                                               const Plain& next) const {
    if constexpr (FieldState<Plain>) {
      return over_fields(error, y, next);
    } else {
      if (norm_ != Norm::rms) return over_particles(error, y, next);
      if constexpr (is_small)
        if (this->are_of_blocks())
          return this->is_automatic() ? over_few_sizes(error, y, next) : over_few<false>(error, y, next);
      if constexpr (std::is_same_v<Scalar, double>)
        if (this->are_of_blocks())
          return this->is_automatic() ? over_many<true>(error, y, next) : over_many<false>(error, y, next);
      return over_all(error, y, next);
    }
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

 private:
  static constexpr int size_of_few = AutomaticAtol<Plain>::size_of_few;
  static constexpr bool is_small = AutomaticAtol<Plain>::is_small;
  using Wide = std::common_type_t<Scalar, double>;  // squares of floats soon leave their range
  static constexpr Wide square(Scalar x) { return static_cast<Wide>(x) * static_cast<Wide>(x); }

  /// f(block number, block of e, row, storage index, (e/(atol + rtol |y|))²), column by column
  void for_each_square(const Plain& error, const Plain& y, const Plain& next, auto&& f) const {
    Index at = 0;
    for_each_block(
        [&](auto k, const auto& e, const auto& a, const auto& b) {
          for (Index column = 0; column < e.cols(); ++column)
            for (Index row = 0; row < e.rows(); ++row) {
              const Index i = e.IsRowMajor ? row * e.cols() + column : column * e.rows() + row;
              const Scalar size = std::max(std::abs(a.data()[i]), std::abs(b.data()[i]));
              const Scalar x = e.data()[i], allowed = this->scale(k, at + i, size);
              // Less than the least normal number: an estimate of an error may be zero by underflow.
              if (size > 0 && allowed < least_normal<Scalar>) f(k, e, row, i, std::numeric_limits<Wide>::infinity());
              else f(k, e, row, i, x == 0 ? Wide{0} : square(x / allowed));
            }
          at += e.size();
        },
        Blocks<Plain>::all(error), Blocks<Plain>::all(y), Blocks<Plain>::all(next));
  }
  [[nodiscard]] Measured over_fields(const Plain& error, const Plain& y, const Plain& next) const {
    double sum = 0;
    for_each_block(
        [&](auto k, const auto& e, const auto& a, const auto& b) {
          this->with_atol(k, [&](auto atol) {
            sum +=
                std::remove_cvref_t<decltype(e)>::Ops::square(e.handle(), a.handle(), b.handle(), atol, this->rtol());
          });
        },
        Blocks<Plain>::all(error), Blocks<Plain>::all(y), Blocks<Plain>::all(next));
    total_of_ranks(error, std::span<double>{&sum, 1});
    const Index n = count_of(Blocks<Plain>::all(error));
    return {n == 0 ? 0 : sum / static_cast<double>(n), {}};
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
  /// The same by packs: no scale is 0 here.
  template <bool automatic>
  [[nodiscard, gnu::noinline]] Measured over_many(const Plain& error, const Plain& y, const Plain& next) const {
    double sum = 0, most = -1;
    Index before = 0;
    Measured all;
    for_each_block(
        [&](auto k, const auto& e, const auto& a, const auto& b) {
          const auto found = sum_and_most<Scalar>(e.size(), [&](auto from) PHISTEP_DETAIL_INLINED {
            const auto size = larger(abs(from(a.data())), abs(from(b.data())));
            const auto x = from(e.data()) / this->template scales_from<automatic>(k, before, from, size);
            return x * x;
          });
          sum += found.sum;
          if (found.most > most) most = found.most, all.worst = {static_cast<std::int64_t>(k()), found.place};
          before += e.size();
        },
        Blocks<Plain>::all(error), Blocks<Plain>::all(y), Blocks<Plain>::all(next));
    all.square = before == 0 ? 0 : sum / static_cast<double>(before);
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
            const Scalar allowed = this->template scale_by_block<automatic>(k, at + i, size);
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
  [[nodiscard, gnu::noinline]] Measured over_few_sizes(const Plain& error, const Plain& y, const Plain& next) const {
    return over_few<true>(error, y, next);
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

  Norm norm_ = Norm::rms;
};

}}  // namespace phistep::PHISTEP_ABI

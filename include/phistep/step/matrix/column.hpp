/// @file
/// A piece of a matrix column in vector registers: what the small dense eliminations are made of.
///
/// Compilers make very different things of plain loops of such lengths (g++ -O2 leaves odd ones unvectorised, and stores
/// and reloads what could stay in registers), hence packs, one by one.
#pragma once

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <type_traits>

#include "phistep/base/machine/loop_hints.hpp"
#include "phistep/base/numbers/pack_math.hpp"
#include "phistep/base/version.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// Largest fixed size with an elimination of its own; beyond it, Eigen's blocked algorithm.
inline constexpr int small_dense_limit = 32;

/// Numbers in the largest register that is used. Not 512 bits: they gain little on columns this short, and half of their
/// loads would cross cache lines.
template <class Scalar>
inline constexpr int widest_pack = std::min(native_width<Scalar>, 32 / static_cast<int>(sizeof(Scalar)));

/// Rows `first` … `size` − 1 of a column of `size` ≤ 32 numbers: a pack and, recursively, the rest.
///
/// Every pointer is to row 0. The packs lie on one grid whatever `first` is: a pack loaded across the boundary of two
/// that were just stored would have to wait for both. The first one may so hold rows above `first`; the last ones
/// are smaller. `offset` is what row 0 of a rest is in the whole.
template <class Scalar, int size, int first = 0, int widest = widest_pack<Scalar>, int offset = 0>
class Column {
  static_assert(0 <= first && first < size && offset + size <= small_dense_limit);
  static constexpr int fitting = std::min(widest, static_cast<int>(std::bit_floor(static_cast<unsigned>(size))));
  static constexpr int width = fitting * static_cast<int>(sizeof(Scalar)) < 16 ? 1 : fitting;
  static constexpr bool used = first < width;
  using P = Pack<Scalar, width>;
  using Rest = Column<Scalar, size - width, (first > width ? first - width : 0), width, offset + width>;

 public:
  Column() = default;
  [[gnu::always_inline]] explicit Column(const Scalar* from) : rest_(from + width) {
    if constexpr (used) part_ = P::load(from);
  }
  [[gnu::always_inline]] void store(Scalar* to) const {
    if constexpr (used) part_.store(to);
    rest_.store(to + width);
  }
  /// Leaves the rows above `first` as they are.
  [[gnu::always_inline]] void store_below(Scalar* to) const {
    if constexpr (used && first > 0) select(from_row(first), part_, P::load(to)).store(to);
    else if constexpr (used) part_.store(to);
    rest_.store_below(to + width);
  }
  /// Zeros above `first`.
  [[gnu::always_inline]] void clear_above() {
    if constexpr (used && first > 0) part_ = select(from_row(first), part_, P{0});
    rest_.clear_above();
  }
  [[gnu::always_inline]] void scale(Scalar factor) {
    if constexpr (used) part_ *= P{factor};
    rest_.scale(factor);
  }
  /// this ← this + factor x
  [[gnu::always_inline]] void add(Scalar factor, const Column& x) {
    if constexpr (used) part_ = fma(x.part_, P{factor}, part_);
    rest_.add(factor, x.rest_);
  }

  /// The row ≥ `first` with the largest modulus, the first of equals.
  ///
  /// Comparing one by one is a chain that takes longer than the elimination which it serves. Instead the lowest 5 bits of
  /// each modulus give way to its row, so that one maximum, in vector operations, yields both. The pivot may so be
  /// smaller than the largest by 2⁵ ulp: the multipliers exceed 1 by no more. A NaN need not be found (it spreads), but must
  /// not lose to what lies above `first`: where one is compared, the later rows win.
  [[nodiscard]] [[gnu::always_inline]] int largest() const {
    if constexpr (size - first == 1) {
      return first;
    } else if constexpr (sizeof(Scalar) > 8) {
      Scalar x[size];
      store(x);
      return static_cast<int>(
          std::max_element(x + first, x + size, [](Scalar a, Scalar b) { return std::abs(a) < std::abs(b); }) - x);
    } else {
      return small_dense_limit - 1 - static_cast<int>(std::bit_cast<Bits>(largest_key<first>()) & row_bits);
    }
  }

 private:
  template <class, int, int, int, int>
  friend class Column;
  using Bits = std::conditional_t<sizeof(Scalar) == 4, std::uint32_t, std::uint64_t>;
  static constexpr Bits row_bits = small_dense_limit - 1;

  [[gnu::always_inline]] static P rows() {
    return P::make([](int i) { return static_cast<Scalar>(i); });
  }
  [[gnu::always_inline]] static auto from_row(int row) { return rows() >= P{row}; }

  template <int from>
  [[gnu::always_inline]] P key() const {
    constexpr Scalar modulus = std::bit_cast<Scalar>(~(Bits{1} << (8 * sizeof(Bits) - 1) | row_bits));
    const P row = P::make([](int i) { return std::bit_cast<Scalar>(row_bits - static_cast<Bits>(offset + i)); });
    const P all = bit_or(bit_and(part_, P{modulus}), row);
    if constexpr (from > 0) return select(from_row(from), all, P{0});
    else return all;
  }
  template <int from>
  [[gnu::always_inline]] Scalar largest_key() const {
    if constexpr (from >= width) {
      return rest_.template largest_key<from - width>();
    } else {
      P even = key<from>(), odd = even;
      const Scalar rest = rest_.join(odd, even);
      const Scalar here = fold(larger(even, odd), [](auto x, auto y) { return larger(x, y); });
      return here < rest ? rest : here;
    }
  }
  /// Takes the keys of packs of one width into two maxima in turn; returns the largest of the others.
  template <class Wide>
  [[gnu::always_inline]] Scalar join(Wide& one, Wide& other) const {
    if constexpr (std::is_same_v<Wide, P>) {
      one = larger(one, key<0>());
      return rest_.join(other, one);
    } else {
      return largest_key<0>();
    }
  }

  P part_;
  [[no_unique_address]] Rest rest_;
};

template <class Scalar, int widest, int offset>
class Column<Scalar, 0, 0, widest, offset> {
 public:
  Column() = default;
  explicit Column(const Scalar*) {}
  void store(Scalar*) const {}
  void store_below(Scalar*) const {}
  void clear_above() {}
  void scale(Scalar) {}
  void add(Scalar, const Column&) {}
  [[nodiscard]] static Scalar join(auto&, auto&) { return 0; }
};

/// f(0), f(1), …, f(count − 1), unrolled for few rows.
template <int count>
[[gnu::always_inline]] constexpr void each(auto&& f) {
  if constexpr (count <= 3) unrolled<count>(f);
  else
    for (int i = 0; i < count; ++i) f(i);
}

/// Whether every pivot whose reciprocal is given was a number other than zero, and not too small to be divided by.
template <int size, class Scalar>
[[nodiscard]] [[gnu::always_inline]] inline bool all_invertible(const Scalar (&reciprocals)[size]) {
  using std::abs;
  int bad = 0;  // no bool: nothing to branch on before the end
  each<size>([&](auto i) {
    bad |= static_cast<int>(!(abs(reciprocals[i]) > Scalar{0})) |
           static_cast<int>(!(abs(reciprocals[i]) <= std::numeric_limits<Scalar>::max()));
  });
  return bad == 0;
}

}}  // namespace phistep::PHISTEP_ABI

/// @file
/// Dense LU of few rows whose number is known.
///
/// Compilers make very different things of plain loops of such lengths (g++ -O2 leaves odd ones unvectorized, and stores
/// and reloads what could stay in registers), hence packs, one by one: 1.5 to 2.8 times as fast at 4 to 20 rows.
#pragma once

#include <Eigen/Core>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <type_traits>
#include <utility>

#include "phistep/base/machine/loop_hints.hpp"
#include "phistep/base/numbers/pack_math.hpp"
#include "phistep/step/matrix/dense_lu.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

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

/// Whether all pivots, whose reciprocals are given, are finite, not zero, and not too small to be divided by.
template <int size, class Scalar>
[[nodiscard]] [[gnu::always_inline]] inline bool all_invertible(const Scalar (&reciprocals)[size]) {
  using std::abs;
  int bad = 0;  // no bool: nothing to branch on before the end
  unrolled<size>([&](auto i) {
    bad |= static_cast<int>(!(abs(reciprocals[i]) > Scalar{0})) |
           static_cast<int>(!(abs(reciprocals[i]) <= std::numeric_limits<Scalar>::max()));
  });
  return bad == 0;
}

/// As dense_lu.hpp has it, with 4 to 32 rows.
template <class Scalar, int size>
  requires(size > 3 && size <= small_dense_limit)
class DenseLu<Scalar, size> {
 public:
  using Matrix = Eigen::Matrix<Scalar, size, size>;
  static void resize(Eigen::Index) {}

  [[nodiscard]] Matrix& matrix() { return lu_; }

  [[nodiscard]] bool factorize() {
    for (int i = 0; i < size; ++i) order_[i] = i;
    int pivot = Column<Scalar, size>(lu_.data()).largest();
    unrolled<size>([&](auto k) PHISTEP_DETAIL_INLINED { eliminate_column<k>(pivot); });
    return all_invertible(inverse_pivot_);
  }

  void solve_in_place(auto&& x) const {
    Scalar y[size];
    unrolled<size>([&](auto i) PHISTEP_DETAIL_INLINED { y[i] = x[order_[i]]; });
    // Row by row: the sum over older y runs ahead, so that only one product of each row waits for the newest.
    const Scalar* const a = lu_.data();
    unrolled<size>([&](auto row) PHISTEP_DETAIL_INLINED {
      Scalar sum = y[row];
      unrolled<row>([&](auto j) PHISTEP_DETAIL_INLINED { sum -= a[row + j * size] * y[j]; });
      y[row] = sum;
    });
    unrolled<size>([&](auto done) PHISTEP_DETAIL_INLINED {
      constexpr int last = size - 1, row = last - done;
      Scalar sum = y[row];
      unrolled<done>([&](auto k) PHISTEP_DETAIL_INLINED { sum -= a[row + (last - k) * size] * y[last - k]; });
      y[row] = sum * inverse_pivot_[row];
    });
    for (int i = 0; i < size; ++i) x[i] = y[i];
  }

 private:
  // A function for each k: inlined into one, g++ -O2 gives up on the registers.
  template <int k>
  void eliminate_column(int& pivot) {
    if (pivot != k) {
      lu_.row(k).swap(lu_.row(pivot));
      std::swap(order_[k], order_[pivot]);
    }
    Scalar* column = lu_.data() + k * size;
    const Scalar inverse = inverse_pivot_[k] = Scalar{1} / column[k];
    if constexpr (k + 1 < size) {
      using Below = Column<Scalar, size, k + 1>;
      Below factors(column);
      factors.scale(inverse);
      factors.store_below(column);
      factors.clear_above();
      column += size;
      // The next pivot's column first: its search then runs beside the rest of the elimination.
      Below next(column);
      next.add(-column[k], factors);
      next.store(column);
      pivot = next.largest();
      for (int j = k + 2; j < size; ++j) {
        column += size;
        Below other(column);
        other.add(-column[k], factors);
        other.store(column);
      }
    }
  }

  // A stepper is copied before it has factorized anything: it must not read what was never written.
  Matrix lu_ = Matrix::Zero();
  Scalar inverse_pivot_[size]{};
  int order_[size]{};
};

/// Up to 3 rows lie in registers. What a solve waits for counts there, not how many operations it has: with L⁻¹P made
/// explicit (its entries are at most 2, PA = LU having |L| ≤ 1) and the pivots divided out of U, it is a product and one
/// addition for each row. As accurate as LU, which the inverse of A is not.
template <class Scalar, int size>
  requires(size >= 1 && size <= 3)
class DenseLu<Scalar, size> {
 public:
  using Matrix = Eigen::Matrix<Scalar, size, size>;
  static void resize(Eigen::Index) {}

  [[nodiscard]] Matrix& matrix() { return a_; }

  [[nodiscard]] bool factorize() {
    using std::abs;
    Scalar a[size][size], inverse[size];
    int order[size], top = 0;
    unrolled<size>([&](auto i) {
      if (abs(at(i, 0)) > abs(at(top, 0))) top = i;
    });
    // The first exchange is made by the copy.
    unrolled<size>([&](auto i) {
      order[i] = i == 0 ? top : i == top ? 0 : int{i};
      unrolled<size>([&](auto j) { a[i][j] = at(order[i], j); });
    });
    unrolled<size>([&](auto k) {
      if constexpr (k == 1 && size == 3)
        if (abs(a[k + 1][1]) > abs(a[k][1])) {  // k for 1: clang warns of a 2 where size is 2
          unrolled<size>([&](auto j) { std::swap(a[k][j], a[k + 1][j]); });
          std::swap(order[k], order[k + 1]);
        }
      inverse[k] = Scalar{1} / a[k][k];
      unrolled<size>([&](auto i) {
        if constexpr (i > k) {
          a[i][k] *= inverse[k];
          unrolled<size>([&](auto j) {
            if constexpr (j > k) a[i][j] -= a[i][k] * a[k][j];
          });
        }
      });
    });
    unrolled<size>([&](auto i) { unrolled<size>([&](auto j) { at(i, j) = Scalar{0}; }); });
    at(0, order[0]) = inverse[0];
    if constexpr (size > 1) {
      at(1, order[1]) = inverse[1];
      at(1, order[0]) = -a[1][0] * inverse[1];
      upper_[0] = a[0][1] * inverse[0];
    }
    if constexpr (size > 2) {
      at(2, order[2]) = inverse[2];
      at(2, order[1]) = -a[2][1] * inverse[2];
      at(2, order[0]) = (a[2][1] * a[1][0] - a[2][0]) * inverse[2];
      upper_[1] = a[0][2] * inverse[0];
      upper_[2] = a[1][2] * inverse[1];
    }
    return all_invertible(inverse);
  }

  void solve_in_place(auto&& x) const {
    // `fma`, not left to the compiler, which would round once here and twice there, wherever x lies.
    Scalar y[size];
    unrolled<size>([&](auto i) {
      y[i] = at(i, 0) * x[0];
      if constexpr (size > 1) y[i] = fma(at(i, 1), x[1], y[i]);
      if constexpr (size > 2) y[i] = fma(at(i, 2), x[2], y[i]);
    });
    if constexpr (size > 2) {
      y[1] = fma(-upper_[2], y[2], y[1]);
      y[0] = fma(-upper_[1], y[2], y[0]);
    }
    if constexpr (size > 1) y[0] = fma(-upper_[0], y[1], y[0]);
    unrolled<size>([&](auto i) { x[int{i}] = y[i]; });
  }

 private:
  [[nodiscard]] Scalar& at(int i, int j) { return a_.data()[i + j * size]; }
  [[nodiscard]] Scalar at(int i, int j) const { return a_.data()[i + j * size]; }

  // A stepper is copied before it has factorized anything: it must not read what was never written.
  Matrix a_ = Matrix::Zero();  // D⁻¹L⁻¹P, D the diagonal of U
  Scalar upper_[3]{};          // D⁻¹U at (0,1), (0,2), (1,2)
};

}}  // namespace phistep::PHISTEP_ABI

/// @file
/// A piece of a matrix column in vector registers: what the small dense eliminations are made of.
///
/// Compilers make very different things of plain loops of such lengths (g++ -O2 leaves odd ones unvectorised, and stores
/// and reloads what could stay in registers), hence Eigen's packets, one by one.
#pragma once

#include <Eigen/Core>

#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <type_traits>
#include <utility>

#include "phistep/core/version.hpp"

namespace phistep::inline PHISTEP_ABI {

/// Largest fixed size with an elimination of its own; beyond it, Eigen's blocked algorithm.
inline constexpr int small_dense_limit = 32;

/// Numbers whose bits `Column` knows.
template <class Scalar>
inline constexpr bool has_columns = std::numeric_limits<Scalar>::is_iec559 &&
                                    (sizeof(Scalar) == 8 || sizeof(Scalar) == 4);

/// Numbers in the largest register that is used. Not 512 bits: they gain little on columns this short, half of their loads
/// would cross cache lines, and g++ 12 warns about its own AVX-512 header.
template <class Scalar>
inline constexpr int widest_packet = []() {
  constexpr int most = 32 / static_cast<int>(sizeof(Scalar)), has = Eigen::internal::packet_traits<Scalar>::size;
  return has < most ? has : most;
}();

/// Rows `first` … `size` − 1 of a column of `size` ≤ 32 numbers: a packet and, recursively, the rest.
///
/// Every pointer is to row 0. The packets lie on one grid whatever `first` is: a packet loaded across the boundary of two
/// that were just stored would have to wait for both. The first one may so hold rows above `first`; the last ones
/// are smaller. `offset` is what row 0 of a rest is in the whole.
template <class Scalar, int size, int first = 0, int widest = widest_packet<Scalar>, int offset = 0>
class Column {
  static_assert(has_columns<Scalar> && 0 <= first && first < size && offset + size <= small_dense_limit);
  static constexpr int fitting =
      widest <= size ? widest : static_cast<int>(std::bit_floor(static_cast<unsigned>(size)));
  using Best = typename Eigen::internal::find_best_packet<Scalar, fitting>::type;
  using Packet = std::conditional_t<(Eigen::internal::unpacket_traits<Best>::size <= fitting), Best, Scalar>;
  static constexpr int width = Eigen::internal::unpacket_traits<Packet>::size;
  static constexpr bool used = first < width;
  using Rest = Column<Scalar, size - width, (first > width ? first - width : 0), width, offset + width>;

 public:
  static constexpr int packets = (used ? 1 : 0) + Rest::packets;

  Column() = default;
  [[gnu::always_inline]] explicit Column(const Scalar* from) : rest_(from + width) {
    if constexpr (used) part_ = Eigen::internal::ploadu<Packet>(from);
  }
  [[gnu::always_inline]] void store(Scalar* to) const {
    if constexpr (used) Eigen::internal::pstoreu(to, part_);
    rest_.store(to + width);
  }
  /// Leaves the rows above `first` as they are.
  [[gnu::always_inline]] void store_below(Scalar* to) const {
    if constexpr (used && first > 0) {
      const Packet below = packet<From<first>>(), old = Eigen::internal::ploadu<Packet>(to);
      Eigen::internal::pstoreu(to, either(below, part_, old));
    } else if constexpr (used) {
      Eigen::internal::pstoreu(to, part_);
    }
    rest_.store_below(to + width);
  }
  /// Zeros above `first`.
  [[gnu::always_inline]] void clear_above() {
    if constexpr (used && first > 0) part_ = Eigen::internal::pand(part_, packet<From<first>>());
    rest_.clear_above();
  }
  template <int row>
  [[gnu::always_inline]] void set(Scalar value) {
    if constexpr (row < width) part_ = either(packet<Only<row>>(), Eigen::internal::pset1<Packet>(value), part_);
    else rest_.template set<row - width>(value);
  }
  [[gnu::always_inline]] void scale(Scalar factor) {
    if constexpr (used) part_ = Eigen::internal::pmul(part_, Eigen::internal::pset1<Packet>(factor));
    rest_.scale(factor);
  }
  /// this ← this + x
  [[gnu::always_inline]] void add(const Column& x) {
    if constexpr (used) part_ = Eigen::internal::padd(part_, x.part_);
    rest_.add(x.rest_);
  }
  /// this ← this + factor x
  [[gnu::always_inline]] void add(Scalar factor, const Column& x) {
    if constexpr (used) part_ = Eigen::internal::pmadd(x.part_, Eigen::internal::pset1<Packet>(factor), part_);
    rest_.add(factor, x.rest_);
  }

  /// The row ≥ `from` with the largest modulus, the first of equals.
  ///
  /// Comparing one by one is a chain that takes longer than the elimination which it serves. Instead the lowest 5 bits of
  /// each modulus give way to its row, so that one maximum, in vector operations, yields both. The pivot may so be
  /// smaller than the largest by 2⁵ ulp: the multipliers exceed 1 by no more. A NaN need not be found; it spreads.
  template <int from = first>
  [[nodiscard]] [[gnu::always_inline]] int largest() const {
    if constexpr (size - from == 1) return from;
    else return small_dense_limit - 1 - static_cast<int>(std::bit_cast<Bits>(largest_key<from>()) & row_bits);
  }

 private:
  template <class, int, int, int, int>
  friend class Column;
  using Bits = std::conditional_t<sizeof(Scalar) == 8, std::uint64_t, std::uint32_t>;
  static constexpr Bits row_bits = small_dense_limit - 1;

  // What the bits of row i of a packet are:
  template <int from>
  struct From {
    static constexpr Bits at(int i) { return i >= from ? ~Bits{0} : Bits{0}; }
  };
  template <int row>
  struct Only {
    static constexpr Bits at(int i) { return i == row ? ~Bits{0} : Bits{0}; }
  };
  struct Modulus {
    static constexpr Bits at(int) { return ~(Bits{1} << (8 * sizeof(Bits) - 1) | row_bits); }
  };
  struct Row {
    static constexpr Bits at(int i) { return row_bits - static_cast<Bits>(offset + i); }
  };
  template <class What>
  static constexpr auto numbers = [] {
    std::array<Scalar, width> all{};
    for (int i = 0; i < width; ++i) all[static_cast<unsigned>(i)] = std::bit_cast<Scalar>(What::at(i));
    return all;
  }();
  template <class What>
  [[gnu::always_inline]] static Packet packet() {
    return Eigen::internal::ploadu<Packet>(numbers<What>.data());
  }
  [[gnu::always_inline]] static Packet either(const Packet& mask, const Packet& yes, const Packet& no) {
    return Eigen::internal::por(Eigen::internal::pand(yes, mask), Eigen::internal::pandnot(no, mask));
  }

  template <int from>
  [[gnu::always_inline]] Packet key() const {
    using namespace Eigen::internal;
    const Packet all = por(pand(part_, packet<Modulus>()), packet<Row>());
    if constexpr (from > 0) return pand(all, packet<From<from>>());
    else return all;
  }
  template <int from>
  [[gnu::always_inline]] Scalar largest_key() const {
    if constexpr (from >= width) return rest_.template largest_key<from - width>();
    else {
      Packet even = key<from>(), odd = even;
      const Scalar rest = rest_.join(odd, even);
      const Scalar here = Eigen::internal::predux_max(Eigen::internal::pmax(even, odd));
      return here < rest ? rest : here;
    }
  }
  /// Takes the keys of packets of one width into two maxima in turn; returns the largest of the others.
  template <class Wide>
  [[gnu::always_inline]] Scalar join(Wide& one, Wide& other) const {
    if constexpr (std::is_same_v<Wide, Packet>) {
      one = Eigen::internal::pmax(one, key<0>());
      return rest_.join(other, one);
    } else {
      return largest_key<0>();
    }
  }

  Packet part_;
  [[no_unique_address]] Rest rest_;
};

template <class Scalar, int widest, int offset>
class Column<Scalar, 0, 0, widest, offset> {
 public:
  static constexpr int packets = 0;
  Column() = default;
  explicit Column(const Scalar*) {}
  void store(Scalar*) const {}
  void store_below(Scalar*) const {}
  void clear_above() {}
  void scale(Scalar) {}
  void add(const Column&) {}
  void add(Scalar, const Column&) {}
  [[nodiscard]] static Scalar join(auto&, auto&) { return 0; }
};

/// f(0), f(1), …, f(count − 1), each argument a compile-time constant.
template <int count>
[[gnu::always_inline]] constexpr void unrolled(auto&& f) {
  [&]<int... i>(std::integer_sequence<int, i...>) { (f(std::integral_constant<int, i>{}), ...); }
  (std::make_integer_sequence<int, count>{});
}
/// The same for the few rows that deserve it, else a loop.
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

}  // namespace phistep::inline PHISTEP_ABI

/// @file
/// A binary archive: values to bytes and back, bit for bit. One member serves both directions,
///
///     void archive(auto& ar) { ar(anchor, slip, kappa); }
///
/// and must not change anything while it writes. Archived without one: numbers, enums, std::array, vector, string, pair,
/// tuple and optional of what can be archived, Eigen's dense types, structs of blocks (see state/blocks.hpp), empty types,
/// and other trivially copyable types by their bytes: those must hold no pointers.
///
/// Beside `ar(…)` there are
///     ar.in_place(x…)   x keeps its shape, and any other shape in the bytes is an error
///     ar.shape(x…)      the shape alone, likewise
///     ar.check(ok)      what was read can be true
///     Ar::reading       with Ar the archive's type: the direction
///
/// Bytes are untrusted input: every size is checked against what is left before anything is allocated.
/// Writer and reader also hash which kinds of values pass them; finish() compares, so that bytes of another layout are
/// refused though their number may fit.
#pragma once

#include <Eigen/Core>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <functional>
#include <limits>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <tuple>
#include <type_traits>
#include <utility>
#include <vector>

#include "phistep/core/version.hpp"

namespace phistep::inline PHISTEP_ABI {

/// Bytes that are no checkpoint of this object, and why. Whatever throws it has changed nothing.
class CheckpointError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

class Writer;

namespace detail {
template <class T>
inline constexpr bool is_list = false;
template <class T, class A>
inline constexpr bool is_list<std::vector<T, A>> = true;
template <class C, class T, class A>
inline constexpr bool is_list<std::basic_string<C, T, A>> = true;
template <class T>
inline constexpr bool is_optional = false;
template <class T>
inline constexpr bool is_optional<std::optional<T>> = true;
template <class T>
inline constexpr bool is_pointer_like =
    std::is_pointer_v<T> || std::is_member_pointer_v<T> || std::is_null_pointer_v<T>;
template <class T>
inline constexpr bool is_pointer_like<std::reference_wrapper<T>> = true;
template <class T, std::size_t n>
inline constexpr bool is_pointer_like<std::span<T, n>> = true;

template <class T>
concept Archived = requires(T& x, Writer& ar) {
  x.archive(ar);
};
template <class T>
concept Dense = std::is_base_of_v<Eigen::DenseBase<T>, T>;
template <class T>
concept Blocked = requires(T& x) {
  T::blocks(x);
};
template <class T>
concept TupleLike = requires {
  std::tuple_size<T>::value;
};
/// By their bytes, many at once.
template <class T>
inline constexpr bool is_flat =
    std::is_trivially_copyable_v<T> && !std::is_empty_v<T> && !is_pointer_like<T> && !std::is_same_v<T, bool> &&
    !std::is_same_v<T, long double> && !Archived<T> && !Dense<T> && !Blocked<T> && !TupleLike<T> && !is_optional<T>;
}  // namespace detail

/// What both directions share: how a type falls into numbers. `Self` moves bytes: move(pointer, count).
template <class Self>
class Archive {
 public:
  template <class... T>
  void operator()(T&&... parts) {
    (part<false>(parts), ...);
  }
  template <class... T>
  void in_place(T&&... parts) {
    (part<true>(parts), ...);
  }
  template <class... T>
  void shape(const T&... parts) {
    (shape_of(parts), ...);
  }

 protected:
  [[nodiscard]] std::uint64_t layout() const { return layout_; }

 private:
  enum class Kind : std::uint64_t { number = 1, boolean, wide, bytes, list, optional, dense };

  [[nodiscard]] Self& self() { return static_cast<Self&>(*this); }
  void passes(Kind kind, std::size_t detail) {
    layout_ = (layout_ ^ (static_cast<std::uint64_t>(kind) << 32 | detail)) * 0x9e3779b97f4a7c15u;
    layout_ ^= layout_ >> 29;
  }

  template <bool fixed, class T>
  void part(T& x) {
    using V = std::remove_const_t<T>;
    if constexpr (detail::Archived<V>) {
      const_cast<V&>(x).archive(self());
    } else if constexpr (detail::Dense<V>) {
      dense<fixed>(x);
    } else if constexpr (detail::Blocked<V>) {
      std::apply([this](auto&... block) { (this->template part<fixed>(block), ...); }, V::blocks(x));
    } else if constexpr (detail::is_list<V>) {
      list(x);
    } else if constexpr (detail::is_optional<V>) {
      bool has = x.has_value();
      passes(Kind::optional, 0);
      boolean(has);
      if constexpr (Self::reading) {
        x.reset();
        if (has) x.emplace();
      }
      if (has) part<fixed>(*x);
    } else if constexpr (detail::TupleLike<V> && requires { x.begin(); }) {
      for (auto& element : x) part<fixed>(element);
    } else if constexpr (detail::TupleLike<V>) {
      std::apply([this](auto&... element) { (this->template part<fixed>(element), ...); }, x);
    } else if constexpr (std::is_same_v<V, bool>) {
      boolean(x);
    } else if constexpr (!std::is_empty_v<V>) {
      static_assert(std::is_trivially_copyable_v<V> && !detail::is_pointer_like<V>,
                    "phistep: this type can't be archived: give it void archive(auto& ar) { ar(its, members); }");
      if constexpr (std::is_trivially_copyable_v<V> && !detail::is_pointer_like<V>) values(&x, 1);
    }
  }

  /// n of one type that is its bytes; their number is known to the reader.
  template <class T>
  void values(T* x, std::size_t n) {
    using V = std::remove_const_t<T>;
    if constexpr (std::is_floating_point_v<V>) {
      passes(Kind::number, sizeof(V) << 16 | static_cast<std::size_t>(std::numeric_limits<V>::digits));
      if constexpr (std::numeric_limits<V>::digits == 64) return wide(x, n);
    } else {
      passes(std::is_class_v<V> ? Kind::bytes : Kind::number, sizeof(V) << 1 | (std::is_signed_v<V> ? 1u : 0u));
    }
    self().move(x, n);
  }
  /// An x87 long double: ten bytes of number, and padding that is never set.
  template <class T>
  void wide(T* x, std::size_t n) {
    for (std::size_t i = 0; i < n; ++i) {
      std::array<std::byte, 16> bytes{};
      if constexpr (!Self::reading) std::memcpy(bytes.data(), x + i, 10);
      self().move(bytes.data(), bytes.size());
      if constexpr (Self::reading) std::memcpy(static_cast<void*>(x + i), bytes.data(), 10);
    }
  }
  template <class T>
  void boolean(T& x) {
    passes(Kind::boolean, 0);
    std::uint8_t byte = x ? 1 : 0;
    self().move(&byte, 1);
    self().check(byte <= 1);
    if constexpr (Self::reading) x = byte == 1;
  }

  template <class T>
  void list(T& x) {
    using V = typename T::value_type;
    static_assert(!std::is_empty_v<V>, "phistep: a list of empty objects can't be archived");
    passes(Kind::list, 0);
    auto n = static_cast<std::uint64_t>(x.size());
    values(&n, 1);
    self().template expect<V>(n);
    if constexpr (detail::is_flat<V>) {
      if constexpr (Self::reading) x.resize(static_cast<std::size_t>(n));
      values(x.data(), static_cast<std::size_t>(n));
    } else if constexpr (Self::reading) {
      x.clear();  // grows with what is really there
      for (std::uint64_t i = 0; i < n; ++i) {
        V element{};
        part<false>(element);
        x.push_back(std::move(element));
      }
    } else {
      for (auto&& element : std::as_const(x)) part<false>(element);
    }
  }

  template <class T>
  void shape_of(const T& x) {
    if constexpr (detail::Dense<T>) {
      std::int64_t rows = x.rows(), cols = x.cols();
      dimensions(rows, cols);
      self().check_shape(rows, cols, x.rows(), x.cols());
    } else {
      std::apply([this](const auto&... block) { (this->shape_of(block), ...); }, T::blocks(x));
    }
  }
  void dimensions(std::int64_t& rows, std::int64_t& cols) {
    passes(Kind::dense, 0);
    values(&rows, 1);
    values(&cols, 1);
  }

  template <bool fixed, class T>
  void dense(T& x) {
    using V = std::remove_const_t<T>;
    using Scalar = typename V::Scalar;
    static_assert(std::is_trivially_copyable_v<Scalar>, "phistep: a matrix of such numbers can't be archived");
    constexpr bool plain = std::is_base_of_v<Eigen::PlainObjectBase<V>, V>;
    std::int64_t rows = x.rows(), cols = x.cols();
    dimensions(rows, cols);
    if constexpr (Self::reading) {
      if constexpr (fixed || !plain || V::SizeAtCompileTime != Eigen::Dynamic) {
        self().check_shape(rows, cols, x.rows(), x.cols());
      } else {
        constexpr std::int64_t own_rows = V::RowsAtCompileTime, own_cols = V::ColsAtCompileTime;
        self().check_shape(rows, cols, own_rows == Eigen::Dynamic ? rows : own_rows,
                           own_cols == Eigen::Dynamic ? cols : own_cols);
        self().check(rows >= 0 && cols >= 0);
        self().check(V::MaxRowsAtCompileTime == Eigen::Dynamic || rows <= V::MaxRowsAtCompileTime);
        self().check(V::MaxColsAtCompileTime == Eigen::Dynamic || cols <= V::MaxColsAtCompileTime);
        if (rows > 0) self().check(cols <= std::numeric_limits<std::int64_t>::max() / rows);
        self().template expect<Scalar>(static_cast<std::uint64_t>(rows * cols));
        x.resize(rows, cols);
      }
    }
    if constexpr (plain) {
      values(x.data(), static_cast<std::size_t>(x.size()));
    } else {
      // A view may have gaps: its numbers pass through a column, in storage order.
      typename V::PlainObject copy(rows, cols);
      if constexpr (!Self::reading) copy = x;
      values(copy.data(), static_cast<std::size_t>(copy.size()));
      if constexpr (Self::reading) x = copy;
    }
  }

  std::uint64_t layout_ = 0;
};

/// Values to bytes: `Writer out; out(x, y);`
class Writer : public Archive<Writer> {
 public:
  static constexpr bool reading = false;

  /// Ends the archive with the hash of its layout.
  void finish() {
    const std::uint64_t end = layout();
    move(&end, 1);
  }
  [[nodiscard]] std::span<const std::byte> bytes() const { return bytes_; }

  static void check(bool) {}

 private:
  friend class Archive<Writer>;
  template <class T>
  void move(const T* x, std::size_t n) {
    const auto* const first = reinterpret_cast<const std::byte*>(x);
    bytes_.insert(bytes_.end(), first, first + n * sizeof(T));
  }
  template <class T>
  static void expect(std::uint64_t) {}
  static void check_shape(std::int64_t, std::int64_t, std::int64_t, std::int64_t) {}

  std::vector<std::byte> bytes_;
};

/// Bytes to values: `Reader in{bytes}; in(x, y);`. Throws CheckpointError where they don't fit; what was read before
/// then is changed, so read into copies.
class Reader : public Archive<Reader> {
 public:
  static constexpr bool reading = true;

  explicit Reader(std::span<const std::byte> bytes) : rest_{bytes} {}

  /// All has been read, and was of the layout that was written.
  void finish() {
    const std::uint64_t mine = layout();
    std::uint64_t theirs = 0;
    move(&theirs, 1);
    if (!rest_.empty() || mine != theirs)
      throw CheckpointError("phistep: the checkpoint is laid out otherwise: another object wrote it");
  }
  void check(bool ok) const {
    if (!ok) throw CheckpointError("phistep: the checkpoint holds values that can't be: another object wrote it");
  }

 private:
  friend class Archive<Reader>;
  template <class T>
  void move(T* x, std::size_t n) {
    expect<T>(n);
    if (n > 0) std::memcpy(static_cast<void*>(x), rest_.data(), n * sizeof(T));
    rest_ = rest_.subspan(n * sizeof(T));
  }
  /// n values of type T are still there: at least a byte each.
  template <class T>
  void expect(std::uint64_t n) const {
    constexpr std::size_t least = detail::is_flat<T> ? sizeof(T) : 1;
    if (n > rest_.size() / least)
      throw CheckpointError("phistep: the checkpoint ends too early: another object wrote it");
  }
  static void check_shape(std::int64_t rows, std::int64_t cols, std::int64_t own_rows, std::int64_t own_cols) {
    if (rows == own_rows && cols == own_cols) return;
    throw CheckpointError("phistep: the checkpoint is of another size: it holds " + std::to_string(rows) + " x " +
                          std::to_string(cols) + " numbers where there is room for " + std::to_string(own_rows) +
                          " x " + std::to_string(own_cols));
  }

  std::span<const std::byte> rest_;
};

}  // namespace phistep::inline PHISTEP_ABI

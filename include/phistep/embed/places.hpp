/// @file
/// Where a code keeps the vectors of its particles: `places(…)` describes arrays of structs, structs of arrays, plain
/// arrays. Nothing is copied, and a container is asked anew for its memory and its length at each step.
///
///     places(beads, &Bead::x)          a container of structs with a member double x[3], std::array, Vec3 { double x, y, z; }
///     places(points)                   a container of such vectors, or of numbers
///     places(xs, ys, zs)               a container for each component
///     places(x, n)                     double (*x)[3], Vec3* x, or double* x: n vectors, or n numbers
///     places<3>(first, n, stride)      n times three adjacent numbers, `stride` numbers apart
#pragma once

#include <Eigen/Core>

#include <array>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <iterator>
#include <memory>
#include <stdexcept>
#include <type_traits>
#include <vector>

#include "phistep/core/version.hpp"
#include "phistep/state/blocks.hpp"

namespace phistep::inline PHISTEP_ABI {

/// The numbers of an object that is nothing but numbers of one type: their type and how many.
template <class T>
struct NumbersOf {
  using Scalar = double;
  static_assert(
      !sizeof(T),
      "phistep: places(...) takes what is made of numbers of one type: double, double[3], std::array<double, 3>, a "
      "fixed Eigen vector, or struct Vec3 { double x, y, z; }");
  static constexpr int count = 1;
};
template <std::floating_point T>
struct NumbersOf<T> {
  using Scalar = T;
  static constexpr int count = 1;
};
template <std::floating_point T, std::size_t n>
struct NumbersOf<T[n]> {
  using Scalar = T;
  static constexpr int count = static_cast<int>(n);
};
template <std::floating_point T, std::size_t n>
struct NumbersOf<std::array<T, n>> {
  using Scalar = T;
  static constexpr int count = static_cast<int>(n);
};
template <EigenDense T>
struct NumbersOf<T> {
  using Scalar = typename T::Scalar;
  static_assert(sizeof(T) == sizeof(Scalar) * std::size_t{T::SizeAtCompileTime},
                "phistep: places(...) takes Eigen vectors of a fixed size, without padding");
  static constexpr int count = T::SizeAtCompileTime;
};
/// struct Vec3 { double x, y, z; }, or without z, or with w
template <class T>
  requires(!EigenDense<T> && std::is_trivially_copyable_v<T> && std::floating_point<decltype(T::x)>)
struct NumbersOf<T> {
  using Scalar = decltype(T::x);
  static constexpr int count =
      1 + (requires { T::y; } ? 1 : 0) + (requires { T::z; } ? 1 : 0) + (requires { T::w; } ? 1 : 0);
  static_assert(
      sizeof(T) == count * sizeof(Scalar),
      "phistep: places(...) takes structs of x, y, z (and w) alone; three adjacent members of a larger one are "
      "places<3>(&first[0].x, n, stride)");
};

/// [vectors] Arrays in place are worked on in pieces of this length, which stay in the first cache; a multiple of what
/// fingerprints take.
template <int D>
inline constexpr Index places_chunk = D == 1   ? 512
                                      : D == 2 ? 256
                                               : 128;

/// n vectors of D numbers in memory of somebody else: component d of vector p at `at[d] + p·stride`. As a matrix it has one
/// column a vector; for D = 1 it is a vector.
template <std::floating_point T, int D>
class Places {
 public:
  using Scalar = T;
  using Plain = std::conditional_t<D == 1, Eigen::Matrix<T, Eigen::Dynamic, 1>, Eigen::Matrix<T, D, Eigen::Dynamic>>;
  static constexpr int dim = D, SizeAtCompileTime = Eigen::Dynamic;
  static constexpr bool IsRowMajor = false;

  std::array<T*, D> at{};
  Index stride = D;  ///< in numbers
  Index count = 0;   ///< of vectors

  [[nodiscard]] Index rows() const { return D == 1 ? count : D; }
  [[nodiscard]] Index cols() const { return D == 1 ? 1 : count; }
  [[nodiscard]] Index size() const { return D * count; }
  [[nodiscard]] T& operator()(Index i, Index j) const {
    if constexpr (D == 1) return at[0][i * stride];
    else return at[static_cast<std::size_t>(i)][j * stride];
  }
  /// A vector's numbers are neighbours.
  [[nodiscard]] bool is_adjacent() const {
    for (std::size_t d = 1; d < D; ++d)
      if (at[d] != at[0] + d) return false;
    return true;
  }
  /// All numbers lie in one piece.
  [[nodiscard]] bool is_contiguous() const { return stride == D && is_adjacent(); }

  /// to[D i + d] = component d of vector first + i, for m vectors
  void gather(Index first, Index m, T* to) const {
    if (is_contiguous()) {
      std::memcpy(to, at[0] + first * D, static_cast<std::size_t>(m * D) * sizeof(T));
    } else if (is_adjacent()) {
      const T* from = at[0] + first * stride;
      for (Index i = 0; i < m; ++i, from += stride, to += D)
        for (Index d = 0; d < D; ++d) to[d] = from[d];
    } else {
      for (Index d = 0; d < D; ++d) {
        const T* from = at[static_cast<std::size_t>(d)] + first * stride;
        for (Index i = 0; i < m; ++i) to[i * D + d] = from[i * stride];
      }
    }
  }
  /// The way back.
  void scatter(const T* from, Index first, Index m) const {
    if (is_contiguous()) {
      std::memcpy(at[0] + first * D, from, static_cast<std::size_t>(m * D) * sizeof(T));
    } else if (is_adjacent()) {
      T* to = at[0] + first * stride;
      for (Index i = 0; i < m; ++i, to += stride, from += D)
        for (Index d = 0; d < D; ++d) to[d] = from[d];
    } else {
      for (Index d = 0; d < D; ++d) {
        T* to = at[static_cast<std::size_t>(d)] + first * stride;
        for (Index i = 0; i < m; ++i) to[i * stride] = from[i * D + d];
      }
    }
  }
  /// f(first byte, bytes, stride [bytes]) for each row of pieces of equal length, of `count` pieces
  void for_each_row(auto&& f) const {
    const bool adjacent = is_adjacent();
    for (std::size_t d = 0; d < (adjacent ? 1 : D); ++d)
      f(reinterpret_cast<std::uintptr_t>(at[d]), (adjacent ? D : 1) * sizeof(T),
        static_cast<std::uintptr_t>(stride) * sizeof(T));
  }
};

template <class T, int D, class Block>
void assign_block(Block& to, const Places<T, D>& from) {
  if (to.rows() != from.rows() || to.cols() != from.cols()) to.resize(from.rows(), from.cols());
  from.gather(0, from.count, to.data());
}
template <class T, int D, class Block>
void assign_block(Places<T, D>& to, const Block& from) {
  to.scatter(from.data(), 0, to.count);
}

/// Whether each number of these has a place of its own. Rows of pieces that lie between one another, as members of structs
/// do, have one stride.
template <class First, class... More>
[[nodiscard]] bool have_own_places(const First& first, const More&... more) {
  struct Row {
    std::uintptr_t from, bytes, stride, to;
  };
  std::vector<Row> rows;
  const auto n = static_cast<std::uintptr_t>(first.count);
  if (n == 0) return true;
  const auto add = [&rows, n](std::uintptr_t from, std::uintptr_t bytes, std::uintptr_t stride) {
    rows.push_back({from, bytes, stride, from + (n - 1) * stride + bytes});
  };
  first.for_each_row(add);
  (more.for_each_row(add), ...);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const Row& a = rows[i];
    if (n > 1 && a.bytes > a.stride) return false;
    for (std::size_t j = 0; j < i; ++j) {
      const Row& b = rows[j];
      if (a.to <= b.from || b.to <= a.from) continue;
      if (a.stride != b.stride) return false;
      const Row &low = a.from < b.from ? a : b, &high = a.from < b.from ? b : a;
      const std::uintptr_t gap = (high.from - low.from) % a.stride;  // from a piece of `low` to the next of `high`
      if (n == 1 || gap < low.bytes || gap + high.bytes > a.stride) return false;
    }
  }
  return true;
}

/// Something that says where vectors lie, now.
template <class T>
concept PlacesSource = requires(const T& source) {
  { source.now().count } -> std::convertible_to<Index>;
  typename decltype(source.now())::Plain;
};

namespace detail {
/// The address of a number in an object that is nothing but numbers.
template <class Scalar, class T>
[[nodiscard]] Scalar* first_number(T* object) {
  return reinterpret_cast<Scalar*>(object);
}
}  // namespace detail

/// n objects from `first` on.
template <class T>
struct PointerPlaces {
  using Numbers = NumbersOf<T>;
  T* first;
  Index n;
  [[nodiscard]] auto now() const {
    return evenly<typename Numbers::Scalar, Numbers::count>(detail::first_number<typename Numbers::Scalar>(first),
                                                            Numbers::count, n);
  }
  template <class Scalar, int D>
  [[nodiscard]] static Places<Scalar, D> evenly(Scalar* at, Index stride, Index n) {
    Places<Scalar, D> all;
    for (std::size_t d = 0; d < D; ++d) all.at[d] = at + d;
    all.stride = stride, all.count = n;
    return all;
  }
};
/// Three adjacent numbers, and so on after a stride.
template <class Scalar, int D>
struct StridedPlaces {
  Scalar* first;
  Index n, stride;
  [[nodiscard]] auto now() const { return PointerPlaces<Scalar>::template evenly<Scalar, D>(first, stride, n); }
};
/// The elements of a container.
template <class Container>
struct ElementPlaces {
  using Element = std::remove_pointer_t<decltype(std::data(std::declval<Container&>()))>;
  Container* all;
  [[nodiscard]] auto now() const {
    return PointerPlaces<Element>{std::data(*all), static_cast<Index>(std::size(*all))}.now();
  }
};
/// A member of the elements of a container.
template <class Container, class Struct, class Member>
struct MemberPlaces {
  using Numbers = NumbersOf<Member>;
  using Scalar = typename Numbers::Scalar;
  static_assert(sizeof(Struct) % sizeof(Scalar) == 0, "phistep: the struct's size is no multiple of its numbers' size");
  Container* all;
  Member Struct::*member;
  [[nodiscard]] auto now() const {
    const auto n = static_cast<Index>(std::size(*all));
    Scalar* const first = n == 0 ? nullptr : detail::first_number<Scalar>(std::addressof(std::data(*all)->*member));
    return PointerPlaces<Scalar>::template evenly<Scalar, Numbers::count>(
        first, static_cast<Index>(sizeof(Struct) / sizeof(Scalar)), n);
  }
};
/// A container for each component.
template <class Container, int D>
struct ComponentPlaces {
  std::array<Container*, D> components;
  /// @throws std::invalid_argument where they differ in length
  [[nodiscard]] auto now() const {
    Places<std::remove_reference_t<decltype(*std::data(*components[0]))>, D> all;
    all.stride = 1, all.count = static_cast<Index>(std::size(*components[0]));
    for (std::size_t d = 0; d < D; ++d) {
      if (static_cast<Index>(std::size(*components[d])) != all.count)
        throw std::invalid_argument("phistep: the arrays of the components differ in length");
      all.at[d] = std::data(*components[d]);
    }
    return all;
  }
};

/// A container that owns its elements, or a span of them, held by name.
template <class T>
concept HoldsElements = requires(T& all) {
  std::data(all);
  std::size(all);
};

template <class T>
[[nodiscard]] PointerPlaces<T> places(T* first, Index n) {
  return {first, n};
}
template <int D, std::floating_point Scalar>
[[nodiscard]] StridedPlaces<Scalar, D> places(Scalar* first, Index n, Index stride) {
  return {first, n, stride};
}
template <HoldsElements Container>
[[nodiscard]] ElementPlaces<Container> places(Container& all) {
  return {&all};
}
template <HoldsElements Container, class Struct, class Member>
[[nodiscard]] MemberPlaces<Container, Struct, Member> places(Container& all, Member Struct::*member) {
  return {&all, member};
}
template <HoldsElements Container, std::same_as<Container>... More>
  requires(sizeof...(More) > 0 &&
           std::floating_point<std::remove_reference_t<decltype(*std::data(std::declval<Container&>()))>>)
[[nodiscard]] ComponentPlaces<Container, 1 + int{sizeof...(More)}> places(Container& x, More&... more) {
  return {{&x, &more...}};
}

}  // namespace phistep::inline PHISTEP_ABI

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

#include <array>
#include <concepts>
#include <cstddef>
#include <iterator>
#include <memory>
#include <stdexcept>
#include <type_traits>
#include <utility>

#include "phistep/base/state/strided_block.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

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
struct NumbersOf<std::array<T, n>> {
  using Scalar = T;
  static constexpr int count = static_cast<int>(n);
};
template <std::floating_point T, std::size_t n>
struct NumbersOf<T[n]> : NumbersOf<std::array<T, n>> {};
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

/// Something that says where vectors lie, now.
template <class T>
concept PlacesSource = requires(const T& source) {
  { source.now().count } -> std::convertible_to<Index>;
  typename decltype(source.now())::Plain;
};

/// n vectors of D adjacent numbers, `stride` numbers apart.
template <class Scalar, int D>
struct StridedPlaces {
  Scalar* first;
  Index n, stride = D;
  [[nodiscard]] auto now() const {
    StridedBlock<Scalar, D> all;
    for (std::size_t d = 0; d < D; ++d) all.at[d] = first + d;
    all.stride = stride, all.count = n;
    return all;
  }
};
/// Numbers one after the other: whether x(n) is meant, or x(3, n), doesn't show in a pointer.
template <class Scalar>
struct BareNumbers : StridedPlaces<Scalar, 1> {};

/// Where n vectors or numbers lie, from a pointer on.
template <class T>
[[nodiscard]] auto places(T* first, Index n) {
  using Scalar = typename NumbersOf<T>::Scalar;
  if constexpr (std::is_floating_point_v<T>) return BareNumbers<T>{{first, n}};
  else return StridedPlaces<Scalar, NumbersOf<T>::count>{reinterpret_cast<Scalar*>(first), n};
}
/// n times D adjacent numbers, `stride` numbers apart: x(3, n) of Fortran is places<3>(x, n).
template <int D, std::floating_point Scalar>
[[nodiscard]] StridedPlaces<Scalar, D> places(Scalar* first, Index n, Index stride = D) {
  return {first, n, stride};
}

/// The elements of a container.
template <class Container>
struct ElementPlaces {
  Container* all;
  [[nodiscard]] auto now() const { return places(std::data(*all), static_cast<Index>(std::size(*all))).now(); }
};
/// A member of the elements of a container.
template <class Container, class Struct, class Member>
struct MemberPlaces {
  using Scalar = typename NumbersOf<Member>::Scalar;
  static_assert(sizeof(Struct) % sizeof(Scalar) == 0, "phistep: the struct's size is no multiple of its numbers' size");
  Container* all;
  Member Struct::*member;
  [[nodiscard]] auto now() const {
    const auto n = static_cast<Index>(std::size(*all));
    auto at = places(n == 0 ? nullptr : std::addressof(std::data(*all)->*member), n);
    at.stride = static_cast<Index>(sizeof(Struct) / sizeof(Scalar));
    return at.now();
  }
};
/// A container for each component.
template <class Container, int D>
struct ComponentPlaces {
  std::array<Container*, D> components;
  /// @throws std::invalid_argument where they differ in length
  [[nodiscard]] auto now() const {
    StridedBlock<std::remove_reference_t<decltype(*std::data(*components[0]))>, D> all;
    all.stride = 1, all.count = static_cast<Index>(std::size(*components[0]));
    for (std::size_t d = 0; d < D; ++d) {
      if (static_cast<Index>(std::size(*components[d])) != all.count)
        throw std::invalid_argument("phistep: the arrays of the components differ in length");
      all.at[d] = std::data(*components[d]);
    }
    return all;
  }
};

/// A container or a span that is an lvalue: places(…) keeps its address.
template <class T>
concept HoldsElements = requires(T& all) {
  std::data(all);
  std::size(all);
};

/// The elements of a container: vectors or numbers.
template <HoldsElements Container>
[[nodiscard]] ElementPlaces<Container> places(Container& all) {
  return {&all};
}
/// A member of each struct in a container.
template <HoldsElements Container, class Struct, class Member>
[[nodiscard]] MemberPlaces<Container, Struct, Member> places(Container& all, Member Struct::*member) {
  return {&all, member};
}
/// A container of numbers for each component.
template <HoldsElements Container, std::same_as<Container>... More>
  requires(sizeof...(More) > 0 &&
           std::floating_point<std::remove_reference_t<decltype(*std::data(std::declval<Container&>()))>>)
[[nodiscard]] ComponentPlaces<Container, 1 + int{sizeof...(More)}> places(Container& x, More&... more) {
  return {{&x, &more...}};
}

}}  // namespace phistep::PHISTEP_ABI

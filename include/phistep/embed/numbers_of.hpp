/// @file
/// Objects that are nothing but numbers of one type: how many, and of which.
#pragma once

#include <Eigen/Core>

#include <array>
#include <concepts>
#include <cstddef>
#include <type_traits>

#include "phistep/core/version.hpp"
#include "phistep/state/blocks.hpp"

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

}}  // namespace phistep::PHISTEP_ABI

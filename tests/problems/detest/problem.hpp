#pragma once

#include <array>
#include <cstddef>

namespace problems::detest {

/// What the problems of this folder share: y' = f(t, y) in n components from t = 0 to `end`, as
///
///     static std::array<double, n> start();                            y(0)
///     template <class T> static void rate(T t, const T* y, T* out);    out = f(t, y)
///     static std::array<double, n> exact();                            y(end)
///
/// C++17 without Eigen, so that every rival can inline them. Constants are doubles, and the same in every precision. The
/// answers: accuracy/truth/smooth_references.cpp.
template <std::size_t size>
struct Problem {
  static constexpr std::size_t n = size;
  static constexpr double end = 20;
};

}  // namespace problems::detest

/// @file
/// The operations of a field (field.hpp) whose numbers lie in arrays of the processes that share it.
#pragma once

#include <algorithm>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>

#include "phistep/core/version.hpp"
#include "phistep/simd/fingerprint.hpp"

namespace phistep::inline PHISTEP_ABI {

/// Base of a class `Own` of operations, which brings `Handle`, `clone`, `release`, `size`, and
///   numbers(x)           this rank's numbers as a std::span, or its own read(f, x…) and write(f, y, x…), which call
///                        f(how many, their addresses…) for each of this rank's arrays,
///   total(x, mine)       Σ over the ranks of x, and greatest(x, mine), the largest: MPI_Allreduce, where there are many,
///   rank(x), ranks(x)    this one's number from 0 on, and how many there are.
/// What it has of the functions below takes their place.
template <class Own, std::floating_point Number = double>
struct ArrayFieldOps {
  using Scalar = Number;
  struct HasArrays {};

  static void read(auto&& f, auto x, auto... more) {
    f(std::size(Own::numbers(x)), static_cast<const Number*>(Own::numbers(x).data()),
      static_cast<const Number*>(Own::numbers(more).data())...);
  }
  static void write(auto&& f, auto y, auto... x) {
    f(std::size(Own::numbers(y)), Own::numbers(y).data(), static_cast<const Number*>(Own::numbers(x).data())...);
  }
  static double total(auto, double mine) { return mine; }
  static double greatest(auto, double mine) { return mine; }
  static int rank(auto) { return 0; }
  static int ranks(auto) { return 1; }

  static void fill(auto y, Number a) {
    Own::write([a](std::size_t n, Number* to) { std::fill_n(to, n, a); }, y);
  }
  static void poison(auto x) { fill(x, std::numeric_limits<Number>::quiet_NaN()); }
  static void combine(auto y, int terms, const Number* a, const auto* x) {
    for (int k = 0; k < terms; ++k)
      Own::write(
          [=](std::size_t n, Number* to, const Number* from) {
            for (std::size_t i = 0; i < n; ++i) to[i] = k == 0 ? a[k] * from[i] : to[i] + a[k] * from[i];
          },
          y, x[k]);
  }
  static void weigh(auto w, auto y, Number atol, Number rtol) {
    Own::write(
        [=](std::size_t n, Number* to, const Number* from) {
          for (std::size_t i = 0; i < n; ++i) {
            const Number scale = atol + rtol * std::abs(from[i]);
            to[i] = scale > 0 ? 1 / scale : 0;
          }
        },
        w, y);
  }
  static double largest(auto x) {
    double most = 0;
    Own::read(
        [&most](std::size_t n, const Number* of) {
          for (std::size_t i = 0; i < n; ++i) {
            const auto size = static_cast<double>(std::abs(of[i]));
            // A NaN is as large as can be: a maximum over ranks may pass over it.
            most = size <= most ? most : std::isnan(size) ? std::numeric_limits<double>::infinity() : size;
          }
        },
        x);
    return Own::greatest(x, most);
  }
  static bool is_finite(auto x) {
    bool all = true;
    Own::read(
        [&all](std::size_t n, const Number* of) {
          for (std::size_t i = 0; i < n; ++i) all = all && std::isfinite(of[i]);
        },
        x);
    return most(x, all ? 0 : 1) == 0;
  }
  static double square(auto x, auto w) {
    double sum = 0;
    Own::read(
        [&sum](std::size_t n, const Number* of, const Number* weight) {
          for (std::size_t i = 0; i < n; ++i) sum += of[i] * weight[i] * of[i] * weight[i];
        },
        x, w);
    return Own::total(x, sum);
  }
  static double square(auto e, auto y, auto z, Number atol, Number rtol) {
    double sum = 0;
    Own::read(
        [&](std::size_t n, const Number* of, const Number* a, const Number* b) {
          for (std::size_t i = 0; i < n; ++i) {
            const Number share = of[i] / (atol + rtol * std::max(std::abs(a[i]), std::abs(b[i])));
            sum += of[i] == 0 ? 0 : share * share;
          }
        },
        e, y, z);
    return Own::total(e, sum);
  }
  static bool equal(auto x, auto y) {
    bool same = true;
    Own::read([&same](std::size_t n, const Number* a,
                      const Number* b) { same = same && std::memcmp(a, b, n * sizeof(Number)) == 0; },
              x, y);
    return most(x, same ? 0 : 1) == 0;
  }
  static std::uint64_t fingerprint(auto x) {
    std::uint64_t all = 0;
    Own::read([&all](std::size_t n,
                     const Number* of) { all = phistep::fingerprint(of, static_cast<std::ptrdiff_t>(n), all); },
              x);
    return all;
  }
  static int most(auto x, int mine) { return static_cast<int>(Own::greatest(x, mine)); }
};

}  // namespace phistep::inline PHISTEP_ABI

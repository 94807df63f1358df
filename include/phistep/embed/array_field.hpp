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
#include <span>
#include <vector>

#include "phistep/base/numbers/fingerprint.hpp"
#include "phistep/base/numbers/finite_witness.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// Base of a class `Own` of operations, which brings `Handle`, `clone`, `release`, `size`, and
///   numbers(x)           this rank's numbers as a std::span, or its own read(f, x…) and write(f, y, x…), which call
///                        f(how many, their addresses…) for each of this rank's arrays,
///   total(x, mine)       where there are many ranks: each number of a std::span<double> becomes its sum over all of them,
///                        and greatest(x, mine), the largest: MPI_Allreduce,
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
  static void total(auto, std::span<double>) {}
  static void greatest(auto, std::span<double>) {}
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
  /// @param atol  one, or a field of them
  static void weigh(auto w, auto y, auto atol, Number rtol) {
    const auto put = [=](std::size_t n, Number* to, const Number* from, const auto*... each) {
      for (std::size_t i = 0; i < n; ++i) {
        const Number scale = at(i, atol, each...) + rtol * std::abs(from[i]);
        to[i] = scale > 0 ? 1 / scale : 0;
      }
    };
    if constexpr (std::same_as<decltype(atol), Number>) Own::write(put, w, y);
    else Own::write(put, w, y, atol);
  }
  static double largest_here(auto x) {
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
    return most;
  }
  static bool is_finite_here(auto x) {
    bool all = true;
    Own::read([&all](std::size_t n, const Number* of) { all = all && all_finite(of, static_cast<std::ptrdiff_t>(n)); },
              x);
    return all;
  }
  static bool is_finite(auto x) { return most(x, Own::is_finite_here(x) ? 0 : 1) == 0; }
  static double square(auto x, auto w) {
    double sum = 0;
    Own::read(
        [&sum](std::size_t n, const Number* of, const Number* weight) {
          for (std::size_t i = 0; i < n; ++i) sum += of[i] * weight[i] * of[i] * weight[i];
        },
        x, w);
    return sum;
  }
  static double square(auto e, auto y, auto z, auto atol, Number rtol) {
    double all = 0;
    const auto add = [&](std::size_t n, const Number* of, const Number* a, const Number* b, const auto*... each) {
      double sum = 0;
      for (std::size_t i = 0; i < n; ++i) {
        const Number size = std::max(std::abs(a[i]), std::abs(b[i]));
        const Number share = of[i] / (at(i, atol, each...) + rtol * size);
        sum += of[i] == 0 ? 0 : share * share;
      }
      all += sum;
    };
    if constexpr (std::same_as<decltype(atol), Number>) Own::read(add, e, y, z);
    else Own::read(add, e, y, z, atol);
    return all;
  }
  static int allowed(auto x, auto y) {
    std::vector<std::size_t> mine, theirs;
    Own::read([&theirs](std::size_t n, const Number*) { theirs.push_back(n); }, y);
    int verdict = 0;
    Own::read(
        [&](std::size_t n, const Number* of) {
          mine.push_back(n);
          for (std::size_t i = 0; i < n; ++i)
            verdict = std::max(verdict, of[i] > 0 && std::isfinite(of[i]) ? 0 : of[i] == 0 ? 1 : 2);
        },
        x);
    return most(x, mine == theirs ? verdict : 2);
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
  static int most(auto x, int mine) {
    double all = mine;
    Own::greatest(x, std::span<double>{&all, 1});
    return static_cast<int>(all);
  }

 private:
  /// The i-th tolerance: `atol` is one number for all, or an array.
  static Number at(std::size_t, Number atol) { return atol; }
  static Number at(std::size_t i, auto, const Number* each) { return each[i]; }
};

}}  // namespace phistep::PHISTEP_ABI

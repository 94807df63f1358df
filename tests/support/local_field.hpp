// A field whose numbers lie in one array of this process: to test what the library does with fields, operation by operation.
#pragma once

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "phistep/fields.hpp"

struct LocalVector {
  std::vector<double> x;
  std::uint64_t stamp = 0;
};
struct LocalOps {
  using Scalar = double;
  using Handle = LocalVector*;
  struct Counts {
    long alive = 0, combinations = 0, reductions = 0;
  };
  static Counts& counts() {
    static Counts all;
    return all;
  }
  static std::uint64_t next_stamp() {
    static std::uint64_t last = 0;
    return ++last;
  }
  static Handle make(std::vector<double> x) {
    ++counts().alive;
    return new LocalVector{std::move(x), next_stamp()};
  }
  static Handle clone(Handle x) { return make(std::vector<double>(x->x.size(), std::nan(""))); }
  static void release(Handle x) {
    --counts().alive;
    delete x;
  }
  static std::ptrdiff_t size(Handle x) { return static_cast<std::ptrdiff_t>(x->x.size()); }
  static void fill(Handle y, double a) {
    std::fill(y->x.begin(), y->x.end(), a);
    y->stamp = next_stamp();
  }
  static void combine(Handle y, int terms, const double* a, const Handle* x) {
    ++counts().combinations;
    // Term by term, as most backends do it: y may be the first alone.
    for (std::size_t i = 0; i < y->x.size(); ++i) y->x[i] = a[0] * x[0]->x[i];
    for (int k = 1; k < terms; ++k)
      for (std::size_t i = 0; i < y->x.size(); ++i) y->x[i] += a[k] * x[k]->x[i];
    y->stamp = next_stamp();
  }
  static void weigh(Handle w, Handle y, double atol, double rtol) {
    for (std::size_t i = 0; i < y->x.size(); ++i) {
      const double scale = atol + rtol * std::abs(y->x[i]);
      w->x[i] = scale > 0 ? 1 / scale : 0;
    }
    w->stamp = next_stamp();
  }
  static double largest(Handle x) {
    ++counts().reductions;
    double most = 0;
    for (const double a : x->x) most = std::max(most, std::abs(a));
    return most;
  }
  static bool is_finite(Handle x) {
    ++counts().reductions;
    return std::all_of(x->x.begin(), x->x.end(), [](double a) { return std::isfinite(a); });
  }
  static double square(Handle x, Handle w) {
    ++counts().reductions;
    double sum = 0;
    for (std::size_t i = 0; i < x->x.size(); ++i) sum += x->x[i] * w->x[i] * x->x[i] * w->x[i];
    return sum;
  }
  static double square(Handle e, Handle y, Handle z, double atol, double rtol) {
    ++counts().reductions;
    double sum = 0;
    for (std::size_t i = 0; i < e->x.size(); ++i) {
      const double share = e->x[i] / (atol + rtol * std::max(std::abs(y->x[i]), std::abs(z->x[i])));
      sum += e->x[i] == 0 ? 0 : share * share;
    }
    return sum;
  }
  static bool equal(Handle x, Handle y) {
    ++counts().reductions;
    return std::equal(x->x.begin(), x->x.end(), y->x.begin(), [](double a, double b) {
      return std::bit_cast<std::uint64_t>(a) == std::bit_cast<std::uint64_t>(b);
    });
  }
  static std::uint64_t fingerprint(Handle x) { return x->stamp; }
  static int most(Handle, int mine) {
    ++counts().reductions;
    return mine;
  }
  static void poison(Handle x) { fill(x, std::numeric_limits<double>::quiet_NaN()); }
};
using LocalField = phistep::Field<LocalOps>;

inline LocalField local_field(std::vector<double> x) { return LocalField{LocalOps::make(std::move(x))}; }
inline std::vector<double>& numbers(const LocalField& y) { return y.handle()->x; }

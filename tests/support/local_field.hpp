// A field whose numbers lie in one array of this process: to test what the library does with fields, operation by operation.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "phistep/fields.hpp"

struct LocalVector {
  std::vector<double> x;
  std::uint64_t stamp = 0;
};
struct LocalOps : phistep::ArrayFieldOps<LocalOps> {
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
  static std::span<double> numbers(Handle x) { return x->x; }
  static void write(auto&& f, Handle y, auto... x) {
    ArrayFieldOps::write(f, y, x...);
    y->stamp = next_stamp();
  }
  static void combine(Handle y, int terms, const double* a, const Handle* x) {
    ++counts().combinations;
    ArrayFieldOps::combine(y, terms, a, x);
  }
  static void total(Handle, std::span<double>) { ++counts().reductions; }
  static void greatest(Handle, std::span<double>) { ++counts().reductions; }
  static std::uint64_t fingerprint(Handle x) { return x->stamp; }
};
using LocalField = phistep::Field<LocalOps>;

inline LocalField local_field(std::vector<double> x) { return LocalField{LocalOps::make(std::move(x))}; }
inline std::vector<double>& numbers(const LocalField& y) { return y.handle()->x; }

/// @file
/// A block whose numbers the library never touches: a vector spread over the ranks of a parallel program, or in a device's
/// memory. All that is done with it is a linear combination, or a reduction over all of it whose result every rank gets
/// alike: so all ranks decide alike what becomes of a step.
#pragma once

#include <Eigen/Core>

#include <array>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <span>
#include <type_traits>
#include <utility>

#include "phistep/base/version.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// What a backend brings, as static functions of a class `Ops` (adapters/petsc.hpp has them for a Vec). Those that tell
/// something of all numbers are collective: all ranks call them together, and each gets the same result. Sums and largest
/// numbers are this rank's share: one reduction serves several.
template <class Ops>
concept FieldOperations = std::floating_point<typename Ops::Scalar> &&
    requires(typename Ops::Handle x, typename Ops::Handle y, typename Ops::Handle z, typename Ops::Scalar a,
             const typename Ops::Scalar* weights, const typename Ops::Handle* terms, int mine, std::span<double> all) {
  { Ops::clone(x) } -> std::same_as<typename Ops::Handle>;  // of the same layout; its numbers are not set
  Ops::release(x);                                          // the end of one
  { Ops::size(x) } -> std::convertible_to<std::ptrdiff_t>;  // numbers of all ranks together
  Ops::fill(y, a);                                          // y_i = a
  Ops::combine(y, 2, weights, terms);  // y = Σ_k weights[k] terms[k]; of these, the first may be y
  Ops::weigh(y, x, a, a);              // y_i = 1/(a + b |x_i|), 0 for 1/0; a: a number, or z's a_i
  Ops::weigh(y, x, z, a);
  { Ops::is_finite_here(x) } -> std::same_as<bool>;               // whether this rank's numbers are
  { Ops::largest_here(x) } -> std::convertible_to<double>;        // max_i |x_i| of this rank's, infinite for NaN
  { Ops::square(x, y) } -> std::convertible_to<double>;           // Σ (x_i y_i)² of this rank's
  { Ops::square(x, y, z, a, a) } -> std::convertible_to<double>;  // Σ (x_i/(a + b max(|y_i|, |z_i|)))² of this rank's
  { Ops::square(x, y, z, z, a) } -> std::convertible_to<double>;
  Ops::total(x, all);                           // each becomes its sum over all ranks, collective
  Ops::greatest(x, all);                        // each becomes the largest of all ranks', collective
  { Ops::allowed(x, y) } -> std::same_as<int>;  // 2 unless x has y's layout and no x_i < 0; 1: some are 0; collective
  { Ops::is_finite(x) } -> std::same_as<bool>;  // whether all are, collective
  { Ops::equal(x, y) } -> std::same_as<bool>;   // all bits, collective
  { Ops::fingerprint(x) } -> std::same_as<std::uint64_t>;  // another one after any change of this rank's numbers
  { Ops::most(x, mine) } -> std::same_as<int>;             // the largest of every rank's number, collective
  Ops::poison(x);                                          // this rank's numbers become NaN; not collective
};

template <FieldOperations Ops>
class Field;

/// Σ_k a_k x_k, not yet computed.
template <class Ops, std::size_t n>
struct FieldCombination {
  using Scalar = typename Ops::Scalar;
  std::array<Scalar, n> a;
  std::array<const Field<Ops>*, n> x;
};

template <class Ops>
[[nodiscard]] FieldCombination<Ops, 1> terms_of(const Field<Ops>& x) {
  return {{typename Ops::Scalar{1}}, {&x}};
}
template <class Ops, std::size_t n>
[[nodiscard]] const FieldCombination<Ops, n>& terms_of(const FieldCombination<Ops, n>& x) {
  return x;
}
template <class T>
concept FieldTerm = requires(const T& x) {
  terms_of(x);
};

template <class Ops, std::size_t n, std::size_t m>
[[nodiscard]] FieldCombination<Ops, n + m> joined(const FieldCombination<Ops, n>& p, const FieldCombination<Ops, m>& q,
                                                  typename Ops::Scalar sign) {
  FieldCombination<Ops, n + m> all;
  for (std::size_t k = 0; k < n; ++k) all.a[k] = p.a[k], all.x[k] = p.x[k];
  for (std::size_t k = 0; k < m; ++k) all.a[n + k] = sign * q.a[k], all.x[n + k] = q.x[k];
  return all;
}
template <FieldTerm A, FieldTerm B>
[[nodiscard]] auto operator+(const A& a, const B& b) {
  return joined(terms_of(a), terms_of(b), 1);
}
template <FieldTerm A>
[[nodiscard]] auto operator-(const A& a) {
  return -1 * terms_of(a);
}
template <FieldTerm A, FieldTerm B>
[[nodiscard]] auto operator-(const A& a, const B& b) {
  return joined(terms_of(a), terms_of(b), -1);
}
template <FieldTerm A>
[[nodiscard]] auto operator*(typename A::Scalar factor, const A& a) {
  auto all = terms_of(a);
  for (auto& weight : all.a) weight *= factor;
  return all;
}
template <FieldTerm A>
[[nodiscard]] auto operator/(const A& a, typename A::Scalar divisor) {
  auto all = terms_of(a);
  for (auto& weight : all.a) weight /= divisor;
  return all;
}

/// The vector behind a handle, which it owns. It takes part in linear combinations, `x = y + h * (a - b)`, as an Eigen vector
/// does: one pass over all terms, x among them or not.
template <FieldOperations Operations>
class Field {
 public:
  using Ops = Operations;
  using Scalar = typename Ops::Scalar;
  using Handle = typename Ops::Handle;
  using PlainObject = Field;
  template <std::size_t n>
  using Combination = FieldCombination<Ops, n>;
  static constexpr bool is_field = true, IsRowMajor = false, IsVectorAtCompileTime = true;
  static constexpr int SizeAtCompileTime = Eigen::Dynamic, RowsAtCompileTime = Eigen::Dynamic, ColsAtCompileTime = 1;

  Field() = default;
  /// @param mine  released at its end
  explicit Field(Handle mine) : handle_{mine} {}
  Field(const Field& x) { *this = x; }
  Field(Field&& x) noexcept { swap(x); }
  ~Field() { release(); }
  Field& operator=(const Field& x) {
    if (this == &x) return *this;
    if (!x.handle_) release();
    else *this = terms_of(x);
    return *this;
  }
  Field& operator=(Field&& x) noexcept {
    swap(x);
    return *this;
  }
  template <std::size_t n>
  Field& operator=(const FieldCombination<Ops, n>& all) {
    take_shape(*all.x[0]);
    // Each vector once, and this one first.
    std::array<Scalar, n> a{};
    std::array<Handle, n> x{};
    int terms = 0;
    const auto add = [&](Scalar weight, Handle of) {
      for (int k = 0; k < terms; ++k)
        if (x[static_cast<std::size_t>(k)] == of) {
          a[static_cast<std::size_t>(k)] += weight;
          return;
        }
      a[static_cast<std::size_t>(terms)] = weight, x[static_cast<std::size_t>(terms++)] = of;
    };
    for (std::size_t k = 0; k < n; ++k)
      if (all.x[k] == this) add(all.a[k], handle_);
    for (std::size_t k = 0; k < n; ++k)
      if (all.x[k] != this) add(all.a[k], all.x[k]->handle_);
    Ops::combine(handle_, terms, a.data(), x.data());
    return *this;
  }
  Field& operator+=(const FieldTerm auto& x) { return *this = terms_of(*this) + x; }
  Field& operator-=(const FieldTerm auto& x) { return *this = terms_of(*this) - x; }
  /// This rank's numbers become NaN.
  void poison() { Ops::poison(handle_); }
  Field& operator*=(Scalar factor) { return *this = factor * terms_of(*this); }
  /// All numbers are 0; one without a layout stays so.
  void setZero() {
    if (handle_) Ops::fill(handle_, Scalar{0});
  }
  /// The layout becomes that of x, where there is none yet.
  void take_shape(const Field& x) {
    if (!handle_) handle_ = Ops::clone(x.handle_);
  }
  void swap(Field& x) noexcept { std::swap(handle_, x.handle_); }

  /// For a checkpoint: this rank's numbers, which are as many where they are read.
  void archive(auto& ar) requires requires { typename Ops::HasArrays; }
  {
    bool is_there = handle_ != Handle{};
    ar("is_there", is_there);
    if (!is_there) return release();
    ar.check(handle_ != Handle{});
    const auto part = [&ar](std::size_t n, auto* x) {
      ar.in_place(
          Eigen::Map<Eigen::Matrix<Scalar, Eigen::Dynamic, 1>>(const_cast<Scalar*>(x), static_cast<Eigen::Index>(n)));
    };
    if constexpr (std::remove_cvref_t<decltype(ar)>::reading) Ops::write(part, handle_);
    else Ops::read(part, handle_);
  }

  [[nodiscard]] Handle handle() const { return handle_; }
  [[nodiscard]] Eigen::Index size() const { return handle_ ? static_cast<Eigen::Index>(Ops::size(handle_)) : 0; }
  [[nodiscard]] Eigen::Index rows() const { return size(); }
  [[nodiscard]] static Eigen::Index cols() { return 1; }

 private:
  void release() {
    if (handle_) Ops::release(handle_);
    handle_ = Handle{};
  }

  Handle handle_{};
};

}}  // namespace phistep::PHISTEP_ABI

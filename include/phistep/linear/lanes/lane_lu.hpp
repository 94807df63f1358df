/// @file
/// Several complex matrices of one shape factorized side by side, one a lane: W_l x_l = b_l, l = 0 … lanes − 1.
///
/// The lanes are W_l = λ_l M − J of an implicit Runge-Kutta method, whose entries are alike in size: they share their rows'
/// exchanges, chosen so that the worst lane's pivot is largest beside that lane's best. Each operation is then the same for
/// all of them: a vector of `lanes` numbers in n = 2 as in n = 20.
#pragma once

#include <Eigen/Core>

#include <array>
#include <cmath>
#include <limits>
#include <type_traits>
#include <utility>
#include <vector>

#include "phistep/base/numbers/arithmetic.hpp"
#include "phistep/base/version.hpp"
#include "phistep/linear/lanes/complex_pack.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// LU with row exchanges; up to `inverse_limit` unknowns the inverse, whose rows don't wait for each other.
template <class Scalar, int size, int lanes>
class LaneLu {
 public:
  using Number = ComplexPack<Scalar, lanes>;
  using Real = typename Number::Real;
  static constexpr int inverse_limit = 8;
  static constexpr bool inverts = size != Eigen::Dynamic && size <= inverse_limit;

  void resize(Eigen::Index n) {
    if constexpr (size == Eigen::Dynamic) {
      n_ = static_cast<int>(n);
      a_.resize(static_cast<std::size_t>(n * n));
      beside_.resize(static_cast<std::size_t>(n));
      row_.resize(static_cast<std::size_t>(n));
    }
  }
  [[nodiscard]] int n() const {
    if constexpr (size == Eigen::Dynamic) return n_;
    else return size;
  }
  /// Entry (i, j), to be filled before factorize().
  [[nodiscard]] Number& operator()(int i, int j) { return a_[static_cast<std::size_t>(i * n() + j)]; }

  /// False where a pivot is zero or not finite.
  [[nodiscard]] bool factorize() {
    const int n = this->n();
    for (int i = 0; i < n; ++i) row_[std::size_t(i)] = i;
    bool good = true;
    for (int k = 0; k < n; ++k) {
      if (k + 1 < n) exchange(k, pivot(k));
      Number* const top = &(*this)(k, 0);
      const Real size_of_pivot = top[k].norm();
      // A pivot whose square leaves the range is refused too.
      good = good && all_at_least(size_of_pivot, Real{least_normal<Scalar>}) &&
             all_at_least(Real{std::numeric_limits<Scalar>::max()}, size_of_pivot);
      const Number inverse = top[k].inverse();
      if constexpr (inverts) {
        top[k] = {Real{Scalar{1}}, Real{Scalar{0}}};
        for (int j = 0; j < n; ++j) top[j] = top[j] * inverse;
        for (int i = 0; i < n; ++i) {
          if (i == k) continue;
          Number* const row = &(*this)(i, 0);
          const Number f = row[k];
          row[k] = {Real{Scalar{0}}, Real{Scalar{0}}};
          for (int j = 0; j < n; ++j) row[j].subtract(f, top[j]);
        }
      } else {
        top[k] = inverse;
        for (int i = k + 1; i < n; ++i) {
          Number* const row = &(*this)(i, 0);
          if (all_at_least(Real{Scalar{0}}, row[k].norm())) continue;  // small Jacobians are mostly zeros
          const Number f = row[k] = row[k] * inverse;
          for (int j = k + 1; j < n; ++j) row[j].subtract(f, top[j]);
        }
      }
    }
    return good;
  }

  /// x ← W⁻¹ x
  void solve_in_place(Number* x) {
    const int n = this->n();
    if constexpr (inverts) {
      std::array<Number, size> b;
      for (int i = 0; i < n; ++i) b[std::size_t(i)] = x[row_[std::size_t(i)]];
      for (int i = 0; i < n; ++i) {
        const Number* const row = &(*this)(i, 0);
        Number sum = row[0] * b[0];
        for (int j = 1; j < n; ++j) sum.add(row[j], b[std::size_t(j)]);
        x[i] = sum;
      }
    } else {
      // Column by column: what is subtracted from one row doesn't wait for another's.
      for (int i = 0; i < n; ++i) beside_[std::size_t(i)] = x[row_[std::size_t(i)]];
      for (int k = 0; k < n; ++k) {
        const Number by = x[k] = beside_[std::size_t(k)];
        for (int i = k + 1; i < n; ++i) beside_[std::size_t(i)].subtract((*this)(i, k), by);
      }
      for (int k = n - 1; k >= 0; --k) {
        const Number by = x[k] = x[k] * (*this)(k, k);
        for (int i = 0; i < k; ++i) x[i].subtract((*this)(i, k), by);
      }
    }
  }

 private:
  /// The row whose worst lane is best.
  [[nodiscard]] int pivot(int k) {
    const int n = this->n();
    Real best = (*this)(k, k).norm();
    for (int i = k + 1; i < n; ++i) {
      const Real x = (*this)(i, k).norm();
      best = larger(x, best);
    }
    // 0 and NaN are found by factorize().
    const Real by = Real{Scalar{1}} / best;
    int at = k;
    Scalar share{-1};
    for (int i = k; i < n; ++i) {
      const Real x = (*this)(i, k).norm() * by;
      Scalar worst = x[0];
      for (int l = 1; l < lanes; ++l) worst = x[l] < worst ? x[l] : worst;
      if (worst > share) share = worst, at = i;
    }
    return at;
  }
  void exchange(int k, int i) {
    if (i == k) return;
    std::swap(row_[std::size_t(k)], row_[std::size_t(i)]);
    for (int j = 0; j < n(); ++j) std::swap((*this)(k, j), (*this)(i, j));
  }

  static constexpr bool is_fixed = size != Eigen::Dynamic;
  template <class T, int count>
  using Store = std::conditional_t<is_fixed, std::array<T, std::size_t(is_fixed ? count : 1)>, std::vector<T>>;
  int n_ = 0;
  Store<Number, size * size> a_;
  Store<Number, size> beside_;
  Store<int, size> row_;
};

}}  // namespace phistep::PHISTEP_ABI

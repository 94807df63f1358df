/// @file
/// The best plain loops for one fixed size, as one writes them for a single problem. They check nothing.
#pragma once

#include <cmath>
#include <utility>

namespace small_dense {

/// Column-major LU with row pivoting; the compiler knows all bounds.
template <int n>
struct HandLu {
  double a[n * n], inverse_pivot[n];
  int pivot[n];

  void factor(const double* A) {
    for (int i = 0; i < n * n; ++i) a[i] = A[i];
    for (int k = 0; k < n; ++k) {
      int m = k;
      double largest = std::fabs(a[k + k * n]);
      for (int i = k + 1; i < n; ++i)
        if (const double size = std::fabs(a[i + k * n]); size > largest) {
          largest = size;
          m = i;
        }
      pivot[k] = m;
      if (m != k)
        for (int j = 0; j < n; ++j) std::swap(a[k + j * n], a[m + j * n]);
      const double r = inverse_pivot[k] = 1 / a[k + k * n];
      for (int i = k + 1; i < n; ++i) a[i + k * n] *= r;
      for (int j = k + 1; j < n; ++j) {
        const double u = a[k + j * n];
        for (int i = k + 1; i < n; ++i) a[i + j * n] -= a[i + k * n] * u;
      }
    }
  }
  void solve(double* b) const {
    for (int k = 0; k < n; ++k) std::swap(b[k], b[pivot[k]]);
    for (int k = 0; k < n; ++k) {
      const double y = b[k];
      for (int i = k + 1; i < n; ++i) b[i] -= a[i + k * n] * y;
    }
    for (int k = n - 1; k >= 0; --k) {
      b[k] *= inverse_pivot[k];
      const double x = b[k];
      for (int i = 0; i < k; ++i) b[i] -= a[i + k * n] * x;
    }
  }
};

}  // namespace small_dense

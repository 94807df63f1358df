#pragma once

#include <array>
#include <cmath>
#include <cstddef>

namespace problems {

/// Accelerations of N bodies that attract each other, each pair once: a_i = Σ_j g_j (r_j − r_i)/d³. In coordinates first: x of
/// all bodies, then y, (z). Body i meets body i + k (mod N) for k = 1 … N/2, so that the pairs of one k lie side by side,
/// and roots and quotients of all pairs are taken together.
template <int N, int dimensions, class T>
inline void attract(const std::array<double, N>& g, const T* r, T* a) {
  constexpr int half = N / 2, pairs = N * (N - 1) / 2;
  T d[dimensions][pairs], w[pairs];
  for (int c = 0; c < dimensions; ++c)
    for (int k = 1, p = 0; k <= half; ++k)
      for (int i = 0; i < N && p < pairs; ++i, ++p) d[c][p] = r[c * N + (i + k) % N] - r[c * N + i];
  for (int p = 0; p < pairs; ++p) {
    T square = d[0][p] * d[0][p];
    for (int c = 1; c < dimensions; ++c) square += d[c][p] * d[c][p];
    w[p] = T(1) / (square * std::sqrt(square));
  }
  for (int c = 0; c < dimensions; ++c) {
    T* const to = a + c * N;
    for (int i = 0; i < N; ++i) to[i] = T(0);
    for (int k = 1, p = 0; k <= half; ++k)
      for (int i = 0; i < N && p < pairs; ++i, ++p) {
        const int j = (i + k) % N;
        const T pull = w[p] * d[c][p];
        to[i] += g[static_cast<std::size_t>(j)] * pull;
        to[j] -= g[static_cast<std::size_t>(i)] * pull;
      }
  }
}

}  // namespace problems

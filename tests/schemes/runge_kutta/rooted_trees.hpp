#pragma once

// Rooted trees, which the order conditions of Runge-Kutta methods are numbered by (Hairer, Nørsett & Wanner, Solving ODEs I,
// sect. II.2): Σ_j b_j Φ_j(t) = 1/γ(t) for each tree t of up to p vertices.
#include <cstddef>
#include <vector>

namespace rooted_trees {

/// A root and what grows on it.
struct Tree {
  std::vector<Tree> branches;

  [[nodiscard]] int size() const {
    int n = 1;
    for (const Tree& branch : branches) n += branch.size();
    return n;
  }
  /// γ(t), eq. II.2.17
  [[nodiscard]] long double gamma() const {
    long double product = size();
    for (const Tree& branch : branches) product *= branch.gamma();
    return product;
  }
  /// Φ_j(t) of all stages, theorem II.2.7. @tparam Tableau  with a and stages
  template <class Tableau>
  [[nodiscard]] std::vector<long double> weights() const {
    const auto s = static_cast<std::size_t>(Tableau::stages);
    std::vector<long double> all(s, 1);
    for (const Tree& branch : branches) {
      const auto inner = branch.weights<Tableau>();
      for (std::size_t i = 0; i < s; ++i) {
        long double sum = 0;
        for (std::size_t j = 0; j < i; ++j) sum += Tableau::a[i][j] * inner[j];
        all[i] *= sum;
      }
    }
    return all;
  }
};

/// All trees of n vertices, each once: 1, 1, 2, 4, 9, 20, 48, 115.
inline std::vector<Tree> trees(int n);

/// All forests of n vertices of trees not larger than the last one taken: (size, number) from the largest down.
inline void add_forests(int left, int size, std::size_t number, std::vector<Tree>& forest, std::vector<Tree>& out) {
  if (left == 0) out.push_back({forest});
  for (int m = size < left ? size : left; m > 0; --m) {
    const auto all = trees(m);
    const std::size_t end = m == size && number < all.size() ? number : all.size();
    for (std::size_t k = 0; k < end; ++k) {
      forest.push_back(all[k]);
      add_forests(left - m, m, k + 1, forest, out);
      forest.pop_back();
    }
  }
}
inline std::vector<Tree> trees(int n) {
  std::vector<Tree> all, forest;
  if (n > 0) add_forests(n - 1, n - 1, static_cast<std::size_t>(-1), forest, all);
  return all;
}

}  // namespace rooted_trees

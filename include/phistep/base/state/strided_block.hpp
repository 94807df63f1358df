/// @file
/// A block of a state whose numbers lie in the caller's memory, at one stride for each component.
#pragma once

#include <Eigen/Core>

#include <array>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <type_traits>
#include <vector>

#include "phistep/base/state/blocks.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// [vectors] Arrays in place are worked on in pieces of this length, which stay in the first cache; a multiple of what
/// fingerprints take.
template <int D>
inline constexpr Index places_chunk = D == 1   ? 512
                                      : D == 2 ? 256
                                               : 128;

/// n vectors of D numbers in the caller's memory: component d of vector p at `at[d] + p·stride`. As a matrix it has one
/// column a vector; for D = 1 it is a vector.
template <std::floating_point T, int D>
class StridedBlock {
 public:
  using Scalar = T;
  using Plain = std::conditional_t<D == 1, Eigen::Matrix<T, Eigen::Dynamic, 1>, Eigen::Matrix<T, D, Eigen::Dynamic>>;
  static constexpr int dim = D, SizeAtCompileTime = Eigen::Dynamic;
  static constexpr bool IsRowMajor = false;

  std::array<T*, D> at{};
  Index stride = D;  ///< in numbers
  Index count = 0;   ///< of vectors

  [[nodiscard]] Index rows() const { return D == 1 ? count : D; }
  [[nodiscard]] Index cols() const { return D == 1 ? 1 : count; }
  [[nodiscard]] Index size() const { return D * count; }
  [[nodiscard]] T& operator()(Index i, Index j) const {
    if constexpr (D == 1) return at[0][i * stride];
    else return at[static_cast<std::size_t>(i)][j * stride];
  }
  /// A vector's numbers are neighbours.
  [[nodiscard]] bool is_adjacent() const {
    for (std::size_t d = 1; d < D; ++d)
      if (at[d] != at[0] + d) return false;
    return true;
  }
  /// Each component's numbers are neighbours, in arrays apart.
  [[nodiscard]] bool has_components() const { return D > 1 && stride == 1; }
  /// All numbers lie in one piece.
  [[nodiscard]] bool is_contiguous() const { return stride == D && is_adjacent(); }

  /// to[D i + d] = component d of vector first + i, for m vectors
  void gather(Index first, Index m, T* to) const {
    pass(first, m, to, [](const T* place, T* number, auto n) { std::memcpy(number, place, n * sizeof(T)); });
  }
  /// The way back.
  void scatter(const T* from, Index first, Index m) const {
    pass(first, m, from, [](T* place, const T* number, auto n) { std::memcpy(place, number, n * sizeof(T)); });
  }
  /// f(first byte, bytes, stride [bytes]) for each row of pieces of equal length, of `count` pieces
  void for_each_row(auto&& f) const {
    const bool adjacent = is_adjacent();
    for (std::size_t d = 0; d < (adjacent ? 1 : D); ++d)
      f(reinterpret_cast<std::uintptr_t>(at[d]), (adjacent ? D : 1) * sizeof(T),
        static_cast<std::uintptr_t>(stride) * sizeof(T));
  }

 private:
  /// f(places, numbers, how many of both are neighbours)
  void pass(Index first, Index m, auto* numbers, auto&& f) const {
    if (m == 0) return;  // of no places
    if (is_contiguous()) return f(at[0] + first * D, numbers, static_cast<std::size_t>(m * D));
    if (is_adjacent())  // a constant, so that no function is called for each
      for (Index i = 0; i < m; ++i)
        f(at[0] + (first + i) * stride, numbers + i * D, std::integral_constant<std::size_t, D>{});
    else
      for (std::size_t d = 0; d < D; ++d)
        for (Index i = 0; i < m; ++i)
          f(at[d] + (first + i) * stride, numbers + i * D + static_cast<Index>(d),
            std::integral_constant<std::size_t, 1>{});
  }
};

template <class T, int D, class Block>
void assign_block(Block& to, const StridedBlock<T, D>& from) {
  if (to.rows() != from.rows() || to.cols() != from.cols()) to.resize(from.rows(), from.cols());
  from.gather(0, from.count, to.data());
}
template <class T, int D, class Block>
void assign_block(StridedBlock<T, D>& to, const Block& from) {
  to.scatter(from.data(), 0, to.count);
}

/// Whether each number of these has a place of its own. Rows of pieces that lie between one another, as members of structs
/// do, have one stride.
template <class First, class... More>
[[nodiscard]] bool have_own_places(const First& first, const More&... more) {
  struct Row {
    std::uintptr_t from, bytes, stride, to;
  };
  std::vector<Row> rows;
  const auto n = static_cast<std::uintptr_t>(first.count);
  if (n == 0) return true;
  const auto add = [&rows, n](std::uintptr_t from, std::uintptr_t bytes, std::uintptr_t stride) {
    rows.push_back({from, bytes, stride, from + (n - 1) * stride + bytes});
  };
  first.for_each_row(add);
  (more.for_each_row(add), ...);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const Row& a = rows[i];
    if (n > 1 && a.bytes > a.stride) return false;
    for (std::size_t j = 0; j < i; ++j) {
      const Row& b = rows[j];
      if (a.to <= b.from || b.to <= a.from) continue;
      if (a.stride != b.stride) return false;
      const Row &low = a.from < b.from ? a : b, &high = a.from < b.from ? b : a;
      const std::uintptr_t gap = (high.from - low.from) % a.stride;  // from a piece of `low` to the next of `high`
      if (n == 1 || gap < low.bytes || gap + high.bytes > a.stride) return false;
    }
  }
  return true;
}

}}  // namespace phistep::PHISTEP_ABI

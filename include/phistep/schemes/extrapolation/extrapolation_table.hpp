/// @file
/// The table of an extrapolated step: rows of n_j equal substeps, each row's end extrapolated to substeps of no length
/// (Aitken & Neville; Hairer, Nørsett & Wanner, Solving ODEs I, sect. II.9, eq. 9.10),
///
///     T_{j,l+1} = T_{j,l} + (T_{j,l} − T_{j−1,l}) / ((n_j/n_{j−l})^p − 1)                                       (1)
///
/// with p = 1, or 2 where the error has even powers alone. T are increments, y(t+Δt) − y: what (1) amplifies is then
/// their rounding, not that of y.
#pragma once

#include <array>
#include <cmath>

#include "phistep/core/version.hpp"
#include "phistep/state/blocks.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// n_j = 2, 3, 4, 6, 8, 12, 16, 24, … : Bulirsch's numbers without 1, Hairer & Wanner's choice for stiff equations.
/// [0] is unused.
template <int columns>
[[nodiscard]] constexpr std::array<int, columns + 1> bulirsch_numbers() {
  std::array<int, columns + 1> n{};
  for (int j = 1; j <= columns; ++j)
    n[static_cast<std::size_t>(j)] = j == 1 ? 2 : j == 2 ? 3 : j == 3 ? 4 : 2 * n[static_cast<std::size_t>(j - 2)];
  return n;
}
/// n_j = 2, 4, 6, 8, …: fewest calls where the expansion is even (P. Deuflhard, Numer. Math. 41 (1983) 399).
template <int columns>
[[nodiscard]] constexpr std::array<int, columns + 1> even_numbers() {
  std::array<int, columns + 1> n{};
  for (int j = 1; j <= columns; ++j) n[static_cast<std::size_t>(j)] = 2 * j;
  return n;
}

/// 1/((n_j/n_{j−l})^power − 1), all of (1), [j][l].
template <class Scalar, int power, int columns>
[[nodiscard]] constexpr auto neville_weights(const std::array<int, columns + 1>& n) {
  std::array<std::array<Scalar, columns + 1>, columns + 1> weights{};
  for (std::size_t j = 2; j <= columns; ++j)
    for (std::size_t l = 1; l < j; ++l) {
      // b^p/(a^p − b^p) of whole numbers: rounded once
      const Scalar a = static_cast<Scalar>(power == 1 ? n[j] : n[j] * n[j]);
      const Scalar b = static_cast<Scalar>(power == 1 ? n[j - l] : n[j - l] * n[j - l]);
      weights[j][l] = b / (a - b);
    }
  return weights;
}

/// Extends the table by row j ≥ 2. In: row[l] = T_{j−1,l} for l < j, and row[j] = T_{j,1}. Out: row[l] = T_{j,l} for l ≤ j.
/// @param weights  neville_weights(…)[j]
template <State S, class Weights>
void extend_table(auto& row, int j, const Weights& weights) {
  using Scalar = ScalarOf<S>;
  using Plain = PlainState<S>;
  const auto at = [](int l) { return static_cast<std::size_t>(l); };
  Plain& newest = row[at(j)];
  for (int l = 1; l < j; ++l)
    for_each_block(
        [by = weights[at(l)]](auto, auto& last, auto& old) {
          for (Index i = 0; i < last.size(); ++i) {
            const Scalar x = last.data()[i], next = x + by * (x - old.data()[i]);
            old.data()[i] = x;
            last.data()[i] = next;
          }
        },
        Blocks<S>::all(newest), Blocks<S>::all(row[at(l)]));
}

}}  // namespace phistep::PHISTEP_ABI

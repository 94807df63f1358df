/// @file
/// What an extrapolated step knows of the solution between its ends (Hairer & Wanner, Solving ODEs II, sect. IV.9; E.
/// Hairer & A. Ostermann, Numer. Math. 58 (1990) 419). The last increments of each row give backward differences, whose
/// error has an expansion in h, too: extrapolated, they are the derivatives at the end of the step,
///
///     Δt^κ y^(κ)(t+Δt) ≈ R_κ,   from   n_j^κ ∇^{κ−1} δ_{n_j},   j = κ … k                                       (1)
///
/// With s = 1 − x, the polynomial of degree k that has them, and both ends, is
///
///     y(t + xΔt) = y⁺ + Σ_{κ<k} R_κ (−s)^κ/κ! + c s^k,     c from y(t)                                          (2)
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <type_traits>
#include <vector>

#include "phistep/core/version.hpp"
#include "phistep/state/blocks.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

template <State S, int columns>
class ExtrapolatedInside {
 public:
  using Scalar = ScalarOf<S>;
  using Plain = PlainState<S>;

  ExtrapolatedInside() = default;
  // What it holds is of one step, looked at before the next: a copied or moved stepper has none, and need not carry it.
  ExtrapolatedInside(const ExtrapolatedInside&) {}
  ExtrapolatedInside& operator=(const ExtrapolatedInside&) {
    degree_ = 0;
    return *this;
  }
  ~ExtrapolatedInside() = default;

  /// Room for the last j increments of row j. The first call of a state of dynamic size allocates.
  void begin(const Plain& y) {
    if constexpr (dynamic)
      if (increments_.empty() || !same_shape<S>(increments_[0], y)) {
        increments_.assign(count, y);
        scaled_.assign(at(columns), y);
      }
  }
  void forget() { degree_ = 0; }
  /// Where row j puts its increments, the last one last.
  [[nodiscard]] Plain* row(int j) { return increments_.data() + first(j); }

  /// (1) for a step that ended in column k. Leaves the increments changed.
  void end(int k, const auto& substeps, const auto& weights) {
    degree_ = k;
    Scalar factorial{1};
    for (int kappa = 1; kappa < k; ++kappa) {
      factorial *= static_cast<Scalar>(-kappa);
      // The last of each row becomes its next difference: n^κ ∇^{κ−1}, one difference each time.
      for (int j = kappa; j <= k; ++j) {
        Plain* const d = row(j);
        const Scalar n = static_cast<Scalar>(substeps[at(j)]);
        for (int i = j - 1; i >= kappa - 1; --i)
          for_each_block(
              [n, kappa](auto, auto& to, const auto& before) {
                for (Index c = 0; c < to.size(); ++c)
                  to.data()[c] = n * (kappa == 1 ? to.data()[c] : to.data()[c] - before.data()[c]);
              },
              Blocks<S>::all(d[i]), Blocks<S>::all(std::as_const(d[i > 0 ? i - 1 : 0])));
      }
      // Neville over the rows, in a column of ends.
      std::array<Plain*, static_cast<std::size_t>(columns + 1)> end{};
      for (int j = kappa; j <= k; ++j) end[at(j)] = &extrapolated(j);
      for (int j = kappa; j <= k; ++j) copy_blocks<S>(*end[at(j)], row(j)[j - 1]);
      for (int l = 1; l <= k - kappa; ++l)
        for (int j = k; j >= kappa + l; --j)
          for_each_block(
              [by = weights[at(j)][at(l)]](auto, auto& to, const auto& before) {
                for (Index c = 0; c < to.size(); ++c) to.data()[c] += by * (to.data()[c] - before.data()[c]);
              },
              Blocks<S>::all(*end[at(j)]), Blocks<S>::all(std::as_const(*end[at(j - 1)])));
      for_each_block([by = 1 / factorial](auto, auto& to, const auto& from) { to = by * from; },
                     Blocks<S>::all(scaled_[at(kappa - 1)]), Blocks<S>::all(std::as_const(*end[at(k)])));
    }
  }

  /// e = c max_s s^k (1−s): how far (2) would be off without its last term. It is less than that with it.
  void error(const Plain& y0, const Plain& y1, Plain& e) const {
    const Scalar k = static_cast<Scalar>(degree_), share = std::pow(k / (k + 1), k) / (k + 1);
    for_each_block(
        [&](auto b, auto& to, const auto& from, const auto& end) {
          for (Index c = 0; c < to.size(); ++c) {
            Scalar last = from.data()[c] - end.data()[c];
            for (int i = 0; i + 1 < degree_; ++i) last -= std::get<b()>(Blocks<S>::all(scaled_[at(i)])).data()[c];
            to.data()[c] = share * last;
          }
        },
        Blocks<S>::all(e), Blocks<S>::all(y0), Blocks<S>::all(y1));
  }
  [[nodiscard]] int degree() const { return degree_; }

  /// (2)
  void interpolate(Scalar x, const Plain& y0, const Plain& y1, Plain& out) const {
    const Scalar s = 1 - x;
    for_each_block(
        [&](auto b, auto& to, const auto& from, const auto& end) {
          for (Index c = 0; c < to.size(); ++c) {
            Scalar all{0}, value{0};
            for (int i = degree_ - 2; i >= 0; --i) {
              const Scalar term = std::get<b()>(Blocks<S>::all(scaled_[at(i)])).data()[c];
              all += term;
              value = s * (value + term);
            }
            const Scalar last = from.data()[c] - end.data()[c] - all;
            Scalar power{1};
            for (int i = 0; i < degree_; ++i) power *= s;
            to.data()[c] = end.data()[c] + value + last * power;
          }
        },
        Blocks<S>::all(out), Blocks<S>::all(y0), Blocks<S>::all(y1));
  }

 private:
  static constexpr std::size_t at(int i) { return static_cast<std::size_t>(i); }
  static constexpr std::size_t first(int j) { return at(j * (j - 1) / 2); }
  static constexpr std::size_t count = at(columns * (columns + 1) / 2) + at(columns);
  static constexpr int size = static_size<decltype(Blocks<S>::all(std::declval<Plain&>()))>;
  static constexpr bool dynamic = size == Eigen::Dynamic || size > 64;
  [[nodiscard]] Plain& extrapolated(int j) { return increments_[at(columns * (columns + 1) / 2 + j - 1)]; }

  std::conditional_t<dynamic, std::vector<Plain>, std::array<Plain, count>> increments_{};
  std::conditional_t<dynamic, std::vector<Plain>, std::array<Plain, at(columns)>> scaled_{};  // R_κ (−1)^κ/κ!
  int degree_ = 0;
};

}}  // namespace phistep::PHISTEP_ABI

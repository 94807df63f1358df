/// @file
/// Particles on their way between the user's order and that of the rows (spring_rows.hpp), where the one leads all over
/// the other. The user's arrays are read and written in their own order: they come from memory. What is read and written here
/// and there is an array of whole particles, which is still in the caches.
#pragma once

#include <Eigen/Core>

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "phistep/base/machine/loop_hints.hpp"
#include "phistep/base/machine/shares.hpp"
#include "phistep/base/version.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// First positions, and velocities where damped, in the rows' order; then the sums of forces in place of them.
template <class Scalar, int dim, bool damped>
class SpringStage {
  using Slot = std::int32_t;

 public:
  /// Of one particle to the next: so many numbers lie within one line of the cache.
  static constexpr std::ptrdiff_t stride = std::bit_ceil(static_cast<unsigned>(dim * (damped ? 2 : 1)));

  SpringStage() = default;
  /// @param place_of  where each of the user's particles stands among the rows, −1: nowhere; empty: no stage is needed
  /// @param places    of rows
  SpringStage(std::vector<Slot> place_of, std::size_t places)
      : place_of_{std::move(place_of)},
        stage_{Numbers::Zero(place_of_.empty() ? 0 : stride * static_cast<Eigen::Index>(places))} {}

  [[nodiscard]] bool empty() const { return place_of_.empty(); }
  /// What the calling thread takes of the user's particles.
  [[nodiscard]] Share share() const { return own_share(place_of_.size()); }
  [[nodiscard]] const Scalar* r() const { return stage_.data(); }
  [[nodiscard]] const Scalar* v() const { return stage_.data() + dim; }
  [[nodiscard]] Scalar* sum(std::size_t place) { return stage_.data() + stride * static_cast<std::ptrdiff_t>(place); }

  void bring(const Share& share, const Scalar* r, const Scalar* v) {
    move(share, r, stage_.data());
    if constexpr (damped) move(share, v, stage_.data() + dim);
  }
  /// f += the sums
  void give(const Share& share, Scalar* f) const {
    for_each(share, stage_.data(), [&](const Scalar* sum, std::size_t i) {
      for (std::size_t a = 0; a < dim; ++a) f[dim * i + a] += sum[a];
    });
  }

 private:
  using Numbers = Eigen::Matrix<Scalar, Eigen::Dynamic, 1>;

  void move(const Share& share, const Scalar* from, Scalar* to) const {
    for_each(share, to, [&](Scalar* x, std::size_t i) {
      for (std::size_t a = 0; a < dim; ++a) x[a] = from[dim * i + a];
    });
  }
  /// f(place of particle i in the stage, i)
  void for_each(const Share& share, auto* stage, auto&& f) const {
    constexpr std::size_t ahead = 48;
    for (std::size_t i = share.begin; i < share.end; ++i) {
      if (const Slot later = place_of_[std::min(i + ahead, share.end - 1)]; later >= 0)
        prefetch(stage + stride * later);
      if (place_of_[i] >= 0) f(stage + stride * place_of_[i], i);
    }
  }

  std::vector<Slot> place_of_;
  Numbers stage_;
};

}}  // namespace phistep::PHISTEP_ABI

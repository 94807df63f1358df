/// @file
/// The region that particles live in: along each axis open or periodic. Walls are force terms (particles/walls/walls.hpp).
#pragma once

#include <Eigen/Core>

#include <array>
#include <cmath>
#include <stdexcept>

#include "phistep/base/version.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// Positions are never wrapped by the library: along a periodic axis they run on, and forces see the nearest images.
template <class Scalar, int dim>
struct Box {
  using Vector = Eigen::Matrix<Scalar, dim, 1>;

  Vector lower = Vector::Zero();        ///< [length], where the axis is periodic
  Vector upper = Vector::Zero();        ///< [length], likewise
  std::array<bool, dim> is_periodic{};  ///< an axis that isn't is open: nothing ends there

  [[nodiscard]] static Box open() { return {}; }
  /// Periodic along every axis.
  [[nodiscard]] static Box periodic(const Vector& lower, const Vector& upper) {
    Box box{lower, upper, {}};
    box.is_periodic.fill(true);
    return box;
  }
  [[nodiscard]] Vector length() const { return upper - lower; }
  [[nodiscard]] bool is_open() const {
    for (const bool periodic : is_periodic)
      if (periodic) return false;
    return true;
  }

  /// @throws std::invalid_argument unless every periodic axis has a length that is finite and > 0
  void check() const {
    for (int a = 0; a < dim; ++a)
      if (periodic_at(a) && !(std::isfinite(upper[a] - lower[a]) && upper[a] > lower[a]))
        throw std::invalid_argument(
            "phistep: a periodic box needs finite lower < upper, and a finite length, along axis " + std::to_string(a));
  }

  /// What to add to r to bring it between lower and upper [length].
  [[nodiscard]] Vector shift(const Vector& r) const {
    Vector by = Vector::Zero();
    for (int a = 0; a < dim; ++a) {
      if (!periodic_at(a)) continue;
      const Scalar size = upper[a] - lower[a];
      by[a] = -size * std::floor((r[a] - lower[a]) / size);
      // Rounding may put a position just below `lower` on `upper` itself.
      if (r[a] + by[a] >= upper[a]) by[a] -= size;
    }
    return by;
  }
  /// r between lower and upper [length].
  [[nodiscard]] Vector wrapped(const Vector& r) const { return r + shift(r); }
  /// The shortest of a difference's images [length].
  [[nodiscard]] Vector nearest(Vector d) const {
    for (int a = 0; a < dim; ++a) {
      if (!periodic_at(a)) continue;
      const Scalar size = upper[a] - lower[a];
      d[a] -= size * std::round(d[a] / size);
    }
    return d;
  }

  void archive(auto& ar) { ar("lower", lower, "upper", upper, "is_periodic", is_periodic); }
  friend bool operator==(const Box& a, const Box& b) {
    return a.lower == b.lower && a.upper == b.upper && a.is_periodic == b.is_periodic;
  }

 private:
  [[nodiscard]] bool periodic_at(int axis) const { return is_periodic[static_cast<std::size_t>(axis)]; }
};

}}  // namespace phistep::PHISTEP_ABI

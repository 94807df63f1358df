/// @file
/// Particles as a pair force sees them, and what it fills.
#pragma once

#include <phistep/particles.hpp>

#include <tuple>

namespace pair_view {

template <class Scalar, int dim>
auto view_of(const phistep::Particles<Scalar, dim>& y) {
  static const std::tuple<phistep::UnitMass> masses;
  return phistep::Particles<Scalar, dim>::view(y, masses);
}
template <class Scalar, int dim>
struct Out {
  Eigen::Matrix<Scalar, dim, Eigen::Dynamic> force;
};

}  // namespace pair_view

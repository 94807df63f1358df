/// @file
/// Particles as a pair force sees them, and what it fills.
#pragma once

#include <phistep/particles.hpp>

namespace pair_view {

template <class Scalar, int dim>
auto view_of(const phistep::Particles<Scalar, dim>& y) {
  return phistep::ParticleView<Scalar, dim, phistep::UnitMass>{y, phistep::UnitMass{}};
}
template <class Scalar, int dim>
struct Out {
  Eigen::Matrix<Scalar, dim, Eigen::Dynamic> force;
};

}  // namespace pair_view

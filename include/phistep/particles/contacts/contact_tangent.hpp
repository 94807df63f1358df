/// @file
/// Tangents of contacts for implicit beds, and how long an impact lasts.
///
/// With f = F_n the repulsion, c its damping, and the notation of contact_kernel.hpp, as PairTangent has it:
///
///     K = ∂F_n/∂δ nnᵀ − F_n/d (I − nnᵀ)                                                                          (1)
///     C = c nnᵀ + [sticks] (k_t τ + c_t) (I − nnᵀ),       c = 0 where F_n is held at its least                    (2)
///
/// What they leave out is not symmetric: sliding friction's dependence on F_n, and how springs and dashpots turn with n.
/// Newton then converges linearly, to the same solution.
#pragma once

#include <cmath>

#include "phistep/base/facts/structure.hpp"
#include "phistep/base/version.hpp"
#include "phistep/particles/contacts/contact_kernel.hpp"
#include "phistep/particles/contacts/contact_law.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// (1) and (2). @param slip  ξ after the evaluation at this state
template <class Law, class Scalar>
void contact_tangent(const ContactNumbers<Scalar>& c, const Triple<Scalar>& n, Scalar overlap, Scalar distance,
                     const Triple<Scalar>& v, const Triple<Scalar>& slip, Scalar w, Scalar rho, Scalar elapsed,
                     PairTangent<Scalar>& K, PairTangent<Scalar>& C) {
  const Scalar parting = dot(n, v);
  const auto law = Law::response(c, overlap, parting, w, rho);
  const bool pushes = !(law.normal < c.least);
  const Scalar normal = pushes ? law.normal : c.least;
  const Triple<Scalar> speed = v - parting * n;
  const Triple<Scalar> friction = law.tangential_stiffness * slip + law.tangential_damping * speed;
  const Scalar most = c.friction * std::abs(normal);
  const bool sticks = dot(friction, friction) < most * most * (1 - 1e-6);
  K.along = pushes ? Law::spring(c, overlap, rho).second : Scalar{0};
  K.across = distance > 0 ? -normal / distance : Scalar{0};
  if (pushes)
    C.along = Law::response(c, overlap, Scalar{0}, w, rho).normal - Law::response(c, overlap, Scalar{1}, w, rho).normal;
  if (sticks) C.across = law.tangential_stiffness * elapsed + law.tangential_damping;
}

/// [time] of the shortest impact among bodies of these materials at the speeds that they have; 0 where none is known.
/// @param share  m*/m and R*/R of the partner that makes it shortest: ½ for equals, 1 for a wall
template <class Law>
[[nodiscard]] double shortest_impact(const Materials<Law>& materials, const auto& y, double share) {
  if (y.r.cols() == 0 || y.body.radius.size() != y.r.cols()) return 0;
  const auto mass = share * static_cast<double>(y.body.mass.minCoeff());
  const auto radius = share * static_cast<double>(y.body.radius.maxCoeff());
  const double speed = (share < 1 ? 2.0 : 1.0) * static_cast<double>(std::sqrt(y.v.colwise().squaredNorm().maxCoeff()));
  double shortest = 0;
  materials.for_each([&](const ContactNumbers<double>& c) {
    const double time = Law::impact(c, mass, radius, speed);
    if (time > 0 && std::isfinite(time) && (shortest == 0 || time < shortest)) shortest = time;
  });
  return shortest;
}

}}  // namespace phistep::PHISTEP_ABI

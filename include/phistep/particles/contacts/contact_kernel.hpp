/// @file
/// The force between two bodies that overlap, several contacts at once: damped normal spring (contact_law.hpp), tangential
/// spring with Coulomb friction, rolling spring with rolling friction.
///
/// n points from j to i, v = v_i − v_j, l_i = s R_i and l_j = s R_j are the arms to the point of contact, τ the time since
/// the springs' lengths ξ₀ (tangential) and ψ₀ (rolling) were known:
///
///     v_n = n·v                                    speed of parting
///     v_t = v − v_n n − (l_i ω_i + l_j ω_j) × n    slip
///     ξ   = (I − nnᵀ)(ξ₀ + τ v_t)                                                                                (1)
///     F_t = −(k_t ξ + c_t v_t), shortened to |F_t| ≤ μ|F_n|; then k_t ξ = −(F_t + c_t v_t)                       (2)
///     F_i = F_n n + F_t = −F_j,   T_i = −l_i n × F_t,   T_j = −l_j n × F_t                                      (3)
///
/// (P. A. Cundall & O. D. L. Strack, Géotechnique 29 (1979) 47). Rolling likewise (S. Luding, Granular Matter 10 (2008)
/// 235), with v_r = −R* n × (ω_i − ω_j) in place of v_t, a force of rolling F_r with |F_r| ≤ μ_r |F_n|, and the torques
/// T_i = R* n × F_r = −T_j in place of (3).
#pragma once

#include <cmath>

#include "phistep/base/facts/structure.hpp"
#include "phistep/base/numbers/pack.hpp"
#include "phistep/base/numbers/pack_math.hpp"
#include "phistep/base/version.hpp"
#include "phistep/particles/contacts/contact_law.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// The same numbers in every lane.
template <class P>
[[nodiscard]] ContactNumbers<P> broadcast_numbers(const ContactNumbers<double>& c) {
  const auto all = [](double x) { return P(static_cast<typename ScalarIn<P>::type>(x)); };
  return {all(c.stiffness), all(c.damping),          all(c.tangential_stiffness), all(c.tangential_damping),
          all(c.friction),  all(c.rolling_friction), all(c.rolling_stiffness),    all(c.least)};
}
/// In lane l those of *of[l].
template <class P>
[[nodiscard]] ContactNumbers<P> lane_numbers(const ContactNumbers<double>* const (&of)[P::width]) {
  const auto all = [&](auto member) {
    return P::make([&](int l) { return static_cast<typename P::Scalar>(of[l]->*member); });
  };
  using N = ContactNumbers<double>;
  return {all(&N::stiffness), all(&N::damping),          all(&N::tangential_stiffness), all(&N::tangential_damping),
          all(&N::friction),  all(&N::rolling_friction), all(&N::rolling_stiffness),    all(&N::least)};
}

/// Three numbers or packs of them.
template <class P>
struct Triple {
  P x, y, z;
  [[nodiscard]] friend Triple operator+(const Triple& a, const Triple& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
  [[nodiscard]] friend Triple operator-(const Triple& a, const Triple& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
  [[nodiscard]] friend Triple operator*(const P& s, const Triple& a) { return {s * a.x, s * a.y, s * a.z}; }
  [[nodiscard]] friend P dot(const Triple& a, const Triple& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
  [[nodiscard]] friend Triple cross(const Triple& a, const Triple& b) {
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
  }
};

/// The geometry and velocities of a contact: what its law needs.
template <class P>
struct ContactPoint {
  Triple<P> n;          ///< unit, from j to i
  P overlap;            ///< δ > 0 [length]
  P arm;                ///< s
  Triple<P> v;          ///< v_i − v_j [length/time]
  Triple<P> u;          ///< R_i ω_i + R_j ω_j [length/time]
  P w;                  ///< 1/m_i + 1/m_j
  P rho;                ///< 1/R_i + 1/R_j
  Triple<P> turning{};  ///< ω_i − ω_j [1/time]; only where there is rolling friction
};

/// The lengths of a contact's springs.
template <class P>
struct ContactSprings {
  Triple<P> slip, roll;  ///< ξ, ψ [length]
};

template <class P>
struct ContactForce {
  Triple<P> force;   ///< on i; −force on j
  Triple<P> twist;   ///< R_i·twist is i's torque, R_j·twist is j's
  Triple<P> torque;  ///< of rolling, on i; −torque on j
};

/// Energy of a contact's springs [energy].
template <class Law, class Scalar>
[[nodiscard]] Scalar stored_energy(const ContactNumbers<Scalar>& c, Scalar overlap, Scalar rho,
                                   const ContactSprings<Scalar>& springs) {
  const Scalar across = Law::response(c, overlap, Scalar{0}, Scalar{1}, rho).tangential_stiffness;
  return Law::spring(c, overlap, rho).first +
         (across * dot(springs.slip, springs.slip) + c.rolling_stiffness * dot(springs.roll, springs.roll)) / 2;
}

/// (2): a spring and dashpot that slide at the force `most`.
template <class P>
[[nodiscard]] Triple<P> sliding_force(Triple<P>& spring, const Triple<P>& v, P stiffness, P damping, P most) {
  using std::sqrt;
  const Triple<P> wanted = stiffness * spring + damping * v;
  const P square = dot(wanted, wanted);
  const auto slides = square > most * most;
  const P fraction = select(slides, most / sqrt(select(slides, square, P(1))), P(1));
  const Triple<P> force = fraction * wanted;
  const auto reduced = [&](P x, P f, P speed) {
    return select(stiffness > P(0),
                  select(slides, (f - damping * speed) / select(stiffness > P(0), stiffness, P(1)), x), P(0));
  };
  spring = {reduced(spring.x, force.x, v.x), reduced(spring.y, force.y, v.y), reduced(spring.z, force.z, v.z)};
  return P(-1) * force;
}

/// @param tau      [time] since `springs` were known; they are brought up to date
/// @tparam spins   the particles have angular velocities
/// @tparam rolls   some material has rolling friction
template <bool spins, bool rolls, class Law, class P>
[[nodiscard]] ContactForce<P> contact_force(const ContactNumbers<P>& c, const ContactPoint<P>& at, P tau,
                                            ContactSprings<P>& springs) {
  using std::abs;
  const P parting = dot(at.n, at.v);
  ContactResponse<P> law = Law::response(c, at.overlap, parting, at.w, at.rho);
  law.normal = select(law.normal < c.least, c.least, law.normal);
  const P size = abs(law.normal);

  Triple<P> slip = at.v - parting * at.n;
  if constexpr (spins) slip = slip - cross(at.arm * at.u, at.n);
  Triple<P>& xi = springs.slip;
  xi = xi + tau * slip;
  xi = xi - dot(xi, at.n) * at.n;
  const Triple<P> friction =
      sliding_force(xi, slip, law.tangential_stiffness, law.tangential_damping, c.friction * size);

  ContactForce<P> out{law.normal * at.n + friction, {}, {}};
  if constexpr (spins) out.twist = (-at.arm) * cross(at.n, friction);
  if constexpr (spins && rolls) {
    const P radius = P(1) / at.rho;
    const Triple<P> rolling = (-radius) * cross(at.n, at.turning);
    Triple<P>& psi = springs.roll;
    psi = psi + tau * rolling;
    psi = psi - dot(psi, at.n) * at.n;
    const Triple<P> resistance =
        sliding_force(psi, rolling, c.rolling_stiffness, law.tangential_damping, c.rolling_friction * size);
    out.torque = radius * cross(at.n, resistance);
  }
  return out;
}

// Tangents of contacts for implicit beds, and how long an impact lasts.
//
// With f = F_n the repulsion, c its damping, and the notation of contact_kernel.hpp, as PairTangent has it:
//
//     K = ∂F_n/∂δ nnᵀ − F_n/d (I − nnᵀ)                                                                          (1)
//     C = c nnᵀ + [sticks] (k_t τ + c_t) (I − nnᵀ),       c = 0 where F_n is held at its least                    (2)
//
// What they leave out is not symmetric: sliding friction's dependence on F_n, and how springs and dashpots turn with n.
// Newton then converges linearly, to the same solution.

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

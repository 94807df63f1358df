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
///     F_t = −(k_t ξ + c_t v_t), |F_t| ≤ μ|F_n|;   before, |k_t ξ| ≤ μ|F_n|                                       (2)
///     F_i = F_n n + F_t = −F_j,   T_i = −l_i n × F_t,   T_j = −l_j n × F_t                                      (3)
///
/// (P. A. Cundall & O. D. L. Strack, Géotechnique 29 (1979) 47). In (2) both are shortened where they are too long: the spring
/// by itself first, so that it never holds more than friction can load it with, and no dashpot winds it. (GranHooke, as LAMMPS:
/// after F_t was shortened, k_t ξ = −(F_t + c_t v_t).) Where k_t = κ a grows with the overlap, ξ₀ is shortened so that the spring's force
/// stays, where it falls, ξ₀ stays (C. Thornton, S. J. Cummins & P. W. Cleary, Powder Technol. 233 (2013) 30; LAMMPS'
/// mindlin_rescale/force): either way its energy ½k_tξ² doesn't grow but by work. Rolling likewise (S. Luding, Granular Matter 10 (2008)
/// 235), with v_r = −R* n × (ω_i − ω_j) in place of v_t, a force of rolling F_r with |F_r| ≤ μ_r |F_n|, and the torques
/// T_i = R* n × F_r = −T_j in place of (3).
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>

#include "phistep/base/facts/structure.hpp"
#include "phistep/base/machine/loop_hints.hpp"
#include "phistep/base/numbers/pack.hpp"
#include "phistep/base/numbers/pack_math.hpp"
#include "phistep/particles/contacts/contact_law.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// In lane l the numbers of(l), a struct of nothing but them.
template <template <class> class Struct, class P, class Number>
[[nodiscard]] Struct<P> in_lanes(auto&& of) {
  constexpr std::size_t count = sizeof(Struct<Number>) / sizeof(Number);
  const Struct<Number>* lane[P::width];
  for (int l = 0; l < P::width; ++l) lane[l] = &of(l);
  std::array<P, count> all;
  unrolled<count>([&](auto k) {
    all[k] = P::make(
        [&](int l) { return static_cast<typename P::Scalar>(std::bit_cast<std::array<Number, count>>(*lane[l])[k]); });
  });
  return std::bit_cast<Struct<P>>(all);
}
/// The same numbers in a run's.
template <class Scalar>
[[nodiscard]] ContactNumbers<Scalar> numbers_in(const ContactNumbers<double>& c) {
  const auto of = [&c](int) -> const auto& { return c; };
  return std::bit_cast<ContactNumbers<Scalar>>(in_lanes<ContactNumbers, Pack<Scalar, 1>, double>(of));
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
  P grip{0};             ///< a when these were known, of a law that stiffens [length]
};

template <class P>
struct ContactForce {
  Triple<P> force;   ///< on i; −force on j
  Triple<P> twist;   ///< R_i·twist is i's torque, R_j·twist is j's
  Triple<P> torque;  ///< of rolling, on i; −torque on j
};

/// Energy of a contact's springs [energy].
template <class Law, class Scalar>
[[nodiscard]] Scalar stored_energy(const ContactNumbers<Scalar>& c, const ContactPoint<Scalar>& at,
                                   const ContactSprings<Scalar>& springs) {
  const auto law = Law::response(c, at.overlap, Scalar{0}, Scalar{1}, at.rho);
  const Scalar slip = law.tangential_stiffness * dot(springs.slip, springs.slip),
               roll = c.rolling_stiffness * law.grip * dot(springs.roll, springs.roll);
  return Law::spring(c, at.overlap, at.rho).first + (slip + roll) / 2;
}

/// 1, or where x is longer than `most`, by how much it is to be shortened.
template <class P>
[[nodiscard]] P shortening(const Triple<P>& x, P most) {
  using std::sqrt;
  const P square = dot(x, x);
  const auto is_long = square > most * most;
  return select(is_long, most / sqrt(select(is_long, square, P(1))), P(1));
}
/// (2): a spring and dashpot that slide at the force `most`.
/// @tparam winds  the dashpot winds the spring back
template <bool winds, class P>
[[nodiscard]] Triple<P> sliding_force(Triple<P>& spring, const Triple<P>& v, P stiffness, P damping, P most) {
  if constexpr (!winds) spring = select(stiffness > P(0), shortening(stiffness * spring, most), P(0)) * spring;
  const Triple<P> wanted = stiffness * spring + damping * v;
  const P fraction = shortening(wanted, most);
  if constexpr (winds) {
    const auto reduced = [&](P x, P f, P speed) {
      const P held = (fraction * f - damping * speed) / select(stiffness > P(0), stiffness, P(1));
      return select(stiffness > P(0), select(fraction < P(1), held, x), P(0));
    };
    spring = {reduced(spring.x, wanted.x, v.x), reduced(spring.y, wanted.y, v.y), reduced(spring.z, wanted.z, v.z)};
  }
  return (-fraction) * wanted;
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
  P kept = P(1);
  if constexpr (stiffens<Law>) {
    kept = select(springs.grip < law.grip, springs.grip / law.grip, P(1));
    springs.grip = law.grip;
  }
  Triple<P>& xi = springs.slip;
  xi = kept * xi + tau * slip;
  xi = xi - dot(xi, at.n) * at.n;
  const Triple<P> friction =
      sliding_force<has_full_arms<Law>>(xi, slip, law.tangential_stiffness, law.tangential_damping, c.friction * size);

  ContactForce<P> out{law.normal * at.n + friction, {}, {}};
  if constexpr (spins) out.twist = (-at.arm) * cross(at.n, friction);
  if constexpr (spins && rolls) {
    const P radius = P(1) / at.rho;
    const Triple<P> rolling = (-radius) * cross(at.n, at.turning);
    Triple<P>& psi = springs.roll;
    psi = kept * psi + tau * rolling;
    psi = psi - dot(psi, at.n) * at.n;
    const Triple<P> resistance = sliding_force<has_full_arms<Law>>(psi, rolling, c.rolling_stiffness * law.grip,
                                                                   law.tangential_damping, c.rolling_friction * size);
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

/// K and C by (1) and (2).
/// @param distance  d
/// @param slip      ξ after the evaluation at this state
template <class Law, class Scalar>
[[nodiscard]] std::array<PairTangent<Scalar>, 2> contact_tangents(const ContactNumbers<Scalar>& c,
                                                                  const ContactPoint<Scalar>& at, Scalar distance,
                                                                  const Triple<Scalar>& slip, Scalar tau) {
  const auto law_at = [&](Scalar parting) { return Law::response(c, at.overlap, parting, at.w, at.rho); };
  const Scalar parting = dot(at.n, at.v);
  const auto law = law_at(parting);
  const bool pushes = !(law.normal < c.least);
  const Scalar normal = pushes ? law.normal : c.least;
  const Triple<Scalar> friction = law.tangential_stiffness * slip + law.tangential_damping * (at.v - parting * at.n);
  const Scalar most = c.friction * std::abs(normal);
  PairTangent<Scalar> K, C;
  K.across = distance > 0 ? -normal / distance : Scalar{0};
  if (pushes) {
    K.along = Law::spring(c, at.overlap, at.rho).second;
    C.along = law_at(Scalar{0}).normal - law_at(Scalar{1}).normal;
  }
  const bool sticks = dot(friction, friction) < most * most * (1 - 1e-6);
  if (sticks) C.across = law.tangential_stiffness * tau + law.tangential_damping;
  return {K, C};
}

/// What is known of impacts before they happen.
struct Impacts {
  double shortest = 0;  ///< [time] of one; 0 where none is known
  double deepest = 0;   ///< how far a body sinks in, over where it would come out on the other side
  bool lossless = false;
};
/// Of bodies of these materials at the speeds that they have.
/// @param share     m*/m and R*/R of a partner: ½ for equals, 1 for a wall
/// @param thinnest  [length] where the thinnest of what is hit has its other side
template <class Law>
[[nodiscard]] Impacts impacts_of(const Materials<Law>& materials, const auto& y, double share, double thinnest) {
  Impacts all;
  if (y.r.cols() == 0 || y.body.radius.size() != y.r.cols()) return all;
  const auto &mass = y.body.mass, &radius = y.body.radius;
  const auto of = [share](auto x) { return share * static_cast<double>(x); };
  const double speed = (share < 1 ? 2.0 : 1.0) * static_cast<double>(std::sqrt(y.v.colwise().squaredNorm().maxCoeff()));
  materials.for_each([&](const ContactNumbers<double>& c) {
    const double time = Law::impact(c, of(mass.minCoeff()), of(radius.maxCoeff()), speed);
    if (time > 0 && std::isfinite(time) && (all.shortest == 0 || time < all.shortest)) all.shortest = time;
    // An impact lasts π δ/v of the largest overlap, or 2.94 δ/v by Hertz.
    const double longest = Law::impact(c, of(mass.maxCoeff()), of(radius.minCoeff()), speed);
    all.deepest = std::max(all.deepest, speed * longest / 2.94 / thinnest);
    all.lossless = all.lossless || c.damping == 0;
  });
  return all;
}

}}  // namespace phistep::PHISTEP_ABI

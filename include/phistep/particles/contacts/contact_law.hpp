/// @file
/// What two bodies that overlap do to each other along the line between them, and how stiff they are across it.
///
/// With δ > 0 the overlap, v_n the speed of parting, m* = 1/(1/m_i + 1/m_j), R* = 1/(1/R_i + 1/R_j), a = √(R* δ):
///
///     Hooke      F_n = k δ − c v_n,            c = 2β √(m* k),                    k_t = κ k                      (1)
///     Hertz      F_n = (4/3) E* a δ − c v_n,   c = √5 β √(m* (4/3) E* a),         k_t = 8 G* a  (Mindlin)         (2)
///     GranHooke  F_n = k_n δ − γ_n m* v_n                                         k_t                            (3)
///
/// β follows from the coefficient of restitution e. Where the contact lasts until δ = 0, and so pulls at its end,
///     e = exp(−πβ/√(1−β²)),                                                                                      (4)
/// where it ends with its repulsion, F_n ≥ 0 (T. Schwager & T. Pöschel, Granular Matter 9 (2007) 465),
///     e = exp(−β θ/√(1−β²)),   θ = arg(2β² − 1 + 2iβ√(1−β²)).                                                    (5)
/// Both hold for (1) and for (2): with z = δ^(5/4) and dτ = δ^(1/4) dt, (2) is m* z'' + c̃ z' + (5/4) k̃ z = 0, whose z' is
/// (5/4) δ̇ and whose z'' vanishes with F_n. (4) for Hertz: T. Antypov & J. A. Elliott, EPL 94 (2011) 50004.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numbers>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "phistep/base/version.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// β, the ratio of a contact's damping to the critical one, for a coefficient of restitution e: the inverse of (4) or (5).
/// @throws std::invalid_argument unless 0 < e ≤ 1
template <class = void>
[[nodiscard]] double damping_ratio(double e, bool attracts) {
  if (!(e > 0) || !(e <= 1)) throw std::invalid_argument("phistep: a coefficient of restitution must be > 0 and <= 1");
  const double loss = -std::log(e);
  if (attracts) return loss / std::hypot(std::numbers::pi, loss);
  const auto loss_of = [](double beta) {
    const double square = 1 - beta * beta, root = std::sqrt(std::abs(square));
    if (root < 1e-4) return 2 * beta;  // both branches tend to 2 at β = 1, with an error of order root²
    if (square > 0) return beta * std::atan2(2 * beta * root, 2 * beta * beta - 1) / root;
    return 2 * beta * std::log(beta + root) / root;
  };
  double low = 0, high = 1;
  while (loss_of(high) < loss && high < 1e150) high *= 2;
  for (int i = 0; i < 200; ++i) {
    const double middle = low + (high - low) / 2;
    (loss_of(middle) < loss ? low : high) = middle;
  }
  return loss == 0 ? 0 : high;
}

/// The numbers that the laws work with, for one pair of materials.
template <class T>
struct ContactNumbers {
  T stiffness, damping;  ///< along the normal
  T tangential_stiffness, tangential_damping;
  T friction;                             ///< Coulomb's μ
  T rolling_friction, rolling_stiffness;  ///< see contact_kernel.hpp
  T least;                                ///< F_n ≥ this: 0, or −∞ where the contact may pull
};

/// The answer of a law for one contact.
template <class T>
struct ContactResponse {
  T normal;                ///< F_n [force]
  T tangential_stiffness;  ///< [force/length]
  T tangential_damping;    ///< [force·time/length]
  T grip{1};  ///< what both stiffnesses across the normal are proportional to, of a law that `stiffens`: a [length]
};
/// A law whose springs across the normal stiffen as the overlap grows.
template <class Law>
inline constexpr bool stiffens = false;

/// With the least normal force of a contact that may pull, or not.
/// @param names  of the normal and the tangential stiffness in messages
/// @throws std::invalid_argument unless all are finite and >= 0, the stiffness > 0
template <class = void>
[[nodiscard]] ContactNumbers<double> checked_numbers(ContactNumbers<double> c, std::array<const char*, 2> names,
                                                     bool attracts) {
  const auto check = [](double x, const char* name, bool positive = false) {
    if (!std::isfinite(x) || x < 0 || (positive && x == 0))
      throw std::invalid_argument(std::string("phistep: a contact's ") + name + " must be finite and " +
                                  (positive ? "> 0" : ">= 0"));
  };
  check(c.stiffness, names[0], true), check(c.damping, "damping"), check(c.tangential_stiffness, names[1]);
  check(c.tangential_damping, "tangential damping"), check(c.friction, "friction");
  check(c.rolling_friction, "rolling friction"), check(c.rolling_stiffness, "rolling stiffness");
  if (attracts) c.least = -std::numeric_limits<double>::infinity();
  return c;
}

/// (1): a linear spring and dashpot.
struct Hooke {
  double stiffness;                      ///< k [force/length]
  double restitution = 1;                ///< e, 0 < e ≤ 1
  double friction = 0;                   ///< μ
  double tangential_stiffness = 2. / 7;  ///< κ = k_t/k
  double tangential_damping = 0.5;       ///< c_t/c
  double rolling_friction = 0;           ///< μ_r: the largest rolling torque is μ_r R* F_n
  double rolling_stiffness = 2. / 7;     ///< k_r/k
  bool attracts = false;                 ///< the dashpot may pull at the end of a contact

  [[nodiscard]] ContactNumbers<double> numbers() const {
    return checked_numbers({stiffness, 2 * damping_ratio(restitution, attracts), stiffness * tangential_stiffness,
                            tangential_damping, friction, rolling_friction, stiffness * rolling_stiffness, 0},
                           {"stiffness", "tangential stiffness"}, attracts);
  }
  /// @param w  1/m*
  template <class P>
  [[nodiscard]] static ContactResponse<P> response(const ContactNumbers<P>& c, P overlap, P parting, P w, P /*rho*/) {
    using std::sqrt;
    const P damping = c.damping * sqrt(c.stiffness / w);
    return {c.stiffness * overlap - damping * parting, c.tangential_stiffness, c.tangential_damping * damping};
  }
  /// Elastic energy of the normal spring, and its stiffness ∂F_n/∂δ.
  template <class T>
  [[nodiscard]] static std::pair<T, T> spring(const ContactNumbers<T>& c, T overlap, T /*rho*/) {
    return {c.stiffness * overlap * overlap / 2, c.stiffness};
  }
  /// [time] that an undamped impact lasts, at that speed.
  [[nodiscard]] static double impact(const ContactNumbers<double>& c, double mass, double /*radius*/,
                                     double /*speed*/) {
    return std::numbers::pi * std::sqrt(mass / c.stiffness);
  }
};

/// (2): elastic spheres (Hertz), Mindlin's tangential stiffness, and damping that makes e independent of the speed of
/// impact.
struct Hertz {
  double modulus;                     ///< E* = E/(2(1−ν²)) between equals [force/length²]
  double shear_modulus = 0;           ///< G* = G/(2(2−ν)) between equals [force/length²]
  double restitution = 1;             ///< e, 0 < e ≤ 1
  double friction = 0;                ///< μ
  double tangential_damping = 0.5;    ///< c_t/c
  double rolling_friction = 0;        ///< μ_r: the largest rolling torque is μ_r R* F_n
  double rolling_stiffness = 2. / 7;  ///< k_r/k, k = F_n/δ = (4/3) E* a at rest
  bool attracts = false;              ///< the dashpot may pull at the end of a contact

  /// Two bodies of one material, of Young's modulus [force/length²] and Poisson's ratio.
  [[nodiscard]] static Hertz elastic(double young, double poisson) {
    if (!(poisson > -1) || !(poisson <= 0.5))
      throw std::invalid_argument("phistep: Poisson's ratio must be > -1 and <= 0.5");
    Hertz law{};
    law.modulus = young / (2 * (1 - poisson * poisson));
    law.shear_modulus = young / (4 * (2 - poisson) * (1 + poisson));
    return law;
  }
  /// The law for contacts of this material with another: the moduli of the pair, all other numbers as in *this.
  [[nodiscard]] Hertz against(const Hertz& other) const {
    Hertz law = *this;
    law.modulus = 2 * modulus * other.modulus / (modulus + other.modulus);
    const double sum = shear_modulus + other.shear_modulus;
    law.shear_modulus = sum > 0 ? 2 * shear_modulus * other.shear_modulus / sum : 0;
    return law;
  }

  [[nodiscard]] ContactNumbers<double> numbers() const {
    const double k = 4 * modulus / 3;
    return checked_numbers({k, std::sqrt(5.0) * damping_ratio(restitution, attracts), 8 * shear_modulus,
                            tangential_damping, friction, rolling_friction, k * rolling_stiffness, 0},
                           {"modulus", "shear modulus"}, attracts);
  }
  template <class P>
  [[nodiscard]] static ContactResponse<P> response(const ContactNumbers<P>& c, P overlap, P parting, P w, P rho) {
    using std::sqrt;
    const P a = sqrt(overlap / rho), k = c.stiffness * a, damping = c.damping * sqrt(k / w);
    return {k * overlap - damping * parting, c.tangential_stiffness * a, c.tangential_damping * damping, a};
  }
  template <class T>
  [[nodiscard]] static std::pair<T, T> spring(const ContactNumbers<T>& c, T overlap, T rho) {
    using std::sqrt;
    const T k = c.stiffness * sqrt(overlap / rho);
    return {2 * k * overlap * overlap / 5, 3 * k / 2};
  }
  /// [time] that an undamped impact lasts, at that speed: 2.943 δ/v with the largest δ = (5 m*v²/(4 k √R*))^(2/5)
  /// (L. D. Landau & E. M. Lifshitz, Theory of Elasticity, sect. 9).
  [[nodiscard]] static double impact(const ContactNumbers<double>& c, double mass, double radius, double speed) {
    if (!(speed > 0)) return 0;
    return 2.9432750 * std::pow(1.25 * mass * speed * speed / (c.stiffness * std::sqrt(radius)), 0.4) / speed;
  }
};

template <>
inline constexpr bool stiffens<Hertz> = true;

/// LAMMPS' pair style gran/hooke/history to the letter, (3): damping proportional to m*, a contact that may pull, torques
/// on the arms R_i and R_j. The sum of torques then differs from that of the forces by δ F_t; the laws above use arms
/// that meet between the two bodies, and keep the angular momentum.
struct GranHooke {
  double stiffness;             ///< k_n [force/length]
  double tangential_stiffness;  ///< k_t [force/length]
  double damping;               ///< γ_n [1/time]
  double tangential_damping;    ///< γ_t [1/time]; 0 for dampflag = 0
  double friction;              ///< x_μ
  bool attracts = true;         ///< false: limit_damping

  [[nodiscard]] ContactNumbers<double> numbers() const {
    return checked_numbers({stiffness, damping, tangential_stiffness, tangential_damping, friction, 0, 0, 0},
                           {"stiffness", "tangential stiffness"}, attracts);
  }
  template <class P>
  [[nodiscard]] static ContactResponse<P> response(const ContactNumbers<P>& c, P overlap, P parting, P w, P /*rho*/) {
    const P mass = 1 / w;
    return {c.stiffness * overlap - c.damping * mass * parting, c.tangential_stiffness, c.tangential_damping * mass};
  }
  template <class T>
  [[nodiscard]] static std::pair<T, T> spring(const ContactNumbers<T>& c, T overlap, T rho) {
    return Hooke::spring(c, overlap, rho);
  }
  [[nodiscard]] static double impact(const ContactNumbers<double>& c, double mass, double radius, double speed) {
    return Hooke::impact(c, mass, radius, speed);
  }
};
/// Whether torques act on the whole radii R_i and R_j, not up to a common point, and a sliding dashpot changes its spring.
template <class Law>
inline constexpr bool has_full_arms = false;
template <>
inline constexpr bool has_full_arms<GranHooke> = true;

/// A law for every pair of types, the same until set otherwise:
///
///     Materials materials{3, Hooke{.stiffness = 1e5, .restitution = 0.9}};
///     materials.set(0, 2, Hooke{…});
template <class Law>
class Materials {
 public:
  /// One for all.
  Materials(const Law& law) : table_{law.numbers()} {}  // NOLINT(google-explicit-constructor): a law is a table of one
  /// @param types  their number; a particle's type is then less
  Materials(int types, const Law& law) : types_{types}, table_(checked_size(types), law.numbers()) {}

  /// Between types a and b, in either order.
  Materials& set(int a, int b, const Law& law) {
    if (a < 0 || b < 0 || a >= types_ || b >= types_)
      throw std::invalid_argument("phistep: no pair of types: " + std::to_string(a) + " and " + std::to_string(b) +
                                  " of " + std::to_string(types_));
    table_[index(a, b)] = table_[index(b, a)] = law.numbers();
    return *this;
  }
  /// 0: one law for all particles, whatever their types.
  [[nodiscard]] int types() const { return types_; }
  [[nodiscard]] const ContactNumbers<double>& operator()(int a, int b) const {
    return table_[types_ == 0 ? 0 : index(a, b)];
  }
  void for_each(auto&& f) const {
    for (const auto& numbers : table_) f(numbers);
  }
  [[nodiscard]] bool rolls() const {
    return std::any_of(table_.begin(), table_.end(), [](const auto& c) { return c.rolling_friction > 0; });
  }
  [[nodiscard]] bool has(int type) const { return types_ == 0 || (0 <= type && type < types_); }
  /// @throws std::invalid_argument that names the particle whose type isn't in the table
  void check_types(const auto& body) const {
    for (std::ptrdiff_t i = 0; i < body.size(); ++i)
      if (!has(body.type_of(i)))
        throw std::invalid_argument("phistep: particle " + std::to_string(i) + " is of type " +
                                    std::to_string(body.type_of(i)) + ", the table of materials has " +
                                    std::to_string(types_));
  }

 private:
  [[nodiscard]] static std::size_t checked_size(int types) {
    if (types < 1 || types > 1000) throw std::invalid_argument("phistep: a table of materials needs 1 to 1000 types");
    return static_cast<std::size_t>(types) * static_cast<std::size_t>(types);
  }
  [[nodiscard]] std::size_t index(int a, int b) const { return static_cast<std::size_t>(a * types_ + b); }

  int types_ = 0;
  std::vector<ContactNumbers<double>> table_;
};

}}  // namespace phistep::PHISTEP_ABI

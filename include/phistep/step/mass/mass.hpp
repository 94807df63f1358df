/// @file
/// M in m v' = Ψ and M y' = Ψ: unit, scalar, per component or a matrix. What isn't there costs nothing.
///
/// The user writes mass(x) or capacity(x); the stepper binds it to its state: checked, in the state's scalar, expanded
/// to one value a component.
///
/// M of M y' = Ψ may be singular: a zero among diagonal masses, a matrix of lower rank. What stands for M⁻¹ is then G with
/// M G M = M (matrix_mass.hpp), and of a diagonal 1/m, 0 for m = 0. Which schemes can do with that they say.
#pragma once

#include <Eigen/Core>

#include <cmath>
#include <concepts>
#include <stdexcept>
#include <string>
#include <tuple>
#include <type_traits>
#include <utility>

#include "phistep/base/facts/structure.hpp"
#include "phistep/base/machine/shares.hpp"
#include "phistep/base/numbers/update.hpp"
#include "phistep/step/mass/matrix_mass.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// A mass bound to a block of components: a matrix, or a number for each.
template <class Mass, class Scalar>
concept BoundMass = requires(const Mass& M, Scalar h, Eigen::Matrix<Scalar, Eigen::Dynamic, 1>& x, Eigen::Index n) {
  { Mass::structure } -> std::convertible_to<Structure>;
  { M.h_over_mass(h)(n) } -> std::convertible_to<Scalar>;        // i ↦ h/m_i, for the explicit update; of a matrix h
  M.subtract_product(x, x);                                      // the second −= M times the first
  M.add_product([](Eigen::Index) { return Scalar{}; }, x);       // x += M times a function of the component
  M.for_each_entry(n, [](Eigen::Index, Eigen::Index, auto) {});  // f(i, j, M_ij) of the first n
  requires !Mass::is_matrix || requires { M.solve(x); };         // x ← M⁻¹ x
  requires Mass::is_matrix || requires {
    { M[n] } -> std::convertible_to<Scalar>;  // m_n
  };
};

/// A mass that may be singular.
template <class Mass>
concept MayBeSingular = requires(const Mass& M, Eigen::Matrix<double, Eigen::Dynamic, 1>& x) {
  { M.algebraic() } -> std::convertible_to<Eigen::Index>;  // a component that has none, −1: M is regular
  M.keep_unexplained(x);                                   // x ← x − M G x: the part outside the range of M
  M.keep_unseen(x);                                        // x ← x − G M x: what M doesn't see
};

/// f(i, j, M_ij) of the first n, to assemble M − γJ: what is held still is as heavy as subtract_product takes it.
void for_each_inertia(const auto& mass, Eigen::Index n, auto&& f) {
  if constexpr (requires { mass.for_each_inertia(n, f); }) mass.for_each_inertia(n, f);
  else mass.for_each_entry(n, f);
}

/// What masses with a number for each component do by it.
template <class Mass>
struct ComponentMass {
  static constexpr Structure structure = Structure::diagonal;
  static constexpr bool is_matrix = false;
  void for_each_entry(Eigen::Index n, auto&& f) const {
    for (Eigen::Index i = 0; i < n; ++i) f(i, i, self()[i]);
  }
  void add_product(auto&& x, auto& out) const {
    using Scalar = typename std::remove_cvref_t<decltype(out)>::Scalar;
    for_each_range(out.size(), 64, [&](Eigen::Index begin, Eigen::Index end) {
      for (Eigen::Index i = begin; i < end; ++i) out.data()[i] += static_cast<Scalar>(self()[i]) * x(i);
    });
  }

 private:
  [[nodiscard]] const Mass& self() const { return static_cast<const Mass&>(*this); }
};

/// M = 1: no divide, no multiply.
struct UnitMass : ComponentMass<UnitMass> {
  template <class Scalar, class Block>
  [[nodiscard]] UnitMass bind(const Block&) const {
    return {};
  }
  /// h times the inverse: i ↦ h/m_i
  template <class Scalar>
  [[nodiscard]] static UniformFactor<Scalar> h_over_mass(Scalar h) {
    return {h};
  }
  [[nodiscard]] int operator[](Eigen::Index) const { return 1; }
  static void subtract_product(const auto& x, auto&& out) { out -= x; }
};

template <class T>
[[nodiscard]] T checked_mass(T m, Eigen::Index number = -1) {
  if (!(m > T{0}) || !std::isfinite(m) || !std::isfinite(T{1} / m))
    throw std::invalid_argument("phistep: a mass must be finite and > 0, and so must one over it; " +
                                (number < 0 ? "it" : "number " + std::to_string(number)) + " is " +
                                std::to_string(static_cast<double>(m)));
  return m;
}

/// One mass for all components.
template <class T>
class ScalarMass : public ComponentMass<ScalarMass<T>> {
 public:
  /// @throws std::invalid_argument unless m is finite and > 0.
  explicit ScalarMass(T m) : mass_{checked_mass(m)} {}
  template <class Scalar, class Block>
  [[nodiscard]] ScalarMass<Scalar> bind(const Block&) const {
    return ScalarMass<Scalar>{static_cast<Scalar>(mass_)};
  }
  [[nodiscard]] UniformFactor<T> h_over_mass(T h) const { return {h / mass_}; }
  [[nodiscard]] T operator[](Eigen::Index) const { return mass_; }
  void subtract_product(const auto& x, auto&& out) const { out -= mass_ * x; }

 private:
  T mass_;
};

/// A mass a component, or a mass a column (a particle) of a matrix-shaped block. Components without mass, m = 0, are
/// algebraic.
/// @tparam size  how many, if that is known
template <class T, int size = Eigen::Dynamic>
class DiagonalMass : public ComponentMass<DiagonalMass<T, size>> {
  using Vector = Eigen::Matrix<T, size, 1>;

 public:
  /// @throws std::invalid_argument unless every mass is finite and > 0, or 0.
  explicit DiagonalMass(Vector masses) : mass_{std::move(masses)} {
    inverse_ = mass_.cwiseInverse();
    for (Eigen::Index i = 0; i < mass_.size(); ++i) {
      if (mass_[i] == 0) inverse_[i] = 0;
      else static_cast<void>(checked_mass(mass_[i], i));
    }
  }
  /// @throws std::invalid_argument where the number of masses is neither the block's size nor its number of columns.
  template <class Scalar, class Block>
  [[nodiscard]] DiagonalMass<Scalar> bind(const Block& block) const {
    Eigen::Matrix<Scalar, Eigen::Dynamic, 1> all(block.size());
    if (mass_.size() == block.size()) {
      all = mass_.template cast<Scalar>();
    } else if (!Block::IsVectorAtCompileTime && mass_.size() == block.cols()) {
      for (Eigen::Index i = 0; i < block.size(); ++i)
        all[i] = static_cast<Scalar>(mass_[Block::IsRowMajor ? i % block.cols() : i / block.rows()]);
    } else {
      throw std::invalid_argument("phistep: " + std::to_string(mass_.size()) + " masses for a block of " +
                                  std::to_string(block.rows()) + " x " + std::to_string(block.cols()));
    }
    return DiagonalMass<Scalar>{std::move(all)};
  }
  [[nodiscard]] ComponentFactor<T> h_over_mass(T h) const { return {h, {inverse_.data()}}; }
  [[nodiscard]] T operator[](Eigen::Index component) const { return mass_[component]; }
  [[nodiscard]] Eigen::Index algebraic() const {
    for (Eigen::Index i = 0; i < mass_.size(); ++i)
      if (mass_[i] == 0) return i;
    return -1;
  }
  void keep_unexplained(auto&& x) const {
    for (Eigen::Index i = 0; i < x.size(); ++i)
      if (mass_[i] != 0) x[i] = 0;
  }
  void keep_unseen(auto&& x) const { keep_unexplained(x); }
  /// The mass of one particle, whose dim components begin at `at`.
  template <int dim>
  [[nodiscard]] DiagonalMass<T, dim> particle(Eigen::Index at) const {
    return {mass_.template segment<dim>(at), inverse_.template segment<dim>(at)};
  }
  void subtract_product(const auto& x, auto&& out) const { out -= mass_.cwiseProduct(x); }

 private:
  template <class, int>
  friend class DiagonalMass;
  DiagonalMass(Vector mass, Vector inverse) : mass_{std::move(mass)}, inverse_{std::move(inverse)} {}

  Vector mass_, inverse_;
};

/// The masses of a state's solved blocks, as the user gave them.
template <class... M>
struct MassList {
  std::tuple<M...> masses;
};

/// Which kind of mass an argument of mass() is. Specialize it for a mass type of one's own.
template <class T>
struct MassKind {
  static_assert(!sizeof(T), "phistep: a mass is a number, an Eigen vector or a matrix (sparse: <phistep/sparse.hpp>)");
};
template <class T>
  requires std::is_arithmetic_v<T>
struct MassKind<T> {
  using type = ScalarMass<std::conditional_t<std::is_integral_v<T>, double, T>>;
  static type make(T m) { return type{static_cast<std::conditional_t<std::is_integral_v<T>, double, T>>(m)}; }
};
template <class T>
  requires std::is_base_of_v<Eigen::DenseBase<T>, T>
struct MassKind<T> {
  using type =
      std::conditional_t<T::IsVectorAtCompileTime, DiagonalMass<typename T::Scalar>, DenseMass<typename T::Scalar>>;
  static type make(const T& m) {
    if constexpr (T::IsVectorAtCompileTime) return type{m.reshaped()};
    else return type{m};
  }
};

/// The mass m of m v' = Ψ: a number, a vector (one a component, or one a particle of a 3×N state) or a matrix; one
/// argument per solved block where a state couples several. [mass]
/// @throws std::invalid_argument where a mass is not finite or is negative, a matrix not finite or not square. A stepper of a
/// motion throws at its construction unless a matrix is symmetric and positive definite. Zeros and singular matrices are for
/// M y' = Ψ under the schemes that take them: any other stepper throws, too.
template <class... M>
  requires(sizeof...(M) > 0)
[[nodiscard]] auto mass(const M&... masses) {
  return MassList<typename MassKind<M>::type...>{{MassKind<M>::make(masses)...}};
}

/// The same under its first-order name: the capacity M of M y' = Ψ, say ρc. Where it is singular, zeros on the diagonal or a
/// matrix of lower rank, this is a differential-algebraic equation (docs/first_order.md).
template <class... M>
  requires(sizeof...(M) > 0)
[[nodiscard]] auto capacity(const M&... capacities) { return mass(capacities...); }

/// M = 1 for every block.
struct UnitMasses {};

/// What a stepper takes as its mass.
template <class T>
inline constexpr bool is_mass_spec = false;
template <>
inline constexpr bool is_mass_spec<UnitMasses> = true;
template <class... M>
inline constexpr bool is_mass_spec<MassList<M...>> = true;
template <class T>
concept MassSpecification = is_mass_spec<T>;

}}  // namespace phistep::PHISTEP_ABI

/// @file
/// What is the same for every particle: a gravitational acceleration, a constant force.
#pragma once

#include <Eigen/Core>

#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>

#include "phistep/base/facts/structure.hpp"
#include "phistep/base/state/active_set.hpp"
#include "phistep/force/sum.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// A vector that is the same for every particle: with the d components of one particle's position, or as many as the whole state.
template <class Vector>
struct SameForAll : ForceTerm {
  static constexpr bool uses_velocity = false, uses_time = false;
  static constexpr bool is_affine = true, is_symmetric = true;
  static constexpr Structure structure = Structure::none;
  /// Not where the vector may be as long as the state.
  template <int dim>
  static constexpr bool is_particlewise =
      int{Vector::SizeAtCompileTime} > 0 && dim % int{Vector::SizeAtCompileTime} == 0;

  void add_jacobian(auto /*t*/, const auto& /*y*/, auto& /*sink*/) const {}

 protected:
  /// The vector's component for the i-th number of a block, in storage order. A matrix has one particle in each column; a flat
  /// vector has all coordinates of the first particle, then those of the second, and so on.
  template <class Block>
  [[nodiscard]] static auto component(const Vector& vector, Eigen::Index i, const Block& block) {
    const bool in_order = Block::IsVectorAtCompileTime || block.cols() == 1 || vector.size() == block.size();
    const Eigen::Index k = in_order ? i : Block::IsRowMajor ? i / block.cols() : i % block.rows();
    return static_cast<typename Block::Scalar>(vector[k % vector.size()]);
  }
  /// @throws std::invalid_argument where the vector's size is not the block's and doesn't divide that of a column
  template <class Block>
  static void check_size(const Vector& vector, const Block& block, const char* name) {
    const Eigen::Index column = Block::IsVectorAtCompileTime ? block.size() : block.rows();
    if (vector.size() == 0 || (column % vector.size() != 0 && block.size() != vector.size()))
      throw std::invalid_argument(std::string("phistep: ") + name + " has " + std::to_string(vector.size()) +
                                  " components, which does not fit a state of " + std::to_string(block.size()));
  }
};

/// The weight m g: an acceleration, and so not the same as UniformForce. For a flat vector of d-dimensional positions
/// (x₀ y₀ z₀ x₁ …) or a d×N matrix, g has d components.
template <class Vector = Eigen::Vector3d>
struct Gravity : SameForAll<Vector> {
  Vector g;  ///< [length/time²]

  static constexpr bool computes_active_only = true;

  /// @throws std::invalid_argument unless g is finite.
  explicit Gravity(Vector acceleration) : g(std::move(acceleration)) {
    if (!g.allFinite()) throw std::invalid_argument("phistep: Gravity's g must be finite");
  }

  void add(auto /*t*/, const auto& y, auto& out) const {
    static_assert(
        requires { out.force; }, "phistep: Gravity needs a motion, with forces");
    if constexpr (requires { out.force; }) {
      static_assert(
          requires { y.mass; }, "phistep: Gravity needs a state whose view has masses");
      this->check_size(g, out.force, "Gravity's g");
      if constexpr (requires { y.mass.active(); })
        if (const ActiveSet* active = y.mass.active()) {
          using Scalar = typename std::remove_cvref_t<decltype(out.force)>::Scalar;
          const Eigen::Index dim = out.force.rows();
          for (const Eigen::Index i : active->list())
            for (Eigen::Index k = dim * i; k < dim * (i + 1); ++k)
              out.force.data()[k] += y.mass[k] * static_cast<Scalar>(g[k % g.size()]);
          return;
        }
      y.mass.add_product([&](Eigen::Index i) { return this->component(g, i, out.force); }, out.force);
    }
  }
  /// −gᵀ M r [energy]
  [[nodiscard]] auto energy(auto /*t*/, const auto& y) const requires requires { y.r, y.mass; }
  {
    using Scalar = typename std::remove_cvref_t<decltype(y.r)>::Scalar;
    Scalar sum{0};
    y.mass.for_each_entry(y.r.size(), [&](Eigen::Index i, Eigen::Index j, auto m) {
      sum -= y.r.data()[i] * static_cast<Scalar>(m) * this->component(g, j, y.r);
    });
    return sum;
  }
};
template <class Derived>
Gravity(const Eigen::MatrixBase<Derived>&) -> Gravity<typename Derived::PlainObject>;

/// The force F on each particle, whatever its mass: a force, and so not the same as Gravity. F has the d components of
/// one particle's position, or as many as the whole state.
template <class Vector = Eigen::Vector3d>
struct UniformForce : SameForAll<Vector> {
  Vector F;  ///< [force]

  /// @throws std::invalid_argument unless F is finite.
  explicit UniformForce(Vector force) : F(std::move(force)) {
    if (!F.allFinite()) throw std::invalid_argument("phistep: UniformForce's F must be finite");
  }

  void add(auto /*t*/, const auto& /*y*/, auto& out) const {
    static_assert(
        requires { out.force; }, "phistep: UniformForce needs a motion, with forces");
    if constexpr (requires { out.force; }) {
      using Force = std::remove_cvref_t<decltype(out.force)>;
      this->check_size(F, out.force, "UniformForce's F");
      constexpr Eigen::Index d = Vector::SizeAtCompileTime;
      if constexpr (d > 0 && (!Force::IsRowMajor || Force::IsVectorAtCompileTime)) {  // no division in the loop
        const Eigen::Matrix<typename Force::Scalar, int{d}, 1> each =
            F.reshaped().template cast<typename Force::Scalar>();
        for (Eigen::Index i = 0; i < out.force.size(); i += d)
          for (Eigen::Index k = 0; k < d; ++k) out.force.data()[i + k] += each[k];
        return;
      }
      for (Eigen::Index i = 0; i < out.force.size(); ++i) out.force.data()[i] += this->component(F, i, out.force);
    }
  }
  /// −Σ F·r [energy]
  [[nodiscard]] auto energy(auto /*t*/, const auto& y) const requires requires { y.r; }
  {
    typename std::remove_cvref_t<decltype(y.r)>::Scalar sum{0};
    for (Eigen::Index i = 0; i < y.r.size(); ++i) sum -= this->component(F, i, y.r) * y.r.data()[i];
    return sum;
  }
};
template <class Derived>
UniformForce(const Eigen::MatrixBase<Derived>&) -> UniformForce<typename Derived::PlainObject>;

}}  // namespace phistep::PHISTEP_ABI

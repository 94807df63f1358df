/// @file
/// Blocks that particles may have beside r and v. Each names its part of the state, of the rate, of a force's view, and its
/// masses.
#pragma once

#include <Eigen/Core>

#include <stdexcept>

#include "phistep/base/version.hpp"
#include "phistep/particles/bodies/body.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// Particles that turn: I dω/dt = torque.
struct Spin {
  static constexpr const char* name = "omega";
  static constexpr int rows(int dim) { return dim == 3 ? 3 : 1; }
  template <class Scalar, int dim>
  struct Block {
    Eigen::Matrix<Scalar, rows(dim), Eigen::Dynamic>
        omega;  ///< angular velocities [1/time], 3 × N, or 1 × N in the plane
  };
  template <class Scalar, int dim>
  struct RateBlock {
    Eigen::Matrix<Scalar, rows(dim), Eigen::Dynamic> torque;  ///< [force·length]
  };
  template <class Scalar, int dim>
  struct ViewBlock {
    const Eigen::Matrix<Scalar, rows(dim), Eigen::Dynamic>& omega;  ///< [1/time]
    explicit ViewBlock(const Block<Scalar, dim>& from) : omega{from.omega} {}
  };
  static auto& block(auto& y) { return y.omega; }
  static auto& rate(auto& psi) { return psi.torque; }
  template <class Scalar, int dim>
  [[nodiscard]] static auto masses(const Body<Scalar, dim>& body) {
    if (body.radius.size() != body.size())
      throw std::invalid_argument("phistep: particles that turn need radii: set_radius(…)");
    return ParticleMasses<Scalar, rows(dim)>{
        (body.inertia_factor * body.mass.array() * body.radius.array().square()).matrix(), body.still};
  }
};

/// Particles with a temperature: c dT/dt = heat.
struct Temperature {
  static constexpr const char* name = "temperature";
  template <class Scalar, int dim>
  struct Block {
    Eigen::Matrix<Scalar, 1, Eigen::Dynamic> temperature;  ///< [temperature]
  };
  template <class Scalar, int dim>
  struct RateBlock {
    Eigen::Matrix<Scalar, 1, Eigen::Dynamic> heat;  ///< [power]
  };
  template <class Scalar, int dim>
  struct ViewBlock {
    const Eigen::Matrix<Scalar, 1, Eigen::Dynamic>& temperature;  ///< [temperature]
    explicit ViewBlock(const Block<Scalar, dim>& from) : temperature{from.temperature} {}
  };
  static auto& block(auto& y) { return y.temperature; }
  static auto& rate(auto& psi) { return psi.heat; }
  template <class Scalar, int dim>
  [[nodiscard]] static auto masses(const Body<Scalar, dim>& body) {
    using Column = typename Body<Scalar, dim>::Column;
    // What is held in place still takes up heat.
    return ParticleMasses<Scalar, 1>{
        body.heat_capacity.size() == 0 ? Column::Ones(body.size()).eval() : body.heat_capacity, {}};
  }
};

}}  // namespace phistep::PHISTEP_ABI

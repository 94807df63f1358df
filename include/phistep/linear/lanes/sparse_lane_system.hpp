/// @file
/// Factors of several shifted sparse matrices with the same tangents, one a lane (lane_system.hpp).
#pragma once

#include <Eigen/Core>

#include <cstddef>

#include "phistep/base/outcome/outcome.hpp"
#include "phistep/base/outcome/statistics.hpp"
#include "phistep/base/version.hpp"
#include "phistep/linear/lanes/lane_sparse_lu.hpp"
#include "phistep/linear/lanes/lane_system.hpp"
#include "phistep/step/matrix/choice.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// Positions, of which there may be fewer than unknowns.
template <class Vector>
struct ZerosBeyond {
  const Vector& x;
  [[nodiscard]] auto operator[](Eigen::Index i) const {
    return i < x.size() ? x.data()[i] : typename Vector::Scalar{0};
  }
};
template <class Vector>
ZerosBeyond(const Vector&) -> ZerosBeyond<Vector>;

/// LU over a sparse assembly: an analysis for each pattern, none for new values.
template <MatrixFacts facts, class Scalar, int lanes>
class SparseLaneSystem {
 public:
  using Shift = LaneShift<Scalar, lanes>;
  using Number = typename Shift::Number;

  void resize(Eigen::Index) { is_analyzed_ = false; }
  void forget_pattern() { is_analyzed_ = false; }
  [[nodiscard]] Outcome factorize(auto& system, const auto& masses, const Shift& shift, Statistics& statistics) {
    if (system.settle(masses) || !is_analyzed_) {
      is_analyzed_ = false;
      lu_.analyze(system.pattern());
      ++statistics.analyses;
      is_analyzed_ = true;
    }
    auto& W = lu_.values();
    system.for_each_tangent(
        [&](std::size_t slot, Scalar K, Scalar C) { W[slot] = shift.template of_tangents<facts>(K, C); });
    system.for_each_mass(masses, [&](std::size_t slot, Scalar m) { shift.add_mass(W[slot], m); });
    ++statistics.factorizations;
    return lu_.factorize() ? Outcome::success : Outcome::singular_matrix;
  }
  void solve_in_place(Number* x) { lu_.solve_in_place(x); }
  void add_position_product(auto& system, Scalar factor, const auto& x, auto& out) const {
    Eigen::Map<Eigen::Matrix<Scalar, Eigen::Dynamic, 1>> to(out.data(), static_cast<Eigen::Index>(out.size()));
    system.add_position_product(factor, ZerosBeyond{x}, to);
  }

 private:
  LaneSparseLu<Scalar, lanes> lu_;
  bool is_analyzed_ = false;
};

template <MatrixFacts facts, class Scalar, int lanes>
class LaneSystem<SystemKind::sparse, facts, Scalar, lanes> : public SparseLaneSystem<facts, Scalar, lanes> {};
template <MatrixFacts facts, class Scalar, int lanes>
class LaneSystem<SystemKind::symmetric_sparse, facts, Scalar, lanes> : public SparseLaneSystem<facts, Scalar, lanes> {};

}}  // namespace phistep::PHISTEP_ABI

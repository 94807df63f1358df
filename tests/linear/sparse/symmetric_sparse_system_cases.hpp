#pragma once

// What the files symmetric_sparse_system* share; in short: systems.test.cpp.

#include <phistep/sparse.hpp>

#include <cmath>
#include <cstdlib>

#include "contract/states.hpp"
#include "problems/spring_net.hpp"
#include "support/catch.hpp"

namespace symmetric_sparse_cases {

using namespace phistep;
using problems::SpringNet;
using states::same_bits;
using Vec = Eigen::VectorXd;
using Mat = Eigen::MatrixXd;
using Sparse = Eigen::SparseMatrix<double>;

/// y' = A y
struct Linear {
  Sparse A;
  Vec operator()(const Vec& y) const { return A * y; }
  [[nodiscard]] const Sparse& jacobian(const Vec&) const { return A; }
};
inline Linear linear(const Mat& A) { return {A.sparseView()}; }

inline Vec wave(Eigen::Index n) { return Vec::LinSpaced(n, 0, 7).array().sin(); }

inline bool same_motion(const Motion<Vec>& a, const Motion<Vec>& b) {
  return same_bits(a.r, b.r) && same_bits(a.v, b.v);
}

/// A square of springs pressed to 0.6 of their lengths: across the springs it wants to buckle.
inline Motion<Vec> pressed() {
  auto y = SpringNet::start();
  y.r *= 0.6;
  return y;
}

template <class State>
Statistics steps(State& y, auto force, auto scheme, int count, double dt, const auto&... more) {
  PhiStepper stepper{y, force, scheme, more...};
  for (int k = 0; k < count; ++k) {
    const StepReport report = stepper.step(y, dt * k, dt);
    INFO(report.message());
    REQUIRE(report);
  }
  return stepper.statistics();
}

/// A network whose tangent is wanted as a matrix, entry by entry.
template <class Net>
struct ByEntries : Net {
  static constexpr Structure structure = Structure::sparse;
  static constexpr bool has_edges = false, is_symmetric = false;
  explicit ByEntries(Net net) : Net(std::move(net)) {}
};
template <class Net>
ByEntries<Net> by_entries(Net net) {
  return ByEntries<Net>{std::move(net)};
}

/// One step that must fail so, and leave every bit.
inline void must_fail(Outcome expected, Motion<Vec> y, auto force, auto scheme, double dt) {
  PhiStepper stepper{y, force, scheme, mass(SpringNet::masses())};
  const Motion<Vec> before = y;
  const StepReport report = stepper.step(y, 0, dt);
  INFO(report.message());
  CHECK(report.outcome() == expected);
  CHECK(same_motion(y, before));
}
inline void must_fail(Outcome expected, const Mat& A) {
  Vec y = wave(A.rows());
  const Vec before = y;
  PhiStepper stepper{y, symmetric(linear(A)), backward_euler};
  const StepReport report = stepper.step(y, 0, 1);
  INFO(report.message());
  CHECK(report.outcome() == expected);
  CHECK(same_bits(y, before));
}

}  // namespace symmetric_sparse_cases

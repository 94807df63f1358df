/// @file
/// Eigen's sparse solvers can be neither copied nor shared: the copy of a stepper makes its own at its next solve.
#pragma once

#include <memory>

#include "phistep/base/version.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// Owns a solver; its copy owns none. Sharing one would let two steppers overwrite each other.
template <class Solver>
class OwnSolver {
 public:
  OwnSolver() = default;
  OwnSolver(const OwnSolver&) {}
  OwnSolver(OwnSolver&&) noexcept = default;
  OwnSolver& operator=(const OwnSolver&) {
    drop();
    return *this;
  }
  OwnSolver& operator=(OwnSolver&&) noexcept = default;
  ~OwnSolver() = default;

  void make(const auto&... from) { value_ = std::make_unique<Solver>(from...); }
  void drop() { value_ = nullptr; }
  [[nodiscard]] Solver& operator*() const { return *value_; }
  [[nodiscard]] Solver* operator->() const { return value_.get(); }
  [[nodiscard]] explicit operator bool() const { return value_ != nullptr; }

 private:
  std::unique_ptr<Solver> value_;
};

}}  // namespace phistep::PHISTEP_ABI

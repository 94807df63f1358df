/// @file
/// The rivals: each assembles its matrix from the positions and solves, everything that a step needs but no allocation
/// that a second step would not need again.
#pragma once

#include <memory>

#include "problem.hpp"

namespace cloth {

struct Rival {
  virtual ~Rival() = default;
  virtual void step(const Problem& problem, Answer& answer) = 0;
};

// By hand: block-Jacobi conjugate gradients on y = x + Σ B_e (x_i − x_j), phistep not used.
[[nodiscard]] std::unique_ptr<Rival> hand_six_doubles(const Problem& problem);   ///< B_e symmetric, edges in any order
[[nodiscard]] std::unique_ptr<Rival> hand_four_doubles(const Problem& problem);  ///< B_e = a I + w wᵀ
[[nodiscard]] std::unique_ptr<Rival> hand_four_floats(const Problem& problem);   ///< … stored as floats
[[nodiscard]] std::unique_ptr<Rival> hand_padded(
    const Problem& problem);  ///< edges sorted, four lanes a node, fused sweeps

// By Eigen: triplets, conjugate gradients with the diagonal; sparse Cholesky (its analysis made once).
[[nodiscard]] std::unique_ptr<Rival> eigen_cg(const Problem& problem);
[[nodiscard]] std::unique_ptr<Rival> eigen_ldlt(const Problem& problem);
#ifdef BENCH_HAS_CHOLMOD
[[nodiscard]] std::unique_ptr<Rival> eigen_cholmod(const Problem& problem);
#endif

}  // namespace cloth

/// @file
/// A matrix to precondition: diffusion on a grid.
#pragma once

#include <Eigen/SparseCore>

#include "problems/reaction_diffusion.hpp"

/// M + γ (bed − Δ) on a grid of m a side. @param mass  mass(i) → M_ii
[[nodiscard]] inline Eigen::SparseMatrix<double> grid(Eigen::Index m, int dim, double gamma, auto&& mass) {
  const problems::ReactionDiffusion heat{.m = m, .dim = dim, .rate = 0};
  Eigen::SparseMatrix<double> W = -gamma * heat.pattern();
  for (Eigen::Index i = 0; i < W.rows(); ++i) W.coeffRef(i, i) += mass(i);
  W.makeCompressed();
  return W;
}

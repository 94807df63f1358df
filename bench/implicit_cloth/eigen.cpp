#include <Eigen/IterativeLinearSolvers>
#include <Eigen/SparseCholesky>
#ifdef BENCH_HAS_CHOLMOD
#include <Eigen/CholmodSupport>
#endif

#include "rivals.hpp"

namespace cloth {
namespace {
using Matrix = Eigen::SparseMatrix<double>;

class Triplets : public Rival {
 protected:
  void assemble(const Problem& problem) {
    triplets_.clear();
    for (int i = 0; i < problem.unknowns(); ++i) triplets_.emplace_back(i, i, 1.0);
    for (const Spring& s : problem.springs) {
      double across = 0;
      const Eigen::Vector3d n = problem.direction(s, across);
      for (int a = 0; a < 3; ++a)
        for (int b = 0; b < 3; ++b) {
          const double B = problem.k * ((a == b ? across : 0) + (1 - across) * n[a] * n[b]);
          triplets_.emplace_back(3 * s.i + a, 3 * s.i + b, B);
          triplets_.emplace_back(3 * s.j + a, 3 * s.j + b, B);
          triplets_.emplace_back(3 * s.i + a, 3 * s.j + b, -B);
          triplets_.emplace_back(3 * s.j + a, 3 * s.i + b, -B);
        }
    }
    W_.resize(problem.unknowns(), problem.unknowns());
    W_.setFromTriplets(triplets_.begin(), triplets_.end());
  }
  std::vector<Eigen::Triplet<double>> triplets_;
  Matrix W_;
};

class Cg : public Triplets {
  void step(const Problem& problem, Answer& answer) override {
    assemble(problem);
    Eigen::ConjugateGradient<Matrix, Eigen::Lower | Eigen::Upper> solver;
    solver.setTolerance(tolerance);
    solver.setMaxIterations(20000);
    solver.compute(W_);
    answer.x = solver.solve(problem.right_hand_side);
    answer.iterations = solver.iterations();
  }
};

template <class Solver>
class Direct : public Triplets {
  void step(const Problem& problem, Answer& answer) override {
    assemble(problem);
    if (!analysed_) solver_.analyzePattern(W_);
    analysed_ = true;
    solver_.factorize(W_);
    answer.x = solver_.solve(problem.right_hand_side);
  }
  Solver solver_;
  bool analysed_ = false;
};
}  // namespace

std::unique_ptr<Rival> eigen_cg(const Problem&) { return std::make_unique<Cg>(); }
std::unique_ptr<Rival> eigen_ldlt(const Problem&) { return std::make_unique<Direct<Eigen::SimplicialLDLT<Matrix>>>(); }
#ifdef BENCH_HAS_CHOLMOD
std::unique_ptr<Rival> eigen_cholmod(const Problem&) {
  return std::make_unique<Direct<Eigen::CholmodSupernodalLLT<Matrix>>>();
}
#endif

}  // namespace cloth

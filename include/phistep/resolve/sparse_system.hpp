/// @file
/// The step's matrix W = M − γ_f C − γ_f γ_d K, sparse.
///
/// A force emits its entries in an order of its own, usually the same each time. The first Jacobian records that order
/// and the slot of each entry in W; later ones write straight into their slots, and the symbolic analysis is kept. An
/// entry out of the recorded order starts a new pattern.
#pragma once

#include <Eigen/SparseCore>
#include <Eigen/SparseLU>

#include <algorithm>
#include <cmath>
#include <memory>
#include <type_traits>
#include <vector>

#include "phistep/core/arithmetic.hpp"
#include "phistep/core/outcome.hpp"
#include "phistep/core/statistics.hpp"
#include "phistep/core/structure.hpp"
#include "phistep/core/version.hpp"
#include "phistep/resolve/dense_system.hpp"

namespace phistep::inline PHISTEP_ABI {

/// Sparse W over any solver with Eigen's interface (analyzePattern, factorize, solve, info).
template <class Scalar, class Solver>
class SparseSystem : public Sizes {
 public:
  using Matrix = Eigen::SparseMatrix<Scalar>;

  void resize(Eigen::Index n) {
    W_.resize(n, n);
    solver_.value = nullptr;
    entries_.clear();
    has_slots_ = false;
  }

  void clear() {
    written_ = 0;
    if (has_slots_) std::fill(values_.begin(), values_.end(), Tangent{});
    else entries_.clear();
  }
  void position(Eigen::Index i, Eigen::Index j, Scalar x) { put(i, j, {x, Scalar{0}}); }
  void velocity(Eigen::Index i, Eigen::Index j, Scalar x) { put(i, j, {Scalar{0}, x}); }
  void rate(Eigen::Index i, Eigen::Index j, Scalar x) { put(i, j, {Scalar{0}, x}); }
  [[nodiscard]] bool is_finite() const {
    FiniteWitness<Scalar> witness;
    for (const Entry& entry : entries_) witness.see(entry.value.K), witness.see(entry.value.C);
    return witness.all_finite();
  }

  /// False in a copy: Eigen's solvers can't be copied, and sharing one would let two steppers overwrite each other.
  [[nodiscard]] bool has_solver() const { return static_cast<bool>(solver_); }

  [[nodiscard]] Outcome factorize(const auto& masses, Scalar gamma_force, Scalar gamma_drift, Statistics& statistics) {
    if (!solver_) {
      solver_.value = std::make_unique<Solver>();
      has_slots_ = false;
    }
    if (!has_slots_ || written_ != entries_.size()) make_pattern(masses, statistics);
    Scalar* const w = W_.valuePtr();
    Scalar largest_K{0}, largest_w{0};
    for (std::size_t s = 0; s < values_.size(); ++s) {
      w[s] = mass_values_[s] - gamma_force * (values_[s].C + gamma_drift * values_[s].K);
      largest_K = std::max(largest_K, std::abs(values_[s].K));
      largest_w = std::max(largest_w, std::abs(w[s]));
    }
    measure(static_cast<double>(gamma_force * gamma_drift), static_cast<double>(largest_K),
            static_cast<double>(largest_w));
    ++statistics.factorizations;
    solver_->factorize(W_);
    if (solver_->info() == Eigen::NumericalIssue) return failure_of_factors();
    if (solver_->info() != Eigen::Success) return Outcome::linear_solver_failed;
    // SimplicialLDLT doesn't pivot and calls an indefinite matrix a success.
    if constexpr (requires { solver_->vectorD(); })
      if (!(solver_->vectorD().minCoeff() > Scalar{0})) return Outcome::not_positive_definite;
    return Outcome::success;
  }
  [[nodiscard]] Outcome solve(auto& x) {
    x = solver_->solve(x).eval();
    return solver_->info() == Eigen::Success ? Outcome::success : Outcome::linear_solver_failed;
  }

 private:
  struct Tangent {
    Scalar K{0}, C{0};
  };
  struct Entry {
    Eigen::Index i, j;
    Tangent value;
    std::size_t slot;
  };

  /// Owns a solver; its copy owns none.
  struct OwnSolver {
    std::unique_ptr<Solver> value;
    OwnSolver() = default;
    OwnSolver(const OwnSolver&) {}
    OwnSolver(OwnSolver&&) noexcept = default;
    OwnSolver& operator=(const OwnSolver&) {
      value = nullptr;
      return *this;
    }
    OwnSolver& operator=(OwnSolver&&) noexcept = default;
    ~OwnSolver() = default;
    Solver* operator->() const { return value.get(); }
    explicit operator bool() const { return value != nullptr; }
  };

  void put(Eigen::Index i, Eigen::Index j, Tangent x) {
    if (has_slots_) {
      if (written_ < entries_.size() && entries_[written_].i == i && entries_[written_].j == j) {
        Entry& entry = entries_[written_++];
        entry.value = x;
        values_[entry.slot].K += x.K;
        values_[entry.slot].C += x.C;
        return;
      }
      entries_.resize(written_);
      has_slots_ = false;
    }
    entries_.push_back({i, j, x, 0});
    written_ = entries_.size();
  }

  void make_pattern(const auto& masses, Statistics& statistics) {
    std::vector<Eigen::Triplet<Scalar>> triplets;
    entries_.resize(written_);
    triplets.reserve(entries_.size());
    for (const Entry& entry : entries_) triplets.emplace_back(index(entry.i), index(entry.j), Scalar{0});
    masses([&](Eigen::Index i, Eigen::Index j, auto) { triplets.emplace_back(index(i), index(j), Scalar{0}); });
    for (Eigen::Index i = 0; i < W_.rows(); ++i) triplets.emplace_back(index(i), index(i), Scalar{0});
    W_.setFromTriplets(triplets.begin(), triplets.end());
    W_.makeCompressed();
    const auto slots = static_cast<std::size_t>(W_.nonZeros());
    values_.assign(slots, {});
    mass_values_.assign(slots, Scalar{0});
    for (Entry& entry : entries_) {
      entry.slot = slot(entry.i, entry.j);
      values_[entry.slot].K += entry.value.K;
      values_[entry.slot].C += entry.value.C;
    }
    masses([&](Eigen::Index i, Eigen::Index j, auto m) { mass_values_[slot(i, j)] += static_cast<Scalar>(m); });
    has_slots_ = true;
    solver_->analyzePattern(W_);
    ++statistics.analyses;
  }
  [[nodiscard]] static typename Matrix::StorageIndex index(Eigen::Index i) {
    return static_cast<typename Matrix::StorageIndex>(i);
  }
  [[nodiscard]] std::size_t slot(Eigen::Index i, Eigen::Index j) const {
    const auto* const rows = W_.innerIndexPtr();
    const auto *const first = rows + W_.outerIndexPtr()[j], *const last = rows + W_.outerIndexPtr()[j + 1];
    return static_cast<std::size_t>(std::lower_bound(first, last, index(i)) - rows);
  }
  [[nodiscard]] static Outcome failure_of_factors() {
    return requires_definite ? Outcome::not_positive_definite : Outcome::singular_matrix;
  }
  static constexpr bool requires_definite = requires(const Solver& s) {
    s.matrixL();
    s.permutationPinv();
  };

  Matrix W_;
  OwnSolver solver_;
  std::vector<Entry> entries_;   // in the force's order
  std::vector<Tangent> values_;  // by slot of W
  std::vector<Scalar> mass_values_;
  std::size_t written_ = 0;
  bool has_slots_ = false;
};

/// LU unless the user names a solver: right for every tangent, symmetric or not.
template <MatrixFacts facts, class Scalar, int n>
  requires(facts.structure == Structure::sparse ||
           (facts.structure == Structure::network && n == Eigen::Dynamic && !solves_by_edges(facts)))
struct SystemFor<facts, Scalar, n, void> {
  using type = SparseSystem<Scalar, Eigen::SparseLU<Eigen::SparseMatrix<Scalar>>>;
};
template <MatrixFacts facts, class Scalar, int n, class Solver>
  requires(!std::is_void_v<Solver>)
struct SystemFor<facts, Scalar, n, Solver> {
  using type = SparseSystem<Scalar, Solver>;
};

}  // namespace phistep::inline PHISTEP_ABI

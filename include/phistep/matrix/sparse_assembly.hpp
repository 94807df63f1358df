/// @file
/// W = M − γ_f C − γ_f γ_d K as a sparse matrix, assembled from the entries that a force emits.
///
/// A force emits its entries in an order of its own, usually the same each time. The first Jacobian records that order
/// and the slot of each entry in W; later ones write straight into their slots, and the symbolic analysis is kept. An
/// entry out of the recorded order starts a new pattern.
#pragma once

#include <Eigen/SparseCore>

#include <algorithm>
#include <cmath>
#include <type_traits>
#include <vector>

#include "phistep/core/version.hpp"
#include "phistep/matrix/dense_system.hpp"
#include "phistep/simd/update.hpp"

namespace phistep::inline PHISTEP_ABI {

/// A sparse matrix whose arrays stay in place when it is moved. Eigen 3.4 copies them, and its iterative solvers, which
/// refer to the arrays, would be left with freed ones.
template <class Scalar>
struct StayingMatrix : Eigen::SparseMatrix<Scalar> {
  StayingMatrix() = default;
  StayingMatrix(const StayingMatrix&) = default;
  StayingMatrix(StayingMatrix&& other) noexcept { this->swap(other); }
  StayingMatrix& operator=(const StayingMatrix&) = default;
  StayingMatrix& operator=(StayingMatrix&& other) noexcept {
    this->swap(other);
    return *this;
  }
  ~StayingMatrix() = default;
};

/// What every sparse system is towards forces, and its W.
/// @tparam adds_transposes  every entry's transpose has a slot, too
template <class Scalar, bool adds_transposes = false>
class SparseAssembly : public Sizes {
 public:
  using Matrix = Eigen::SparseMatrix<Scalar>;

  void resize(Eigen::Index n) {
    W_.resize(n, n);
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
  void rate(Eigen::Index i, Eigen::Index j, Scalar x) { velocity(i, j, x); }
  [[nodiscard]] bool is_finite() const {
    FiniteWitness<Scalar> witness;
    for (const Entry& entry : entries_) witness.see(entry.value.K), witness.see(entry.value.C);
    return witness.all_finite();
  }
  /// out += factor K x
  void add_position_product(Scalar factor, const auto& x, auto& out) const {
    for (const Entry& entry : entries_) out[entry.i] += factor * entry.value.K * x[entry.j];
  }

  /// For those who make matrices of their own: completes the pattern of W, and returns whether it is a new one. Then K, C and M slot by slot.
  [[nodiscard]] bool settle(const auto& masses) { return update_pattern(masses); }
  [[nodiscard]] const Matrix& pattern() const { return W_; }
  void for_each_slot(auto&& f) const {
    for (std::size_t p = 0; p < values_.size(); ++p) f(p, values_[p].K, values_[p].C, mass_values_[p]);
  }

 protected:
  [[nodiscard]] const Matrix& matrix() const { return W_; }
  /// Makes the pattern where there is none that fits. True: it is new, and wants an analysis.
  [[nodiscard]] bool update_pattern(const auto& masses) {
    if (has_slots_ && written_ == entries_.size()) return false;
    make_pattern(masses);
    return true;
  }
  /// Makes the next update_pattern make a new one.
  void forget_pattern() { has_slots_ = false; }

  /// Fills W.
  void assemble(Scalar gamma_force, Scalar gamma_drift) {
    Scalar* const w = W_.valuePtr();
    const auto* const outer = W_.outerIndexPtr();
    double share = 0, largest = 0;
    for (Eigen::Index j = 0; j < W_.cols(); ++j) {
      // Column by column: a heavy component must not hide how stiff the others are.
      Scalar largest_K{0}, largest_w{0};
      for (auto p = static_cast<std::size_t>(outer[j]); p < static_cast<std::size_t>(outer[j + 1]); ++p) {
        w[p] = mass_values_[p] - gamma_force * (values_[p].C + gamma_drift * values_[p].K);
        largest_K = std::max(largest_K, std::abs(values_[p].K));
        largest_w = std::max(largest_w, std::abs(w[p]));
      }
      if (largest_w > Scalar{0})
        share = std::max(share, static_cast<double>(std::abs(gamma_force * gamma_drift) * largest_K / largest_w));
      largest = std::max(largest, static_cast<double>(largest_w));
    }
    set(share, largest);
  }

  /// Whether each W_ij has a slot for W_ji and |W_ij − W_ji| ≤ tolerance · (the largest entry of columns i and j). In one pass:
  /// row by row, the transposes of the columns' entries come in the order in which they are stored.
  [[nodiscard]] bool is_symmetric(Scalar tolerance) {
    const auto *const outer = W_.outerIndexPtr(), *const inner = W_.innerIndexPtr();
    const Scalar* const w = W_.valuePtr();
    const Eigen::Index n = W_.cols();
    columns_.resize(static_cast<std::size_t>(n));
    for (Eigen::Index j = 0; j < n; ++j) {
      Scalar largest{0};
      for (auto p = outer[j]; p < outer[j + 1]; ++p) largest = std::max(largest, std::abs(w[p]));
      columns_[static_cast<std::size_t>(j)] = {largest, Scalar{0}, outer[j]};
    }
    for (Eigen::Index j = 0; j < n; ++j) {
      Column& here = columns_[static_cast<std::size_t>(j)];
      for (auto p = outer[j]; p < outer[j + 1]; ++p) {
        const auto i = inner[p];
        Column& there = columns_[static_cast<std::size_t>(i)];
        const auto q = there.next++;
        if (q >= outer[i + 1] || inner[q] != j) return false;
        if (!(std::abs(w[p] - w[q]) <= tolerance * std::max(here.largest, there.largest))) return false;
        if (i == j) here.diagonal = w[p];
      }
    }
    return true;
  }
  /// W_ii, of a W that was found symmetric.
  [[nodiscard]] Scalar diagonal(Eigen::Index i) const { return columns_[static_cast<std::size_t>(i)].diagonal; }

 private:
  struct Tangent {
    Scalar K{0}, C{0};
  };
  struct Column {
    Scalar largest, diagonal;
    typename Matrix::StorageIndex next;  // slot whose transpose has not come yet
  };
  struct Entry {
    Eigen::Index i, j;
    Tangent value;
    std::size_t slot;
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

  void make_pattern(const auto& masses) {
    has_slots_ = false;  // until all of this is done
    std::vector<Eigen::Triplet<Scalar>> triplets;
    const auto add = [&triplets](Eigen::Index i, Eigen::Index j) {
      triplets.emplace_back(index(i), index(j), Scalar{0});
      if (adds_transposes && i != j) triplets.emplace_back(index(j), index(i), Scalar{0});
    };
    entries_.resize(written_);
    triplets.reserve((adds_transposes ? 2 : 1) * entries_.size());
    for (const Entry& entry : entries_) add(entry.i, entry.j);
    masses([&](Eigen::Index i, Eigen::Index j, auto) { add(i, j); });
    for (Eigen::Index i = 0; i < W_.rows(); ++i) add(i, i);
    StayingMatrix<Scalar> W;  // one that runs out of memory on the way is good for nothing but its destructor
    W.resize(W_.rows(), W_.cols());
    W.setFromTriplets(triplets.begin(), triplets.end());
    W.makeCompressed();
    W_.swap(W);
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
  }
  [[nodiscard]] static typename Matrix::StorageIndex index(Eigen::Index i) {
    return static_cast<typename Matrix::StorageIndex>(i);
  }
  [[nodiscard]] std::size_t slot(Eigen::Index i, Eigen::Index j) const {
    const auto* const rows = W_.innerIndexPtr();
    const auto *const first = rows + W_.outerIndexPtr()[j], *const last = rows + W_.outerIndexPtr()[j + 1];
    return static_cast<std::size_t>(std::lower_bound(first, last, index(i)) - rows);
  }

  StayingMatrix<Scalar> W_;
  std::vector<Entry> entries_;   // in the force's order
  std::vector<Tangent> values_;  // by slot of W
  std::vector<Scalar> mass_values_;
  std::vector<Column> columns_;  // of is_symmetric
  std::size_t written_ = 0;
  bool has_slots_ = false;
};

}  // namespace phistep::inline PHISTEP_ABI

/// @file
/// W = M − γ_f C − γ_f γ_d K as a sparse matrix, assembled from the entries that a force emits.
///
/// A force emits its entries in an order of its own, usually the same each time. The first Jacobian records that order
/// as the slot of each entry in W; later ones write straight into their slots, and the symbolic analysis is kept. An
/// entry out of the recorded order starts a new pattern.
///
/// Memory: 12 bytes an entry of W, and 8 for each of K and C that is there; 4 bytes an entry that is emitted. M is read
/// anew for each W.
#pragma once

#include <Eigen/SparseCore>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <memory>
#include <utility>
#include <vector>

#include "phistep/base/machine/memory.hpp"
#include "phistep/base/numbers/finite_witness.hpp"
#include "phistep/step/matrix/dense_system.hpp"
#include "phistep/step/matrix/linear_system.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

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

/// A solver as a member of what is copied: Eigen's can be neither copied nor shared. A copy makes its own at its next solve.
template <class Solver>
using OwnSolver = Scratch<std::unique_ptr<Solver>>;

/// Gives A places and zeros in them, collected by counting: column by column, sorted, each once.
/// @param each  each(add) calls add(i, j) for every place, in any order, the same one as often as it likes; twice the same
template <class Scalar>
void give_places(Eigen::SparseMatrix<Scalar>& A, auto&& each) {
  using Slot = typename Eigen::SparseMatrix<Scalar>::StorageIndex;
  std::vector<Slot> outer(static_cast<std::size_t>(A.cols()) + 1, 0);
  each([&outer](auto, auto j) { ++outer[static_cast<std::size_t>(j) + 1]; });
  for (std::size_t j = 1; j < outer.size(); ++j) outer[j] += outer[j - 1];
  std::vector<Slot> inner(static_cast<std::size_t>(outer.back()));
  each([&](auto i, auto j) {
    inner[static_cast<std::size_t>(outer[static_cast<std::size_t>(j)]++)] = static_cast<Slot>(i);
  });
  // outer[j] is the end of column j now.
  auto from = inner.begin(), to = from;
  Slot start = 0;
  for (std::size_t j = 0; j + 1 < outer.size(); ++j) {
    const auto last = inner.begin() + outer[j];
    std::sort(from, last);
    to = std::unique_copy(from, last, to);
    from = last;
    outer[j] = std::exchange(start, static_cast<Slot>(to - inner.begin()));
  }
  outer.back() = start;
  StayingMatrix<Scalar> made;  // one that runs out of memory on the way is good for nothing but its destructor
  made.resize(A.rows(), A.cols());
  made.resizeNonZeros(static_cast<Eigen::Index>(start));
  std::copy(outer.begin(), outer.end(), made.outerIndexPtr());
  std::copy(inner.begin(), inner.begin() + start, made.innerIndexPtr());
  std::fill(made.valuePtr(), made.valuePtr() + made.nonZeros(), Scalar{0});
  A.swap(made);
}

/// What every sparse system is towards forces, and its W.
/// @tparam adds_transposes  every entry's transpose has a slot, too
template <class Scalar, bool has_K = true, bool has_C = true, bool adds_transposes = false>
class SparseAssembly : public SystemDefaults {
 public:
  using Matrix = Eigen::SparseMatrix<Scalar>;

  void resize(Eigen::Index n) {
    W_.resize(n, n);
    slots_.clear();
    found_.clear();
    written_ = 0;
    has_slots_ = false;
  }

  void clear() {
    written_ = 0;
    if (has_slots_) tangents_.clear();
    else found_.clear();
  }
  void position(Eigen::Index i, Eigen::Index j, Scalar x) {
    if constexpr (has_K) put<of_K>(i, j, tangents_.K, x);
  }
  void velocity(Eigen::Index i, Eigen::Index j, Scalar x) {
    if constexpr (has_C) put<of_C>(i, j, tangents_.C, x);
  }
  void rate(Eigen::Index i, Eigen::Index j, Scalar x) { velocity(i, j, x); }
  [[nodiscard]] bool is_finite() const {
    if (has_slots_) return tangents_.is_finite();
    FiniteWitness<Scalar> witness;
    for (const Found& entry : found_)
      for (const Scalar x : entry.x) witness.see(x);
    return witness.all_finite();
  }
  /// out += factor K x, of which x may have the first numbers alone
  void add_position_product(Scalar factor, const auto& x, auto& out) const {
    if constexpr (has_K) {
      const auto add = [&](Slot i, Eigen::Index j, Scalar K) { out.data()[i] += factor * K * x.data()[j]; };
      if (!has_slots_) {
        for (const Found& entry : found_)
          if (entry.j < x.size()) add(entry.i, entry.j, entry.x[of_K]);
      } else {
        for (Eigen::Index j = 0; j < x.size(); ++j)
          for (auto p = outer()[j]; p < outer()[j + 1]; ++p) add(inner()[p], j, tangents_.K[p]);
      }
    }
  }

  /// Makes the pattern of W where there is none that fits. True: it is new, and wants an analysis. With pattern(),
  /// for_each_tangent() and for_each_mass() the caller can then make matrices from K, C and M slot by slot.
  [[nodiscard]] bool settle(const auto& masses) {
    if (has_slots_ && written_ == slots_.size()) return false;
    forget_pattern();
    make_pattern(masses);
    return true;
  }
  [[nodiscard]] const Matrix& pattern() const { return W_; }
  void for_each_tangent(auto&& f) const {
    for (Eigen::Index p = 0; p < W_.nonZeros(); ++p) {
      Scalar K{0}, C{0};
      if constexpr (has_K) K = tangents_.K[p];
      if constexpr (has_C) C = tangents_.C[p];
      f(static_cast<std::size_t>(p), K, C);
    }
  }
  void for_each_mass(const auto& masses, auto&& f) const {
    masses([&](Eigen::Index i, Eigen::Index j, auto m) { f(slot(i, j), static_cast<Scalar>(m)); });
  }

 protected:
  [[nodiscard]] const Matrix& matrix() const { return W_; }
  /// Makes the next settle() make a new one: the entries wait for it. Those of one slot have the sum in the first's place.
  void forget_pattern() {
    if (!has_slots_) return;
    found_.clear();
    found_.reserve(slots_.size());
    for (std::size_t k = 0; k < written_; ++k) {
      const Slot p = slots_[k];
      const auto j = static_cast<Slot>(std::upper_bound(outer(), outer() + W_.cols() + 1, p) - outer() - 1);
      Found& entry = found_.emplace_back(Found{{}, inner()[p], j});
      if constexpr (has_K) entry.x[of_K] = std::exchange(tangents_.K[p], Scalar{0});
      if constexpr (has_C) entry.x[of_C] = std::exchange(tangents_.C[p], Scalar{0});
    }
    has_slots_ = false;
  }

  /// Fills W.
  void assemble(const auto& masses, Scalar gamma_force, Scalar gamma_drift) {
    Eigen::Map<Vector> w{W_.valuePtr(), W_.nonZeros()};
    w = tangents_.part(gamma_force, gamma_drift);
    for_each_mass(masses, [&w](std::size_t p, Scalar m) { w[static_cast<Eigen::Index>(p)] += m; });
    double share = 0;
    if constexpr (has_K)
      for (Eigen::Index j = 0; j < W_.cols(); ++j) {
        // Column by column: a heavy component must not hide how stiff the others are.
        Scalar largest_K{0}, largest_w{0};
        for (auto p = outer()[j]; p < outer()[j + 1]; ++p) {
          largest_K = std::max(largest_K, std::abs(tangents_.K[p]));
          largest_w = std::max(largest_w, std::abs(w[p]));
        }
        if (largest_w > Scalar{0})
          share = std::max(share, static_cast<double>(std::abs(gamma_force * gamma_drift) * largest_K / largest_w));
      }
    set(share, largest(w));
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
  using Vector = Eigen::Matrix<Scalar, Eigen::Dynamic, 1>;
  using Slot = typename Matrix::StorageIndex;
  struct Column {
    Scalar largest, diagonal;
    Slot next;  // slot whose transpose has not come yet
  };
  static constexpr std::size_t kinds = has_K && has_C ? 2 : 1, of_K = 0, of_C = kinds - 1;
  struct Found {
    std::array<Scalar, kinds> x;
    Slot i, j;
  };

  template <std::size_t kind>
  void put(Eigen::Index i, Eigen::Index j, Vector& tangent, Scalar x) {
    if (has_slots_) {
      if (written_ < slots_.size() && 0 <= j && j < W_.cols()) {
        const Slot p = slots_[written_];
        if (inner()[p] == i && outer()[j] <= p && p < outer()[j + 1]) {
          tangent[p] += x;
          ++written_;
          return;
        }
      }
      forget_pattern();
    }
    // By less than the double: at this moment large fields take most memory.
    if (found_.size() == found_.capacity())
      found_.reserve(found_.size() + std::max(static_cast<std::size_t>(W_.cols()), found_.size() / 4));
    found_.push_back({{}, static_cast<Slot>(i), static_cast<Slot>(j)});
    found_.back().x[kind] = x;
  }

  void make_pattern(const auto& masses) {
    give_places(W_, [&](auto&& add) {
      const auto both = [&add](Eigen::Index i, Eigen::Index j) {
        add(i, j);
        if (adds_transposes && i != j) add(j, i);
      };
      for (const Found& entry : found_) both(entry.i, entry.j);
      masses([&both](Eigen::Index i, Eigen::Index j, auto) { both(i, j); });
      for (Eigen::Index i = 0; i < W_.cols(); ++i) add(i, i);
    });
    tangents_.resize(W_.nonZeros());
    slots_.resize(found_.size());
    for (std::size_t k = 0; k < found_.size(); ++k) {
      const Found& entry = found_[k];
      const auto p = static_cast<Slot>(slot(entry.i, entry.j));
      slots_[k] = p;
      if constexpr (has_K) tangents_.K[p] += entry.x[of_K];
      if constexpr (has_C) tangents_.C[p] += entry.x[of_C];
    }
    written_ = slots_.size();
    std::vector<Found>{}.swap(found_);
    has_slots_ = true;
  }
  [[nodiscard]] const Slot* outer() const { return W_.outerIndexPtr(); }
  [[nodiscard]] const Slot* inner() const { return W_.innerIndexPtr(); }
  [[nodiscard]] std::size_t slot(Eigen::Index i, Eigen::Index j) const {
    const Slot *p = inner() + outer()[j], *const last = inner() + outer()[j + 1];
    for (int k = 0; k < 8 && p != last && *p < i; ++k) ++p;  // most columns are short
    return static_cast<std::size_t>(std::lower_bound(p, last, static_cast<Slot>(i)) - inner());
  }

  StayingMatrix<Scalar> W_;
  Tangents<Vector, has_K, has_C> tangents_;  // by slot of W
  std::vector<Slot> slots_;                  // of the force's entries, in its order
  std::vector<Found> found_;                 // the force's entries, until the pattern is made of them
  std::vector<Column> columns_;              // of is_symmetric
  std::size_t written_ = 0;                  // entries with slots so far
  bool has_slots_ = false;
};

}}  // namespace phistep::PHISTEP_ABI

/// @file
/// A neighbour list as the memory of a force: valid until particles have moved too far, then made anew.
///
/// What is closer than cutoff + skin at positions R is listed. While the two largest |r − R| add up to at most the skin, no pair is missed
/// [as in LAMMPS' `neigh_modify check yes`, which doubles the largest].
///
/// The list is a pure function of R, the box and which particles are held still. These are the memory, a value: a rejected step takes it
/// back, a checkpoint holds it, and the list comes back bit for bit. The list itself is a cache of the force term.
#pragma once

#include <Eigen/Core>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <mutex>
#include <span>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "phistep/base/machine/memory.hpp"
#include "phistep/base/machine/shares.hpp"
#include "phistep/base/numbers/finite_witness.hpp"
#include "phistep/particles/neighbors/list_builder.hpp"
#include "phistep/particles/neighbors/neighbor_list.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// What a list was made from.
struct NeighborReference {
  std::vector<double> positions;  ///< R, dim × N [length]
  Domain domain;
  std::vector<std::uint8_t> still;               ///< as in Body
  double skin = 0;                               ///< [length]
  mutable std::uint64_t listed = 0, tested = 0;  ///< what the list took, once it has been made

  void archive(auto& ar) {
    ar("positions", positions, "lower", domain.lower, "length", domain.length, "periodic", domain.periodic, "still",
       still, "skin", skin, "listed", listed, "tested", tested);
    ar.check(skin >= 0 && std::isfinite(skin));
    // From a NaN no particle would ever have moved.
    for (const auto& x : {std::span<const double>(positions), std::span<const double>(domain.lower),
                          std::span<const double>(domain.length)})
      ar.check(all_finite(x.data(), static_cast<std::ptrdiff_t>(x.size())));
  }
};

/// `Memory` of a force on a neighbour list. Evaluations may replace the reference: that changes Ψ by rounding only.
struct NeighborMemory {
  static constexpr bool is_cache = true;
  mutable std::shared_ptr<const NeighborReference> reference;
  mutable std::int32_t age = 0;     ///< steps accepted since
  mutable bool is_pattern = false;  ///< a matrix has an entry for each pair listed: the skin stays as it is

  void archive(auto& ar) {
    bool has = reference != nullptr;
    NeighborReference list = has ? *reference : NeighborReference{};
    ar("has_list", has, "age", age, "is_pattern", is_pattern, "list", list);
    ar.check(age >= -1);
    if constexpr (std::remove_cvref_t<decltype(ar)>::reading)
      reference = has ? std::make_shared<NeighborReference>(std::move(list)) : nullptr;
  }
};

/// What is listed.
struct NeighborRange {
  double cutoff;                     ///< [length]
  double skin;                       ///< [length]
  std::int32_t unchecked_every = 0;  ///< as in PairOptions
  std::int32_t pad = 1;
  bool finds_skin = false;           ///< `skin` is where it starts from
  const TypeCutoffs* own = nullptr;  ///< where pairs have their own; `cutoff` is the longest
};

/// The list of a term, and what it cost: a workspace.
/// @tparam own_cutoffs  each pair of types has its own
template <int dim, bool own_cutoffs = false>
class Neighbors {
 public:
  /// The list for positions r (dim × N), from the memory's reference if that still serves, else from r, the new reference.
  /// @throws std::invalid_argument where the cutoff is longer than a period of the box
  template <class Scalar>
  const NeighborList& list(const Scalar* r, Eigen::Index particles, const Domain& domain,
                           const std::vector<std::uint8_t>& still, const NeighborRange& range,
                           const NeighborMemory& memory) {
    const auto is_of_these = [&](const NeighborReference* of) {
      return of != nullptr && of->positions.size() == static_cast<std::size_t>(particles) * dim &&
             of->domain == domain && of->still == still;
    };
    const NeighborReference* const last = memory.reference.get();
    const bool alike = is_of_these(last);
    if (!alike || !serves(*last, r, range, memory.age)) {
      double skin = range.finds_skin && last != nullptr ? last->skin : range.skin;
      if (alike && range.finds_skin && !memory.is_pattern && particles > 0)
        skin = better_skin(*last, range, memory.age);
      memory.age = last == nullptr ? 0 : -1;  // the first is made before a step, others at its end
      // The list of just these positions may be at hand: from an energy or a slope computed there.
      const bool known = is_of_these(built_.get()) && built_->skin == skin &&
                         std::equal(built_->positions.begin(), built_->positions.end(), r, [](double x, Scalar y) {
                           return std::bit_cast<std::uint64_t>(x) ==
                                  std::bit_cast<std::uint64_t>(static_cast<double>(y));  // a checkpoint tells −0 from 0
                         });
      if (!known) {
        built_.reset();
        const std::shared_ptr<NeighborReference> next = pool_.take();
        next->positions.assign(r, r + particles * dim);
        next->domain = domain, next->still = still, next->skin = skin;
        memory.reference = next;
      } else {
        memory.reference = built_;
      }
    }
    bool same = built_ == memory.reference && range_.cutoff == range.cutoff && range_.pad == range.pad;
    if constexpr (own_cutoffs) same = same && own_ == *range.own;
    if (!same) build(memory.reference, range);
    return list_;
  }

  /// The list made last, what it was made from, and its skin: 0 before the first.
  [[nodiscard]] const NeighborList& current() const { return list_; }
  [[nodiscard]] const std::shared_ptr<const NeighborReference>& made_from() const { return built_; }
  [[nodiscard]] double skin() const { return built_ ? built_->skin : 0.0; }
  /// How many lists were made so far, and what they took.
  [[nodiscard]] std::uint64_t rebuilds() const { return rebuilds_; }
  [[nodiscard]] std::uint64_t pairs_tested() const { return list_.pairs_tested(); }
  [[nodiscard]] std::uint64_t pairs_listed() const { return list_.pairs_listed(); }

 private:
  template <class Scalar>
  [[nodiscard]] static bool serves(const NeighborReference& reference, const Scalar* r, const NeighborRange& range,
                                   std::int32_t age) {
    if (!range.finds_skin && reference.skin != range.skin) return false;
    if (range.unchecked_every > 0) return age < range.unchecked_every - 1;
    const auto particles = static_cast<Eigen::Index>(reference.positions.size() / dim);
    return moved(reference.positions.data(), r, particles) <= reference.skin;
  }

  /// The skin for the next list, where this one has served its time.
  [[nodiscard]] static double better_skin(const NeighborReference& last, const NeighborRange& range, std::int32_t age) {
    double longest = std::numeric_limits<double>::infinity();  // fewer than two periods: images would be the most of it
    for (std::size_t a = 0; a < dim; ++a)
      if (last.domain.periodic[a]) longest = std::min(longest, last.domain.length[a] / 2 - range.cutoff);
    const auto n = static_cast<double>(last.positions.size() / dim);
    const ListUse use{static_cast<double>(last.listed) / n, static_cast<double>(last.tested) / n, age + 1};
    return next_skin<dim>(range.cutoff, last.skin, use, longest);
  }

  /// The sum of the two largest displacements. What is not a number has not moved: a new list would not help.
  template <class Scalar>
  [[nodiscard]] static double moved(const double* from, const Scalar* to, Eigen::Index particles) {
    using TwoLargest = std::array<double, 2>;  // squares
    const auto see = [](TwoLargest& two, double square) {
      two[1] = std::max(two[1], std::min(square, two[0]));
      two[0] = std::max(two[0], square);
    };
    TwoLargest all{};
    std::mutex one_at_a_time;
    const auto look = [&](Eigen::Index begin, Eigen::Index end) {
      TwoLargest some{};
      for (Eigen::Index i = begin; i < end; ++i) {
        double square = 0;
        for (Eigen::Index a = 0; a < dim; ++a) {
          const double d = static_cast<double>(to[dim * i + a]) - from[dim * i + a];
          square += d * d;
        }
        see(some, square);
      }
      const std::lock_guard lock{one_at_a_time};
      see(all, some[0]), see(all, some[1]);
    };
    for_each_range(particles, 256, look, shared_from / dim);
    return std::sqrt(all[0]) + std::sqrt(all[1]);
  }

  void build(const std::shared_ptr<const NeighborReference>& reference, const NeighborRange& range) {
    built_.reset();
    const NeighborReference& from = *reference;
    for (std::size_t a = 0; a < dim; ++a) {
      if (!from.domain.periodic[a]) continue;
      const auto refuse = [&](const char* what, double length) {
        throw std::invalid_argument("phistep: the " + std::string(what) + " " + std::to_string(length) +
                                    " is larger than the box, whose period along axis " + std::to_string(a) + " is " +
                                    std::to_string(from.domain.length[a]));
      };
      if (range.cutoff > from.domain.length[a]) refuse("cutoff", range.cutoff);
      // Eight images are searched: with a longer reach pairs would be missed.
      if (range.cutoff + from.skin > 6 * from.domain.length[a]) refuse("skin", from.skin);
    }
    if constexpr (own_cutoffs) own_ = *range.own;
    try {
      builder_.build(from.positions.data(), static_cast<std::int32_t>(from.positions.size() / dim), from.domain,
                     from.still, range.cutoff + from.skin, range.pad, list_, own_, from.skin);
    } catch (...) {
      list_.rows.clear();  // current() must not lead to rows that were never filled
      throw;
    }
    ++rebuilds_;
    from.listed = list_.pairs_listed(), from.tested = list_.pairs_tested();
    range_ = range;
    built_ = reference;
  }

  ListBuilder<dim, own_cutoffs> builder_;
  NeighborList list_;
  std::shared_ptr<const NeighborReference> built_;  // what list_ was made from
  NeighborRange range_{};
  TypeCutoffs own_;
  Recycled<NeighborReference> pool_;
  std::uint64_t rebuilds_ = 0;
};

}}  // namespace phistep::PHISTEP_ABI

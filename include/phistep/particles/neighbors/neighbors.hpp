/// @file
/// A neighbour list as the memory of a force: valid until particles have moved too far, then made anew.
///
/// What is closer than cutoff + skin at positions R is listed. A pair can have come from beyond that to within the cutoff only
/// if the two together moved by more than the skin: while the two largest |r − R| add up to at most the skin, no pair
/// is missed [as in LAMMPS' `neigh_modify check yes`, which doubles the largest].
///
/// The list is a pure function of R, the box and which particles are held still. These are the memory, a value: a rejected
/// step takes it back, a checkpoint holds it, and the list comes back bit for bit. The list itself is a cache: kept once,
/// by the force term, in buffers that serve again.
#pragma once

#include <Eigen/Core>

#include <algorithm>
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

#include "phistep/base/machine/scratch.hpp"
#include "phistep/base/machine/shares.hpp"
#include "phistep/base/numbers/finite_witness.hpp"
#include "phistep/base/version.hpp"
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
    // From where a position isn't a number, nothing would ever have moved.
    for (const auto& x : {std::span<const double>(positions), std::span<const double>(domain.lower),
                          std::span<const double>(domain.length)})
      ar.check(all_finite(x.data(), static_cast<std::ptrdiff_t>(x.size())));
  }
};

/// `Memory` of a force on a neighbour list. Evaluations replace its reference when particles have moved too far; that
/// changes Ψ by rounding only.
struct NeighborMemory {
  static constexpr bool is_cache = true;
  mutable std::shared_ptr<const NeighborReference> reference;
  mutable std::int32_t age = 0;     ///< steps accepted since
  mutable bool is_pattern = false;  ///< a matrix has an entry for each pair listed: the skin stays as it is

  void archive(auto& ar) {
    using Ar = std::remove_cvref_t<decltype(ar)>;
    bool has = reference != nullptr;
    ar("has_list", has, "age", age, "is_pattern", is_pattern);
    ar.check(age >= -1);
    if constexpr (Ar::reading) {
      auto read = has ? std::make_shared<NeighborReference>() : nullptr;
      if (has) ar("list", *read);
      reference = std::move(read);
    } else if (has) {
      NeighborReference copy = *reference;
      ar("list", copy);
    }
  }
};

/// When a list is made anew.
struct ListPolicy {
  std::int32_t every = 0;  ///< 0: when displacement demands

  /// Every n steps, moved or not. It misses pairs, and the forces between them: for comparisons with codes that do so.
  [[nodiscard]] static constexpr ListPolicy unchecked_every(std::int32_t n) { return {n}; }
};

/// How far to look.
struct NeighborRange {
  double cutoff;  ///< [length]
  double skin;    ///< [length]
  ListPolicy policy{};
  std::int32_t pad = 1;
  bool finds_skin = false;  ///< `skin` is where it starts from

  /// @throws std::invalid_argument where that can't be
  void check() const {
    if (!(cutoff > 0) || !std::isfinite(cutoff))
      throw std::invalid_argument("phistep: a cutoff must be finite and > 0");
    if (!(skin >= 0) || !std::isfinite(skin)) throw std::invalid_argument("phistep: a skin must be finite and >= 0");
    if (policy.every < 0) throw std::invalid_argument("phistep: a list is made anew every n >= 1 steps");
  }
};

/// The list of a term, and what it cost. A copy starts empty: lists are made when they are asked for.
template <int dim>
class Neighbors {
 public:
  Neighbors() = default;
  Neighbors(const Neighbors&) noexcept {}
  Neighbors(Neighbors&&) noexcept = default;
  Neighbors& operator=(const Neighbors& other) {
    if (this != &other) *this = Neighbors{};
    return *this;
  }
  Neighbors& operator=(Neighbors&&) noexcept = default;

  /// The list for positions r (dim × N), from the memory's reference if that still serves, else from r, which then is the
  /// reference. `rebuilds()` counts up where the list changes.
  /// @throws std::invalid_argument where the cutoff is longer than a period of the box
  template <class Scalar>
  const NeighborList& list(const Scalar* r, Eigen::Index particles, const Domain& domain,
                           const std::vector<std::uint8_t>& still, const NeighborRange& range,
                           const NeighborMemory& memory) {
    if (!serves(memory.reference.get(), r, particles, domain, still, range, memory.age)) {
      const double skin = skin_after(memory, particles, domain, still, range);
      memory.age = memory.reference == nullptr ? 0 : -1;  // the first is made before a step, others at its end
      // The list of just these positions may be at hand: from an energy computed there.
      const bool known = built_ != nullptr && built_->skin == skin && built_->domain == domain &&
                         built_->still == still &&
                         built_->positions.size() == static_cast<std::size_t>(particles) * dim &&
                         std::equal(built_->positions.begin(), built_->positions.end(), r, [](double x, Scalar y) {
                           return std::bit_cast<std::uint64_t>(x) ==
                                  std::bit_cast<std::uint64_t>(static_cast<double>(y));  // a checkpoint tells −0 from 0
                         });
      memory.reference = known ? built_ : remember(r, particles, domain, still, skin);
    }
    if (built_ != memory.reference || !(range_ == key(range))) build(memory.reference, range);
    return list_;
  }
  /// The same without a memory, which nothing changes: by the list at hand, if that serves.
  template <class Scalar>
  const NeighborList& list(const Scalar* r, Eigen::Index particles, const Domain& domain,
                           const std::vector<std::uint8_t>& still, const NeighborRange& range) {
    NeighborMemory memory;
    memory.reference = built_;
    const double skin = built_ != nullptr && range.finds_skin ? built_->skin : range.skin;
    return list(r, particles, domain, still, {range.cutoff, skin, {}, range.pad}, memory);
  }

  /// The list made last, and its skin: 0 before the first.
  [[nodiscard]] const NeighborList& current() const { return list_; }
  [[nodiscard]] double skin() const { return built_ ? built_->skin : 0.0; }
  /// How many lists were made so far, and what they took.
  [[nodiscard]] std::uint64_t rebuilds() const { return rebuilds_; }
  [[nodiscard]] std::uint64_t pairs_tested() const { return list_.pairs_tested(); }
  [[nodiscard]] std::uint64_t pairs_listed() const { return list_.pairs_listed(); }

 private:
  using Key = std::pair<double, std::int32_t>;
  [[nodiscard]] static Key key(const NeighborRange& range) { return {range.cutoff, range.pad}; }

  [[nodiscard]] static bool is_of(const NeighborReference* reference, Eigen::Index particles, const Domain& domain,
                                  const std::vector<std::uint8_t>& still) {
    return reference != nullptr && reference->positions.size() == static_cast<std::size_t>(particles) * dim &&
           reference->domain == domain && reference->still == still;
  }

  template <class Scalar>
  [[nodiscard]] static bool serves(const NeighborReference* reference, const Scalar* r, Eigen::Index particles,
                                   const Domain& domain, const std::vector<std::uint8_t>& still,
                                   const NeighborRange& range, std::int32_t age) {
    if (!is_of(reference, particles, domain, still) || (!range.finds_skin && reference->skin != range.skin))
      return false;
    if (range.policy.every > 0) return age < range.policy.every - 1;
    return moved(reference->positions.data(), r, particles) <= reference->skin;
  }

  /// The skin for the next list, where the memory's has served its time.
  [[nodiscard]] static double skin_after(const NeighborMemory& memory, Eigen::Index particles, const Domain& domain,
                                         const std::vector<std::uint8_t>& still, const NeighborRange& range) {
    const NeighborReference* const last = memory.reference.get();
    if (!range.finds_skin || last == nullptr) return range.skin;
    if (memory.is_pattern || particles == 0 || !is_of(last, particles, domain, still)) return last->skin;
    double longest = std::numeric_limits<double>::infinity();  // fewer than two periods: images would be the most of it
    for (std::size_t a = 0; a < dim; ++a)
      if (domain.periodic[a]) longest = std::min(longest, domain.length[a] / 2 - range.cutoff);
    const auto n = static_cast<double>(particles);
    return next_skin<dim>(
        range.cutoff, last->skin,
        {static_cast<double>(last->listed) / n, static_cast<double>(last->tested) / n, memory.age + 1}, longest);
  }

  /// The sum of the two largest displacements. What is not a number has not moved: a new list would not help.
  template <class Scalar>
  [[nodiscard]] static double moved(const double* from, const Scalar* to, Eigen::Index particles) {
    Displacements all;
    std::mutex one_at_a_time;
    for_each_range(
        particles, 256,
        [&](Eigen::Index begin, Eigen::Index end) {
          const Displacements some = displacements(from, to, begin, end);
          const std::lock_guard lock{one_at_a_time};
          all.see(some.first), all.see(some.second);
        },
        shared_from / dim);
    return std::sqrt(all.first) + std::sqrt(all.second);
  }
  /// The two largest, squared.
  struct Displacements {
    double first = 0, second = 0;
    void see(double square) {
      const double smaller = square < first ? square : first;
      second = smaller > second ? smaller : second;
      first = square > first ? square : first;
    }
  };
  template <class Scalar>
  [[nodiscard]] static Displacements displacements(const double* from, const Scalar* to, Eigen::Index begin,
                                                   Eigen::Index end) {
    Displacements all;
    constexpr Eigen::Index block = 256;
    double square[block];
    for (Eigen::Index i = begin; i < end; i += block) {
      const Eigen::Index n = std::min(block, end - i);
      for (Eigen::Index j = 0; j < n; ++j) {
        square[j] = 0;
        for (Eigen::Index a = 0; a < dim; ++a) {
          const double d = static_cast<double>(to[dim * (i + j) + a]) - from[dim * (i + j) + a];
          square[j] += d * d;
        }
      }
      for (Eigen::Index j = 0; j < n; ++j) all.see(square[j]);
    }
    return all;
  }

  template <class Scalar>
  std::shared_ptr<const NeighborReference> remember(const Scalar* r, Eigen::Index particles, const Domain& domain,
                                                    const std::vector<std::uint8_t>& still, double skin) {
    built_.reset();
    std::shared_ptr<NeighborReference> reference = pool_.take();
    reference->positions.assign(r, r + particles * dim);
    reference->domain = domain;
    reference->still = still;
    reference->skin = skin;
    return reference;
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
    try {
      builder_.build(from.positions.data(), static_cast<std::int32_t>(from.positions.size() / dim), from.domain,
                     from.still, range.cutoff + from.skin, range.pad, list_);
    } catch (...) {
      list_.rows.clear();  // current() must not lead to rows that were never filled
      throw;
    }
    ++rebuilds_;
    from.listed = list_.pairs_listed(), from.tested = list_.pairs_tested();
    range_ = key(range);
    built_ = reference;
  }

  ListBuilder<dim> builder_;
  NeighborList list_;
  std::shared_ptr<const NeighborReference> built_;  // what list_ was made from
  Key range_{};
  Recycled<NeighborReference> pool_;
  std::uint64_t rebuilds_ = 0;
};

}}  // namespace phistep::PHISTEP_ABI

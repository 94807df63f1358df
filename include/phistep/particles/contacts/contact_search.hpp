/// @file
/// Finds the pairs of contact_pairs.hpp, by the neighbour list's cells.
#pragma once

#include <Eigen/Core>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "phistep/base/machine/memory.hpp"
#include "phistep/base/machine/shares.hpp"
#include "phistep/base/numbers/pack_math.hpp"
#include "phistep/particles/contacts/contact_kernel.hpp"
#include "phistep/particles/contacts/contact_pairs.hpp"
#include "phistep/particles/neighbors/list_builder.hpp"
#include "phistep/particles/neighbors/neighbor_list.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// Which level of cells a body is in: k where 2.5^−(k+1) < R/R_max <= 2.5^−k, and the last where it is smaller still. (Levels
/// a factor of 2, 3 or 4 apart took longer on most mixtures of 1 : 2 to 1 : 30.)
template <class Scalar>
[[nodiscard]] int level_of_cells(Scalar radius, Scalar largest) {
  constexpr int last = 20;
  constexpr auto apart = static_cast<Scalar>(2.5);
  int level = 0;
  for (Scalar edge = largest / apart; radius <= edge && edge > 0 && level < last; edge /= apart) ++level;
  return level;
}

/// A workspace for one search or several.
///
/// Bodies are searched by levels of their size [V. Ogarko & S. Luding, Comput. Phys. Commun. 183, 931 (2012)], each in cells
/// as wide as its own largest. A body is tried with those in the cells of its own level and of the coarser ones, so that the work
/// is proportional to the number of bodies, whatever their sizes. Where radii are within a factor of 2.5, there is one level.
template <class Scalar, int dim>
class ContactSearch {
 public:
  /// All pairs of bodies whose surfaces are nearer than the skin.
  /// @throws std::invalid_argument where a period of the box is so short that two bodies could touch twice
  void find(const auto& r, const auto& body, Scalar skin, ContactPairs<Scalar>& pairs) {
    const auto n = static_cast<std::size_t>(r.cols());
    const Domain domain = domain_of(body.box);
    const Scalar largest = n > 0 ? body.radius.maxCoeff() : Scalar{0},
                 least = n > 0 ? body.radius.minCoeff() : Scalar{0};
    const double range = static_cast<double>(2 * largest + skin);
    for (std::size_t a = 0; a < dim; ++a)
      if (n > 0 && domain.periodic[a] && !(domain.length[a] > 2 * range))
        throw std::invalid_argument("phistep: the box's period along axis " + std::to_string(a) + ", " +
                                    std::to_string(domain.length[a]) +
                                    ", must be more than twice the bodies' largest diameter and the skin");
    pairs.period = domain.length;
    const auto nearest = nearest_image<Scalar>(pairs.period);
    std::vector<Scalar> placed(4 * n);  // x y z R of each slot
    std::vector<std::int32_t> order, slot(n);
    order.reserve(n);
    found_.assign(thread_count(), {});
    const auto look_around = [&](const Share& own, double reach) {
      Found& found = found_[own.number];
      typename ListBuilder<dim>::Around around;
      for (std::size_t s = own.begin; s < own.end; ++s) {
        const Scalar* const at = &placed[4 * s];
        const auto p = static_cast<std::int32_t>(s);
        std::array<double, dim> x;
        std::copy_n(at, dim, x.begin());
        for (const std::int32_t k : builder_.around(x, static_cast<double>(at[3]) + reach, around)) {
          const std::int32_t q = slot[static_cast<std::size_t>(body_at(k))];
          around.tested -= q == p;
          if (q <= p) continue;
          const Scalar* const o = &placed[4 * static_cast<std::size_t>(q)];
          const Triple<Scalar> apart = nearest({at[0] - o[0], at[1] - o[1], at[2] - o[2]});
          const Scalar touch = at[3] + o[3] + skin;
          if (dot(apart, apart) < touch * touch) found.pairs.emplace_back(p, q);
        }
      }
      found.tested += around.tested;
    };
    const int finest = n > 0 ? level_of_cells(least, largest) : -1;
    for (int level = finest; level >= 0; --level) {
      const Scalar radius = take_level(r, body, level, finest, largest);
      if (positions_.empty()) continue;
      builder_.sort(positions_.data(), static_cast<std::int32_t>(positions_.size() / dim), domain,
                    static_cast<double>(2 * radius + skin), slots_);
      // The level's bodies get slots in the builder's order, images get none.
      for (std::size_t k = 0; k < slots_.size(); ++k) {
        if (!builder_.is_home(k)) continue;
        const std::int32_t i = body_at(static_cast<std::int32_t>(k));
        slot[static_cast<std::size_t>(i)] = static_cast<std::int32_t>(order.size());
        Scalar* const to = &placed[4 * order.size()];
        for (int a = 0; a < dim; ++a) to[a] = r(a, i);
        to[3] = body.radius[i];
        order.push_back(i);
      }
      Relay relay;  // storing pairs may fail to allocate
      for_each_share(order.size(), 1, shared_from / 64, [&](const Share& own) {
        relay.run([&] { look_around(own, static_cast<double>(radius + skin)); });
      });
      relay.rethrow();
    }
    pairs.built_at.resize(3 * n);
    for (std::size_t s = 0; s < n; ++s)
      std::copy_n(&placed[4 * s], 3, pairs.built_at.begin() + static_cast<std::ptrdiff_t>(3 * s));
    pairs.bodies.assign(body, std::move(order));
    pairs.skin = skin;
    pairs.number = next_serial();
    sort(pairs);
  }
  /// Distances computed by the last search.
  [[nodiscard]] std::uint64_t pairs_tested() const {
    std::uint64_t sum = 0;
    for (const Found& found : found_) sum += found.tested;
    return sum;
  }

  /// Finds the pairs of a few bodies that have moved, while the others stay where they were. False where finding all anew is less work.
  /// @param r      dim × N, in the user's order [length]
  /// @param moved  slots, ascending
  [[nodiscard]] bool find_late(const auto& r, const auto& body, const std::vector<std::int32_t>& moved,
                               ContactPlaces<Scalar>& places) {
    using Stray = typename ContactPlaces<Scalar>::Stray;
    const ContactPairs<Scalar>& pairs = *places.pairs;
    if (pairs_ != pairs.number) look_at(pairs, domain_of(body.box));
    if (levels_ > 1 || 64 * (places.strays.size() + moved.size()) > pairs.bodies.size() + 4096) return false;
    const auto has_moved = [&](std::int32_t s) { return std::binary_search(moved.begin(), moved.end(), s); };
    std::erase_if(places.strays, [&](const Stray& one) { return has_moved(one.slot); });
    for (const std::int32_t s : moved) {
      Stray& stray = places.strays.emplace_back(Stray{s, {}});
      for (std::size_t a = 0; a < dim; ++a)
        stray.at[a] = r(static_cast<Eigen::Index>(a), pairs.bodies.particle[static_cast<std::size_t>(s)]);
    }
    std::sort(places.strays.begin(), places.strays.end(),
              [](const Stray& a, const Stray& b) { return a.slot < b.slot; });
    const auto place_of = [&](std::int32_t s) {
      const Stray* const stray = places.stray(s);
      const Scalar* const x = stray != nullptr ? stray->at.data() : &pairs.built_at[3 * static_cast<std::size_t>(s)];
      return Triple<Scalar>{x[0], x[1], x[2]};
    };
    const auto nearest = nearest_image<Scalar>(pairs.period);
    const auto reach_each_other = [&](std::int32_t p, std::int32_t q) {
      const Triple<Scalar> apart = nearest(place_of(p) - place_of(q));
      const auto& radius = pairs.bodies.radius;
      const Scalar reach = radius[static_cast<std::size_t>(p)] + radius[static_cast<std::size_t>(q)] + pairs.skin;
      return dot(apart, apart) < reach * reach;
    };
    // Pairs that stay keep their place, by which their springs are known.
    known_.clear();
    std::erase_if(places.late, [&](const auto& pair) {
      if (!has_moved(pair.first) && !has_moved(pair.second)) return false;
      if (!reach_each_other(pair.first, pair.second)) return true;
      known_.emplace_back(pair.first, pair.second);
      return false;
    });
    std::sort(known_.begin(), known_.end());
    places.next = std::max(places.next, static_cast<std::int32_t>(pairs.places()));
    const auto look = [&](std::int32_t p, std::int32_t q) {
      if (!reach_each_other(p, q)) return;
      const std::pair<std::int32_t, std::int32_t> both = std::minmax(p, q);
      if (pairs.find(both.first, both.second) < 0 && !std::binary_search(known_.begin(), known_.end(), both))
        places.late.push_back({places.next++, both.first, both.second});
    };
    typename ListBuilder<dim>::Around around;
    for (const std::int32_t p : moved) {
      std::array<double, dim> x;
      std::copy_n(places.stray(p)->at.begin(), dim, x.begin());
      for (const std::int32_t k : builder_.around(x, range_, around))
        if (const std::int32_t q = body_at(k); places.stray(q) == nullptr) look(p, q);
      for (const auto& other : places.strays)
        if (other.slot != p && !(other.slot < p && has_moved(other.slot))) look(p, other.slot);
    }
    places.number = next_serial();
    return true;
  }

 private:
  /// Pairs that a thread has found, and how many distances it computed for them.
  struct Found {
    std::vector<std::pair<std::int32_t, std::int32_t>> pairs;
    std::uint64_t tested = 0;
  };
  /// The positions of the bodies of a level. Returns their largest radius.
  Scalar take_level(const auto& r, const auto& body, int level, int finest, Scalar largest) {
    members_.clear();
    positions_.clear();
    Scalar radius{0};
    for (Eigen::Index i = 0; i < r.cols(); ++i) {
      if (finest > 0) {
        if (level_of_cells(body.radius[i], largest) != level) continue;
        members_.push_back(static_cast<std::int32_t>(i));
      }
      radius = std::max(radius, body.radius[i]);
      for (int a = 0; a < dim; ++a) positions_.push_back(static_cast<double>(r(a, i)));
    }
    return radius;
  }
  /// The body of one of the builder's slots.
  [[nodiscard]] std::int32_t body_at(std::int32_t k) const {
    const std::int32_t member = slots_[static_cast<std::size_t>(k)].particle;
    return members_.empty() ? member : members_[static_cast<std::size_t>(member)];
  }
  /// By slots, counting.
  void sort(ContactPairs<Scalar>& pairs) {
    const std::size_t n = pairs.bodies.size();
    pairs.row.assign(n + 1, 0);
    for (const Found& found : found_)
      for (const auto& pair : found.pairs) ++pairs.row[static_cast<std::size_t>(pair.first) + 1];
    for (std::size_t s = 0; s < n; ++s) pairs.row[s + 1] += pairs.row[s];
    const std::size_t all = static_cast<std::size_t>(pairs.row[n]) + pairs.padding;
    pairs.first.assign(all, 0), pairs.second.assign(all, 0);
    std::vector<std::int32_t> next = pairs.row;
    for (const Found& found : found_)
      for (const auto& [a, b] : found.pairs) {
        const auto at = static_cast<std::size_t>(next[static_cast<std::size_t>(a)]++);
        pairs.first[at] = a, pairs.second[at] = b;
      }
    for (std::size_t s = 0; s < n; ++s)
      std::sort(pairs.second.begin() + pairs.row[s], pairs.second.begin() + pairs.row[s + 1]);
  }
  /// For find_late: the bodies where the pairs were found, which here are named by their slots there.
  void look_at(const ContactPairs<Scalar>& pairs, const Domain& domain) {
    pairs_ = 0;
    const std::size_t n = pairs.bodies.size();
    positions_.clear(), members_.clear();
    for (std::size_t s = 0; s < n; ++s)
      for (std::size_t a = 0; a < dim; ++a) positions_.push_back(static_cast<double>(pairs.built_at[3 * s + a]));
    const auto [least, largest] = std::minmax_element(pairs.bodies.radius.begin(), pairs.bodies.radius.end());
    levels_ = level_of_cells(*least, *largest) + 1;
    range_ = static_cast<double>(2 * *largest + pairs.skin);
    builder_.sort(positions_.data(), static_cast<std::int32_t>(n), domain, range_, slots_);
    pairs_ = pairs.number;
  }

  ListBuilder<dim> builder_;
  std::vector<NeighborList::Slot> slots_;  // of one level
  std::vector<double> positions_;
  std::vector<std::int32_t> members_;  // of the level; empty where there is one
  std::vector<Found> found_;
  std::vector<std::pair<std::int32_t, std::int32_t>> known_;  // late pairs that stay
  std::uint64_t pairs_ = 0;                                   // pairs compared by find_late
  double range_ = 0;
  int levels_ = 1;
};

}}  // namespace phistep::PHISTEP_ABI

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
#include <type_traits>
#include <utility>
#include <vector>

#include "phistep/base/machine/serial.hpp"
#include "phistep/base/numbers/pack_math.hpp"
#include "phistep/base/version.hpp"
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
/// as wide as its own largest. A body looks for others in the cells of its own level and of the coarser ones, so that the work
/// is proportional to the number of bodies, whatever their sizes. Where radii are within a factor of 2.5, there is one level.
template <class Scalar, int dim>
class ContactSearch {
 public:
  /// All pairs of bodies whose surfaces are nearer than the skin.
  /// @throws std::invalid_argument where a period of the box is so short that two bodies could touch twice
  void find(const auto& r, const auto& body, Scalar skin, ContactPairs<Scalar>& pairs) {
    const Eigen::Index n = r.cols();
    const Domain domain = domain_of(body.box);
    const Scalar largest = n > 0 ? body.radius.maxCoeff() : Scalar{0},
                 least = n > 0 ? body.radius.minCoeff() : Scalar{0};
    const double range = static_cast<double>(2 * largest + skin);
    for (std::size_t a = 0; a < dim; ++a)
      if (n > 0 && domain.periodic[a] && !(domain.length[a] > 2 * range))
        throw std::invalid_argument("phistep: the box's period along axis " + std::to_string(a) + ", " +
                                    std::to_string(domain.length[a]) +
                                    ", must be more than twice the bodies' largest diameter and the skin");
    for (int a = 0; a < 3; ++a)
      pairs.period[a] = a < dim && body.box.is_periodic[static_cast<std::size_t>(std::min(a, dim - 1))]
                            ? body.box.upper[std::min(a, dim - 1)] - body.box.lower[std::min(a, dim - 1)]
                            : Scalar{0};
    const NearestImage<Scalar> nearest{pairs.period};
    std::vector<Scalar> placed(4 * static_cast<std::size_t>(n));  // x y z R of each slot
    const auto reach_each_other = [&](std::int32_t p, std::int32_t q) {
      const Scalar* const x = &placed[4 * static_cast<std::size_t>(p)];
      const Scalar* const o = &placed[4 * static_cast<std::size_t>(q)];
      const Triple<Scalar> apart = nearest({x[0] - o[0], x[1] - o[1], x[2] - o[2]});
      const Scalar reach = x[3] + o[3] + skin;
      return dot(apart, apart) < reach * reach;
    };
    std::vector<std::int32_t> order;
    order.reserve(static_cast<std::size_t>(n));
    slot_.resize(static_cast<std::size_t>(n));
    found_.clear();
    tested_ = 0;
    const int finest = n > 0 ? level_of_cells(least, largest) : -1;
    for (int level = finest; level >= 0; --level) {
      const Scalar radius = take_level(r, body, level, finest, largest);
      if (level_size_ == 0) continue;
      const std::size_t finer = order.size();
      builder_.build(positions_.data(), level_size_, domain, finest == 0 ? body.still : still_,
                     static_cast<double>(2 * radius + skin), 1, list_);
      place(r, body, domain, order, placed);
      find_alike(body, order, largest != least, reach_each_other);
      const std::uint64_t before = builder_.points_tested();
      for (std::size_t s = 0; s < finer; ++s)
        find_coarser(body, domain, order, static_cast<std::int32_t>(s), &placed[4 * s],
                     static_cast<double>(radius + skin), reach_each_other);
      tested_ += list_.pairs_tested() + builder_.points_tested() - before;
    }
    pairs.built_at.resize(3 * order.size());
    for (std::size_t s = 0; s < order.size(); ++s)
      std::copy_n(&placed[4 * s], 3, pairs.built_at.begin() + static_cast<std::ptrdiff_t>(3 * s));
    pairs.bodies.assign(body, std::move(order));
    pairs.skin = skin;
    pairs.number = next_serial();
    sort(pairs);
  }
  /// Distances computed by the last search.
  [[nodiscard]] std::uint64_t pairs_tested() const { return tested_; }

 private:
  /// The positions of the bodies of a level. Returns their largest radius.
  Scalar take_level(const auto& r, const auto& body, int level, int finest, Scalar largest) {
    members_.clear();
    still_.clear();
    positions_.clear();
    Scalar radius{0};
    for (Eigen::Index i = 0; i < r.cols(); ++i) {
      if (finest > 0) {
        if (level_of_cells(body.radius[i], largest) != level) continue;
        members_.push_back(static_cast<std::int32_t>(i));
        if (!body.still.empty()) still_.push_back(body.still[static_cast<std::size_t>(i)]);
      }
      radius = std::max(radius, body.radius[i]);
      for (int a = 0; a < dim; ++a) positions_.push_back(static_cast<double>(r(a, i)));
    }
    level_size_ = static_cast<std::int32_t>(positions_.size() / dim);
    return radius;
  }
  /// The body of a slot of the level's list.
  [[nodiscard]] std::int32_t body_at(std::int32_t of_list) const {
    const std::int32_t member = list_.slots[static_cast<std::size_t>(of_list)].particle;
    return members_.empty() ? member : members_[static_cast<std::size_t>(member)];
  }
  [[nodiscard]] std::int32_t slot_at(std::int32_t of_list) const {
    return slot_[static_cast<std::size_t>(body_at(of_list))];
  }

  /// Slots in the order of those where the list has the bodies themselves, not their images.
  void place(const auto& r, const auto& body, const Domain& domain, std::vector<std::int32_t>& order,
             std::vector<Scalar>& placed) {
    for (std::size_t k = 0; k < list_.slots.size(); ++k) {
      const auto& slot = list_.slots[k];
      if (slot.particle < 0) continue;  // a dummy
      bool home = true;
      for (std::size_t a = 0; a < dim; ++a)
        home &= slot.image[a] == domain.image(a, positions_[static_cast<std::size_t>(slot.particle) * dim + a]);
      if (!home) continue;
      const std::int32_t i = body_at(static_cast<std::int32_t>(k));
      slot_[static_cast<std::size_t>(i)] = static_cast<std::int32_t>(order.size());
      Scalar* const to = &placed[4 * order.size()];
      for (int a = 0; a < dim; ++a) to[a] = r(a, i);
      to[3] = body.radius[i];
      order.push_back(i);
    }
  }

  /// The pairs of bodies of the level, each once.
  void find_alike(const auto& body, const std::vector<std::int32_t>& order, bool sizes_differ,
                  auto&& reach_each_other) {
    list_.for_each_neighbor([&](const NeighborList::Row& row, std::int32_t neighbor) {
      const std::int32_t p = slot_at(row.slot), q = slot_at(neighbor);
      const bool has_row = !body.is_still(order[static_cast<std::size_t>(q)]);  // then the pair is in that row, too
      if (p == q || (has_row && q < p)) return;
      if (!sizes_differ || reach_each_other(p, q)) found_.push_back(std::minmax(p, q));
    });
  }
  /// The pairs of a body of a finer level, in slot p, with those of this one.
  /// @param at     x y z R
  /// @param reach  [length] the largest radius of this level, and the skin
  void find_coarser(const auto& body, const Domain& domain, const std::vector<std::int32_t>& order, std::int32_t p,
                    const Scalar* at, double reach, auto&& reach_each_other) {
    std::array<double, dim> x;
    for (std::size_t a = 0; a < dim; ++a) {
      x[a] = static_cast<double>(at[a]);
      x[a] += domain.image(a, x[a]) * domain.length[a];
    }
    const bool is_still = body.is_still(order[static_cast<std::size_t>(p)]);
    for (const std::int32_t neighbor : builder_.around(x, static_cast<double>(at[3]) + reach)) {
      const bool two_still = is_still && body.is_still(body_at(neighbor));
      if (const std::int32_t q = slot_at(neighbor); !two_still && reach_each_other(p, q)) found_.emplace_back(p, q);
    }
  }

  /// By slots, counting.
  void sort(ContactPairs<Scalar>& pairs) {
    const std::size_t n = pairs.bodies.size();
    pairs.row.assign(n + 1, 0);
    for (const auto& pair : found_) ++pairs.row[static_cast<std::size_t>(pair.first) + 1];
    for (std::size_t s = 0; s < n; ++s) pairs.row[s + 1] += pairs.row[s];
    pairs.first.assign(found_.size() + pairs.padding, 0);
    pairs.second.assign(found_.size() + pairs.padding, 0);
    next_.assign(pairs.row.begin(), pairs.row.end());
    for (const auto& [a, b] : found_) {
      const auto at = static_cast<std::size_t>(next_[static_cast<std::size_t>(a)]++);
      pairs.first[at] = a;
      pairs.second[at] = b;
    }
    for (std::size_t s = 0; s < n; ++s)
      std::sort(pairs.second.begin() + pairs.row[s], pairs.second.begin() + pairs.row[s + 1]);
  }

  ListBuilder<dim> builder_;
  NeighborList list_;  // of one level
  std::vector<double> positions_;
  std::vector<std::int32_t> members_;  // of the level; empty where there is one
  std::vector<std::uint8_t> still_;
  std::int32_t level_size_ = 0;
  std::vector<std::int32_t> slot_, next_;
  std::vector<std::pair<std::int32_t, std::int32_t>> found_;
  std::uint64_t tested_ = 0;
};

}}  // namespace phistep::PHISTEP_ABI

/// @file
/// Finds the pairs of contact_pairs.hpp, by the neighbour list's cells.
#pragma once

#include <Eigen/Core>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "phistep/contacts/contact_kernel.hpp"
#include "phistep/contacts/contact_pairs.hpp"
#include "phistep/core/version.hpp"
#include "phistep/neighbors/domain.hpp"
#include "phistep/neighbors/list_builder.hpp"
#include "phistep/neighbors/neighbor_list.hpp"
#include "phistep/simd/pack_math.hpp"

namespace phistep::inline PHISTEP_ABI {

/// A workspace, its buffers serve again.
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
                                    ", must be more than twice the bodies' largest diameter");
    positions_.resize(static_cast<std::size_t>(dim * n));
    for (Eigen::Index k = 0; k < dim * n; ++k)
      positions_[static_cast<std::size_t>(k)] = static_cast<double>(r.data()[k]);
    list_.rows.clear();
    if (n > 0) builder_.build(positions_.data(), static_cast<std::int32_t>(n), domain, body.still, range, 1, list_);
    else list_.slots.clear();
    place(n, domain, body, pairs);
    pairs.skin = skin;
    pairs.number = next_body_serial();
    pairs.built_at.assign(static_cast<std::size_t>(4 * n), Scalar{0});
    for (std::size_t s = 0; s < pairs.bodies.size(); ++s)
      for (int a = 0; a < dim; ++a)
        pairs.built_at[4 * s + static_cast<std::size_t>(a)] = r(a, pairs.bodies.particle[s]);
    for (int a = 0; a < 3; ++a)
      pairs.period[a] = a < dim && body.box.is_periodic[static_cast<std::size_t>(std::min(a, dim - 1))]
                            ? body.box.upper[std::min(a, dim - 1)] - body.box.lower[std::min(a, dim - 1)]
                            : Scalar{0};
    collect(pairs, largest != least, skin);
  }

 private:
  /// Slots in the order of those where the list has the bodies themselves, not their images.
  void place(Eigen::Index n, const Domain& domain, const auto& body, ContactPairs<Scalar>& pairs) {
    std::vector<std::int32_t> order;
    order.reserve(static_cast<std::size_t>(n));
    slot_.resize(static_cast<std::size_t>(n));
    for (const auto& slot : list_.slots) {
      bool home = true;
      for (std::size_t a = 0; a < dim; ++a)
        home &= slot.image[a] == domain.image(a, positions_[static_cast<std::size_t>(slot.particle) * dim + a]);
      if (!home) continue;
      slot_[static_cast<std::size_t>(slot.particle)] = static_cast<std::int32_t>(order.size());
      order.push_back(slot.particle);
    }
    pairs.bodies.assign(body, std::move(order));
  }

  /// Each pair once, sorted by counting.
  void collect(ContactPairs<Scalar>& pairs, bool sizes_differ, Scalar skin) {
    const std::size_t n = pairs.bodies.size();
    found_.clear();
    pairs.row.assign(n + 1, 0);
    const NearestImage<Scalar> nearest{pairs.period};
    for (std::size_t r = 0; r < list_.rows.size(); ++r) {
      const std::int32_t i =
          slot_[static_cast<std::size_t>(list_.slots[static_cast<std::size_t>(list_.rows[r].slot)].particle)];
      for (const std::int32_t neighbor : list_.neighbors(r)) {
        const std::int32_t j =
            slot_[static_cast<std::size_t>(list_.slots[static_cast<std::size_t>(neighbor)].particle)];
        const auto p = static_cast<std::size_t>(i), q = static_cast<std::size_t>(j);
        const bool has_row = pairs.bodies.inverse_mass[q] > 0;  // then the pair is in that row, too
        if (i == j || (has_row && j < i)) continue;
        if (sizes_differ) {
          const Scalar *const x = &pairs.built_at[4 * p], *const o = &pairs.built_at[4 * q];
          const Triple<Scalar> d = nearest({x[0] - o[0], x[1] - o[1], x[2] - o[2]});
          const Scalar reach = pairs.bodies.radius[p] + pairs.bodies.radius[q] + skin;
          if (!(dot(d, d) < reach * reach)) continue;
        }
        found_.push_back(std::minmax(i, j));
        ++pairs.row[static_cast<std::size_t>(std::min(i, j)) + 1];
      }
    }
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
  NeighborList list_;
  std::vector<double> positions_;
  std::vector<std::int32_t> slot_, next_;
  std::vector<std::pair<std::int32_t, std::int32_t>> found_;
};

}  // namespace phistep::inline PHISTEP_ABI

/// @file
/// Which of the pairs touch: by positions alone.
#pragma once

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <vector>

#include "phistep/contacts/computed_pairs.hpp"
#include "phistep/contacts/contact_kernel.hpp"
#include "phistep/contacts/contact_pairs.hpp"
#include "phistep/contacts/contact_slots.hpp"
#include "phistep/contacts/spring_table.hpp"
#include "phistep/core/shares.hpp"
#include "phistep/core/version.hpp"
#include "phistep/simd/pack.hpp"

namespace phistep::inline PHISTEP_ABI {

/// A workspace, its buffers serve again.
template <class Scalar>
class TouchingPairs {
  static constexpr int width = native_width<Scalar>;
  using P = Pack<Scalar, width>;
  using Springs = SpringTable<Scalar>;

 public:
  std::vector<std::int32_t> from;  ///< of each contact, where its springs stand in the table before
  std::vector<std::int32_t> i, j;  ///< and its slots

  /// Fills the table with the contacts' places, and makes room for their springs.
  /// @param period  of the box, as in ContactPairs
  void find(const Scalar (&period)[3], const PairRange& pairs, const ContactSlots<Scalar>& slots, const Springs& before,
            Springs& table, bool with_roll) {
    const std::size_t count = pairs.count;
    const NearestImage<P> nearest{period};
    const Shares shares{count, width};
    auto& contact = table.place;
    for (auto* array : {&contact, &from, &i, &j}) array->resize(count + width);
    found_.assign(Shares::threads(), 0);
    // Threads write where their own pairs stand; then the gaps are closed.
#ifdef _OPENMP
#pragma omp parallel for schedule(static, 1)
#endif
    for (std::size_t t = 0; t < found_.size(); ++t)
      found_[t] = find(nearest, pairs, slots, before, shares.begin(t), shares.end(t), contact.data());
    std::vector<std::int32_t>* const arrays[] = {&contact, &from, &i, &j};
#ifdef _OPENMP
#pragma omp parallel for schedule(static, 1) if (found_.size() > 1)
#endif
    for (std::size_t a = 0; a < 4; ++a) {
      auto to = arrays[a]->begin() + static_cast<std::ptrdiff_t>(found_[0]);
      for (std::size_t t = 1; t < found_.size(); ++t) {
        const auto begin = arrays[a]->begin() + static_cast<std::ptrdiff_t>(shares.begin(t));
        to = std::copy(begin, begin + static_cast<std::ptrdiff_t>(found_[t]), to);
      }
    }
    const std::size_t found = std::accumulate(found_.begin(), found_.end(), std::size_t{0});
    table.resize(found, with_roll);
    // Whole packs: those beyond the last contact repeat its slots, and find springs that are unstretched.
    std::fill_n(from.begin() + static_cast<std::ptrdiff_t>(found), width, static_cast<std::int32_t>(before.size()));
    for (auto* array : {&i, &j})
      std::fill_n(array->begin() + static_cast<std::ptrdiff_t>(found), width, found > 0 ? (*array)[found - 1] : 0);
  }

 private:
  /// Among the pairs begin … end − 1; returns how many.
  [[gnu::flatten]] std::size_t find(const NearestImage<P>& nearest, const PairRange& pairs,
                                    const ContactSlots<Scalar>& slots, const Springs& before, std::size_t begin,
                                    std::size_t end, std::int32_t* contact) {
    SpringFinder springs_of{before.place, begin < end ? pairs.number(begin) : 0};
    const Scalar* const position = slots.position.data();
    std::int32_t *const to_from = from.data(), *const to_i = i.data(), *const to_j = j.data();
    std::size_t found = begin;
    for (std::size_t p = begin; p < end; p += width) {
      const auto a = gather4<P>(position, &pairs.first[p]);
      const auto b = gather4<P>(position, &pairs.second[p]);
      const Triple<P> d = nearest({a.x - b.x, a.y - b.y, a.z - b.z});
      const P reach = a.w + b.w;
      unsigned touching = (dot(d, d) < reach * reach).bits();
      if (end - p < width) touching &= (1u << (end - p)) - 1u;
      while (touching != 0) {
        const std::size_t at = p + static_cast<std::size_t>(std::countr_zero(touching));
        touching &= touching - 1;
        const std::int32_t place = pairs.number(at);
        contact[found] = place;
        to_from[found] = springs_of(place);
        to_i[found] = pairs.first[at];
        to_j[found] = pairs.second[at];
        ++found;
      }
    }
    return found - begin;
  }

  std::vector<std::size_t> found_;  // contacts, by each thread
};

}  // namespace phistep::inline PHISTEP_ABI

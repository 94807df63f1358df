/// @file
/// Which of the pairs touch: by positions alone.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "phistep/base/machine/scratch.hpp"
#include "phistep/base/machine/shares.hpp"
#include "phistep/base/numbers/pack.hpp"
#include "phistep/base/version.hpp"
#include "phistep/particles/contacts/computed_pairs.hpp"
#include "phistep/particles/contacts/contact_kernel.hpp"
#include "phistep/particles/contacts/contact_pairs.hpp"
#include "phistep/particles/contacts/contact_slots.hpp"
#include "phistep/particles/contacts/spring_table.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

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
    const NearestImage<P> nearest{period};
    if (i.size() < pairs.count + width) resize_with_spare(i, pairs.count + width);
    found_.assign(thread_count(), {});
    // Threads write the numbers of those that touch into i, from where their own pairs begin; then the gaps are closed.
    for_each_share(pairs.count, width, shared_from / 64, [&](const Share& own) {
      found_[own.number] = {own.begin, find(nearest, pairs, slots, own.begin, own.end)};
    });
    std::size_t found = 0;
    for (const auto& [begin, end] : found_) {
      if (begin != found) std::copy(i.data() + begin, i.data() + end, i.data() + found);
      found += end - begin;
    }
    table.resize(found, with_roll);
    for (auto* array : {&from, &j}) resize_with_spare(*array, found + width);
    for_each_share(found, 1, shared_from / 64, [&](const Share& own) {
      if (own.begin == own.end) return;
      SpringFinder springs_of{before.place, pairs.number(static_cast<std::size_t>(i[own.begin]))};
      for (std::size_t c = own.begin; c < own.end; ++c) {
        const auto p = static_cast<std::size_t>(i[c]);
        table.place[c] = pairs.number(p);
        from[c] = springs_of(table.place[c]);
        i[c] = pairs.first[p];
        j[c] = pairs.second[p];
      }
    });
    // Whole packs: those beyond the last contact repeat its slots, and find springs that are unstretched.
    std::fill_n(from.begin() + static_cast<std::ptrdiff_t>(found), width, static_cast<std::int32_t>(before.size()));
    for (auto* array : {&i, &j})
      std::fill_n(array->begin() + static_cast<std::ptrdiff_t>(found), width, found > 0 ? (*array)[found - 1] : 0);
  }

 private:
  /// Among the pairs begin … end − 1; returns where those end that are written from `begin` on.
  [[gnu::flatten]] std::size_t find(const NearestImage<P>& nearest, const PairRange& pairs,
                                    const ContactSlots<Scalar>& slots, std::size_t begin, std::size_t end) {
    const Scalar* const position = slots.position.data();
    std::int32_t* to = i.data() + begin;
    for (std::size_t p = begin; p < end; p += width) {
      const auto a = gather4<P>(position, &pairs.first[p]);
      const auto b = gather4<P>(position, &pairs.second[p]);
      const Triple<P> d = nearest({a.x - b.x, a.y - b.y, a.z - b.z});
      const P reach = a.w + b.w;
      unsigned touching = (dot(d, d) < reach * reach).bits();
      if (end - p < width) touching &= (1u << (end - p)) - 1u;
      for (; touching != 0; touching &= touching - 1)
        *to++ = static_cast<std::int32_t>(p + static_cast<std::size_t>(std::countr_zero(touching)));
    }
    return static_cast<std::size_t>(to - i.data());
  }

  std::vector<std::array<std::size_t, 2>> found_;  // contacts, by each thread: from, and to one before
};

}}  // namespace phistep::PHISTEP_ABI

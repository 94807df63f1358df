/// @file
/// How springs get from one table to the next where bodies, or the list of pairs, change.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include "phistep/base/numbers/finite_witness.hpp"
#include "phistep/base/version.hpp"
#include "phistep/particles/contacts/contact_kernel.hpp"
#include "phistep/particles/contacts/spring_table.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// Springs of contacts that are not computed for now, because both bodies are held still: kept until it moves again.
template <class Scalar>
struct DormantSprings {
  struct Contact {
    std::int64_t a, b;                 ///< identities of two bodies, or of a body and the number of its wall
    std::array<Scalar, 3> slip, roll;  ///< as a sees them
  };
  std::vector<Contact> contacts;
  void archive(auto& ar) {
    ar.columns("contacts", contacts, "a", &Contact::a, "b", &Contact::b, "slip", &Contact::slip, "roll",
               &Contact::roll);
    for (const Contact& one : contacts) ar.check(all_finite(one.slip.data(), 3) && all_finite(one.roll.data(), 3));
  }
};

/// Springs on their way into a new table, or to rest.
template <class Table>
class CarriedSprings {
  using Scalar = typename Table::Scalar;
  using Springs = ContactSprings<Scalar>;
  using Dormant = DormantSprings<Scalar>;

 public:
  /// f(a, b, springs) for those that lie dormant
  static void for_each(const Dormant& dormant, auto&& f) {
    const auto triple = [](const std::array<Scalar, 3>& x) { return Triple<Scalar>{x[0], x[1], x[2]}; };
    for (const auto& one : dormant.contacts) f(one.a, one.b, Springs{triple(one.slip), triple(one.roll)});
  }
  /// f(c, springs) for those of a table
  static void for_each(const Table& table, auto&& f) {
    for (std::size_t c = 0; c < table.size(); ++c) f(c, Springs{table.slip[c], table.roll[c]});
  }

  /// To places in any order.
  void carry_to(typename Table::Place place, const Springs& springs) { carried_.push_back({place, springs}); }
  void lay_down(std::int64_t a, std::int64_t b, const Springs& springs) {
    const auto array = [](const Triple<Scalar>& x) { return std::array<Scalar, 3>{x.x, x.y, x.z}; };
    asleep_.contacts.push_back({a, b, array(springs.slip), array(springs.roll)});
  }
  /// @param rolls    whether there are springs of rolling
  /// @param dormant  those known so far, or none; replaced where they change
  void finish(Table& table, bool rolls, std::shared_ptr<const Dormant>& dormant) {
    std::sort(carried_.begin(), carried_.end(), [](const Carried& a, const Carried& b) { return a.place < b.place; });
    table.resize(carried_.size(), rolls);
    for (std::size_t c = 0; c < carried_.size(); ++c) {
      table.place[c] = carried_[c].place;
      table.slip.set(c, carried_[c].springs.slip);
      if (rolls) table.roll.set(c, carried_[c].springs.roll);
    }
    table.close();
    if ((dormant && !dormant->contacts.empty()) || !asleep_.contacts.empty())
      dormant = std::make_shared<const Dormant>(std::move(asleep_));
  }

 private:
  struct Carried {
    typename Table::Place place;
    Springs springs;
  };
  std::vector<Carried> carried_;
  Dormant asleep_;
};

}}  // namespace phistep::PHISTEP_ABI

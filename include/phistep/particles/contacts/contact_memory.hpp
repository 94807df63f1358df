/// @file
/// What contacts remember: where bodies may touch, and how far the springs of those that do are stretched.
///
/// A spring's length ξ is known at a time t_c. An evaluation at (t_e, Y) starts from it and never changes it, whatever
/// Newton asks for and however often a step is rejected: it leaves its own ξ(t_e) beside. Where a step was made of one
/// evaluation, that becomes the memory when the step is accepted, and t_c = t_e; otherwise ξ is computed once more, for the
/// accepted state, and t_c is the end of the step.
#pragma once

#include <cmath>
#include <cstdint>
#include <memory>
#include <type_traits>
#include <utility>
#include <vector>

#include "phistep/base/version.hpp"
#include "phistep/particles/contacts/carried_springs.hpp"
#include "phistep/particles/contacts/resting_springs.hpp"
#include "phistep/particles/contacts/spring_table.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// The history of a force with contacts, as a value: copies share what they point to, which is never changed.
/// @tparam Places  enumerates where there may be contacts
/// @tparam Place   the number of one
template <class Scalar, class Places, class Place = std::int32_t>
struct ContactMemory {
  using Table = SpringTable<Scalar, Place>;

  // An evaluation may find that the places must be enumerated anew, and leaves its springs: hence mutable. What a step
  // commits or drops is always the trial's.
  mutable std::shared_ptr<const Places> places;
  mutable std::shared_ptr<const Table> springs;                   ///< ξ(t_c), for `places`
  mutable std::shared_ptr<const Table> last;                      ///< ξ(t_e) of the last evaluation, likewise
  mutable std::shared_ptr<const DormantSprings<Scalar>> dormant;  ///< of none, where there is nothing
  mutable std::shared_ptr<const RestingSprings<Table>> resting;   ///< of contacts left out for now, or none
  mutable std::uint64_t active = 0;      ///< number of the set that `springs` are those of; 0: all
  mutable std::uint64_t body = 0;        ///< serial number of what `places` were enumerated for
  mutable Scalar last_time = 0;          ///< t_e
  mutable std::int64_t evaluations = 0;  ///< since the step began
  Scalar time = 0;                       ///< where the step began, or the last one ended
  Scalar step = 0;                       ///< Δt
  Scalar lag = 0;                        ///< time − t_c

  void begin(Scalar t, Scalar dt) {
    time = t;
    step = dt;
    evaluations = 0;
    last.reset();
  }
  /// Time since the springs were known. As a sum of lags rather than a difference of times: exactly Δt where it should be.
  [[nodiscard]] Scalar elapsed(Scalar t) const { return lag + (t - time); }
  void remember(Scalar t, std::shared_ptr<const Table> found) const {
    last = std::move(found);
    last_time = t;
    ++evaluations;
  }
  /// At the end of an accepted step. @param springs_now  computes them for the accepted state; called where there
  /// were several evaluations
  void commit(auto&& springs_now) {
    if (evaluations > 1) {
      springs = springs_now();
      lag = 0;
    } else if (evaluations == 1) {
      springs = std::move(last);
      lag = step - (last_time - time);
    } else {
      lag += step;
    }
    time += step;
    last.reset();
  }
  /// From now on the springs of an active set's contacts are computed, the others rest.
  /// @param number       of the set; 0: all are computed
  /// @param is_computed  of a place; not asked where all are
  /// @param tables       makes room for them
  /// @param before       number of a set for which `joined` holds; 0: of none
  /// @param joined       places, ascending, that are computed now and were not for that set
  void part(std::uint64_t number, auto&& is_computed, RecycledSprings<Table>& tables, std::uint64_t before = 0,
            const std::vector<Place>& joined = {}) const {
    if (number == active || springs == nullptr) return;
    const auto goes_on = [&](Place place) { return number == 0 || is_computed(place); };
    auto computed = tables.take();
    const bool is_small = resting && resting->late.size() <= 256 + resting->base->size() / 8;
    auto rest = number != 0 && before != 0 && before == active && is_small
                    ? part_some_springs(*springs, *resting, joined, goes_on, *computed, tables)
                    : part_all_springs(*springs, resting.get(), goes_on, *computed, tables);
    springs = std::move(computed);
    resting = number == 0 ? nullptr : std::move(rest);
    active = number;
  }
  /// All of them are computed again.
  void join(RecycledSprings<Table>& tables) const {
    part(
        0, [](auto) { return true; }, tables);
  }
  /// The places serve bodies that were copied or came with a checkpoint, too; the springs may be another force's.
  void adopt(std::uint64_t serial, bool rolls, RecycledSprings<Table>& tables) const {
    body = serial;
    if (springs->rolls() == rolls) return;
    join(tables);
    auto with_or_without = std::make_shared<Table>(*springs);
    with_or_without->resize(springs->size(), rolls);
    with_or_without->close();
    springs = std::move(with_or_without);
  }

  void archive(auto& ar) {
    Places its_places = places ? *places : Places{};
    ContactMemory whole = *this;
    RecycledSprings<Table> tables;
    whole.join(tables);
    Table its_springs = springs ? *whole.springs : Table{};
    DormantSprings<Scalar> its_dormant = dormant ? *dormant : DormantSprings<Scalar>{};
    ar("places", its_places, "springs", its_springs, "dormant", its_dormant, "time", time, "step", step, "lag", lag);
    ar.check(std::isfinite(time) && std::isfinite(step) && std::isfinite(lag));
    if constexpr (std::remove_reference_t<decltype(ar)>::reading) {
      for (const auto place : its_springs.place) ar.check(its_places.has(place));
      last.reset();
      resting.reset();
      active = body = 0;
      evaluations = 0;
      // The next evaluation compares them with its particles.
      places = std::make_shared<const Places>(std::move(its_places));
      springs = std::make_shared<const Table>(std::move(its_springs));
      dormant = std::make_shared<const DormantSprings<Scalar>>(std::move(its_dormant));
    }
  }
};

}}  // namespace phistep::PHISTEP_ABI

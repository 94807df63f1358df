/// @file
/// What contacts remember: where bodies may touch, and how far the springs of those that do are stretched.
///
/// A spring's length ξ is known at a time t_c. An evaluation at (t_e, Y) starts from it and never changes it, whatever
/// Newton asks for and however often a step is rejected: it leaves its own ξ(t_e) beside. Where a step was made of one
/// evaluation, that becomes the memory when the step is accepted, and t_c = t_e; otherwise ξ is computed once more, for the
/// accepted state, and t_c is the end of the step.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <type_traits>
#include <utility>
#include <vector>

#include "phistep/base/facts/structure.hpp"
#include "phistep/base/machine/memory.hpp"
#include "phistep/force/sum.hpp"
#include "phistep/particles/contacts/spring_table.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// The springs of contacts that are not computed: between bodies outside the active set, or held still. When the set changes, few
/// springs change sides. Most therefore stay in a table that never changes and that several histories share, the base. Bits mark the
/// springs removed from it since; a small table holds those added since. When that has grown, both are merged into a new base.
template <class Table>
struct RestingSprings {
  std::shared_ptr<const Table> base;
  std::vector<std::uint64_t> taken;  ///< a bit for each contact of the base: its spring was removed
  Table late;                        ///< the springs added since

  [[nodiscard]] bool is_taken(std::size_t c) const { return (taken[c / 64] >> (c % 64) & 1) != 0; }
  void take(std::size_t c) { taken[c / 64] |= std::uint64_t{1} << (c % 64); }
};

/// Memory for reuse: tables, old and new bases among them, the springs at rest that refer to them, and what goes into either.
template <class Table>
struct RecycledSprings : Recycled<Table, 6> {
  Recycled<RestingSprings<Table>> resting;
  CarriedSprings<Table> to_compute, to_rest;
};

/// The history of a force with contacts, as a value: copies share what they point to, which is never changed.
/// @tparam Table   of springs
/// @tparam Places  enumerates where there may be contacts
template <class Table, class Places>
struct ContactMemory {
  using Scalar = typename Table::Scalar;
  using Place = typename Table::Place;

  // An evaluation may find that the places must be enumerated anew, and leaves its springs: hence mutable. What a step
  // commits or drops is always the trial's.
  mutable std::shared_ptr<const Places> places;
  mutable std::shared_ptr<const Table> springs;                  ///< ξ(t_c), for `places`
  mutable std::shared_ptr<const Table> last;                     ///< ξ(t_e) of the last evaluation, likewise
  mutable std::shared_ptr<const RestingSprings<Table>> resting;  ///< of contacts left out for now, or none
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
  /// t, or where the last step has ended, unless t is within a step of that.
  [[nodiscard]] Scalar near_by(Scalar t) const { return std::abs(t - time) <= std::abs(step) ? t : time; }
  void remember(Scalar t, std::shared_ptr<const Table> found) const {
    last = std::move(found);
    last_time = t;
    ++evaluations;
  }
  /// Takes over the springs of an accepted step. @param springs_now  computes those of the accepted state; called where
  /// there were several evaluations
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
  /// From now on the springs of an active set's contacts are computed, the others rest. Where few have changed sides the base remains.
  /// @param number       of the set; 0: all are computed
  /// @param is_computed  of a place; not asked where all are
  /// @param tables       makes room for them
  /// @param joined       places, ascending, that are computed now and were not for the set before; null: not known
  void part(std::uint64_t number, auto&& is_computed, RecycledSprings<Table>& tables,
            const std::vector<Place>* joined = nullptr) const {
    if (number == active || springs == nullptr) return;
    const bool rolls = springs->rolls();
    const auto sort = [&](const Table& from, std::size_t c) {
      (number == 0 || is_computed(from.place[c]) ? tables.to_compute : tables.to_rest).add(from.place[c], from[c]);
    };
    const auto sort_all = [&](const Table& from) {
      for (std::size_t c = 0; c < from.size(); ++c) sort(from, c);
      tables.to_compute.end_run(), tables.to_rest.end_run();
    };
    sort_all(*springs);
    auto rest = tables.resting.take();
    bool base_remains = false;
    if (resting != nullptr) {
      sort_all(resting->late);
      const Table& base = *resting->base;
      base_remains = number != 0 && resting->late.size() <= 256 + base.size() / 32;
      rest->taken = resting->taken;
      const auto look_at = [&](std::size_t c) {
        if (resting->is_taken(c) || (base_remains && !is_computed(base.place[c]))) return;
        sort(base, c);
        rest->take(c);
      };
      if (base_remains && joined != nullptr) {
        auto at = base.place.begin();
        for (const Place place : *joined) {
          at = std::lower_bound(at, base.place.end(), place);
          if (at == base.place.end()) break;
          if (*at == place) look_at(static_cast<std::size_t>(at - base.place.begin()));
        }
      } else {
        for (std::size_t c = 0; c < base.size(); ++c) look_at(c);
      }
      tables.to_compute.end_run(), tables.to_rest.end_run();
    }
    auto computed = tables.take();
    tables.to_compute.lay_into(*computed, rolls);
    if (base_remains) {
      rest->base = resting->base;
    } else {
      auto base = tables.take();
      tables.to_rest.lay_into(*base, rolls);
      rest->taken.assign(base->size() / 64 + 1, 0);
      rest->base = std::move(base);
    }
    tables.to_rest.lay_into(rest->late, rolls);
    springs = std::move(computed);
    resting = number == 0 ? nullptr : std::move(rest);
    active = number;
  }
  /// All of them are computed again.
  void join(RecycledSprings<Table>& tables) const {
    part(
        0, [](auto) { return true; }, tables);
  }
  /// The springs of the same contacts, found by the bodies' identities, in other places. New ones begin unstretched.
  /// @param serial  of what `to` was enumerated for
  /// @param rolls   whether there are springs of rolling
  void move_to(std::shared_ptr<const Places> to, std::uint64_t serial, bool rolls,
               RecycledSprings<Table>& tables) const {
    join(tables);
    CarriedSprings<Table> carried;
    const auto carry = to->carrier(carried);
    for (std::size_t c = 0; places && c < springs->size(); ++c) {
      const auto [a, b] = places->names(springs->place[c]);
      carry(a, b, (*springs)[c]);
    }
    auto table = tables.take();
    carried.lay_into(*table, rolls);
    springs = std::move(table);
    places = std::move(to);
    body = serial;
  }
  /// The places serve bodies that were copied or came with a checkpoint, too; the springs may be another force's.
  void adopt(std::uint64_t serial, bool rolls, RecycledSprings<Table>& tables) const {
    if (springs->rolls() != rolls) move_to(places, serial, rolls, tables);
    body = serial;
  }

  void archive(auto& ar) {
    Places its_places = places ? *places : Places{};
    ContactMemory whole = *this;
    RecycledSprings<Table> tables;
    whole.join(tables);
    Table its_springs = springs ? *whole.springs : Table{};
    ar("places", its_places, "springs", its_springs, "time", time, "step", step, "lag", lag);
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
    }
  }
};

/// A force of contacts. It depends on the time since the springs were known.
struct ContactTerm : ForceTerm {
  static constexpr bool uses_velocity = true, uses_time = true, computes_active_only = true;
  static constexpr bool has_edges = true, is_symmetric = true;
  static constexpr Structure structure = Structure::network;

  static void begin(auto t, auto dt, const auto& /*y*/, auto& memory) { memory.begin(t, dt); }
};

}}  // namespace phistep::PHISTEP_ABI

/// @file
/// What contacts remember: who is near whom, and how far the springs of those that touch are stretched.
///
/// A spring's length ξ is known at a time t_c. An evaluation at (t_e, Y) starts from it and never changes it, whatever
/// Newton asks for and however often a step is rejected: it leaves its own ξ(t_e) beside. Where a step was made of one
/// evaluation, that becomes the memory when the step is accepted, and t_c = t_e; otherwise ξ is computed once more, for the
/// accepted state, and t_c is the end of the step.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include "phistep/core/version.hpp"
#include "phistep/simd/update.hpp"

namespace phistep::inline PHISTEP_ABI {

/// The springs of all contacts at one time, sorted by place.
template <class Scalar>
struct SpringTable {
  /// One array a component, with numbers to spare for a whole pack. Behind the last contact stands one that is
  /// unstretched: what a new contact finds.
  struct Lengths {
    std::array<std::vector<Scalar>, 3> x;
    void resize(std::size_t n) {
      for (auto& a : x) a.resize(n);
    }
    void archive(auto& ar) { ar("x", x); }
  };
  static constexpr std::size_t padding = 32;

  std::vector<std::int32_t> place;  ///< of each contact, ascending
  Lengths slip, roll;               ///< ξ, ψ; roll may be empty

  [[nodiscard]] std::size_t size() const { return place.size(); }
  [[nodiscard]] bool rolls() const { return !roll.x[0].empty(); }
  void resize(std::size_t contacts, bool with_roll) {
    place.resize(contacts);
    slip.resize(contacts + padding);
    roll.resize(with_roll ? contacts + padding : 0);
  }
  /// What stands behind the last contact.
  void close() {
    for (auto* lengths : {&slip, &roll})
      for (auto& x : lengths->x)
        if (!x.empty()) std::fill(x.begin() + static_cast<std::ptrdiff_t>(size()), x.end(), Scalar{0});
  }
  void archive(auto& ar) {
    ar("place", place, "slip", slip, "roll", roll);
    for (const auto& x : slip.x) ar.check(x.size() == size() + padding || (size() == 0 && x.empty()));
    for (const auto& x : roll.x) ar.check(x.empty() || x.size() == slip.x[0].size());
    for (const auto& x : roll.x) ar.check(x.size() == roll.x[0].size());
    ar.check(std::is_sorted(place.begin(), place.end()) && (place.empty() || place.front() >= 0));
    for (const auto* lengths : {&slip, &roll})
      for (const auto& x : lengths->x) {
        ar.check(all_finite(x.data(), static_cast<std::ptrdiff_t>(x.size())));
        for (std::size_t c = size(); c < x.size(); ++c) ar.check(x[c] == Scalar{0});
      }
  }
  [[nodiscard]] bool fits(const auto& places) const {
    return place.empty() || static_cast<std::size_t>(place.back()) < places.places();
  }
};

/// Shared objects that are made again in place once no copy holds them.
template <class T>
class Recycled {
 public:
  Recycled() = default;
  Recycled(const Recycled&) {}  // a copied force starts with none
  Recycled(Recycled&&) noexcept = default;
  Recycled& operator=(const Recycled&) { return *this; }
  Recycled& operator=(Recycled&&) noexcept = default;
  ~Recycled() = default;

  [[nodiscard]] std::shared_ptr<T> take() {
    for (auto& one : kept_)
      if (one.use_count() == 1) return one;
    auto made = std::make_shared<T>();
    if (kept_.size() < 4)
      kept_.push_back(made);  // the committed one, the trial's, the one before, one for a checkpoint
    else kept_[next_++ % kept_.size()] = made;
    return made;
  }

 private:
  std::vector<std::shared_ptr<T>> kept_;
  std::size_t next_ = 0;
};

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

/// The history of a force with contacts, as a value: copies share what they point to, which is never changed.
/// @tparam Places  enumerates where there may be contacts
/// @tparam Table   their springs
template <class Scalar, class Places, class Table = SpringTable<Scalar>>
struct ContactMemory {
  // An evaluation may find that the places must be enumerated anew, and leaves its springs: hence mutable. What a step
  // commits or drops is always the trial's.
  mutable std::shared_ptr<const Places> places;
  mutable std::shared_ptr<const Table> springs;                   ///< ξ(t_c), for `places`
  mutable std::shared_ptr<const Table> last;                      ///< ξ(t_e) of the last evaluation, likewise
  mutable std::shared_ptr<const DormantSprings<Scalar>> dormant;  ///< of none, where there is nothing
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
  /// At the end of an accepted step. False: the springs must be computed for the accepted state, then call accept_last.
  [[nodiscard]] bool accept_single() {
    if (evaluations > 1) return false;
    if (evaluations == 1) {
      springs = std::move(last);
      lag = step - (last_time - time);
    } else {
      lag += step;
    }
    time += step;
    last.reset();
    return true;
  }
  void accept_last() {
    springs = std::move(last);
    lag = 0;
    time += step;
    last.reset();
  }

  void archive(auto& ar) {
    Places its_places = places ? *places : Places{};
    Table its_springs = springs ? *springs : Table{};
    DormantSprings<Scalar> its_dormant = dormant ? *dormant : DormantSprings<Scalar>{};
    ar("places", its_places, "springs", its_springs, "dormant", its_dormant, "time", time, "step", step, "lag", lag);
    ar.check(std::isfinite(time) && std::isfinite(step) && std::isfinite(lag));
    if constexpr (std::remove_reference_t<decltype(ar)>::reading) {
      ar.check(its_springs.fits(its_places));
      last.reset();
      body = 0;
      evaluations = 0;
      // Compared with what the particles are when they are seen again.
      places = std::make_shared<const Places>(std::move(its_places));
      springs = std::make_shared<const Table>(std::move(its_springs));
      dormant = std::make_shared<const DormantSprings<Scalar>>(std::move(its_dormant));
    }
  }
};

}  // namespace phistep::inline PHISTEP_ABI

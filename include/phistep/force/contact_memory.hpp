/// @file
/// What contacts remember: who is near whom, and how far the springs of those that touch are stretched.
///
/// A spring's length ξ is known at a time t_c. An evaluation at (t_e, Y) starts from it and never changes it, whatever
/// Newton asks for and however often a step is rejected: it leaves its own ξ(t_e) beside. Where a step was made of one
/// evaluation, that becomes the memory when the step is accepted, and t_c = t_e; otherwise ξ is computed once more, for the
/// accepted state, and t_c is the end of the step.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include "phistep/core/version.hpp"

namespace phistep::inline PHISTEP_ABI {

/// The springs of all contacts at one time. `Scalar` four by four, so that each is one load.
template <class Scalar>
struct SpringTable {
  std::vector<std::uint8_t> touching;  ///< of each place where there may be a contact
  std::vector<Scalar> slip, roll;      ///< x, y, z, 0 of each place; of no meaning where nothing touches

  void resize(std::size_t places, bool rolls) {
    touching.resize(places);
    slip.resize(4 * places);
    roll.resize(rolls ? 4 * places : 0);
  }
  [[nodiscard]] bool fits(const auto& places) const { return touching.size() == places.places(); }
  void clear() { touching.assign(touching.size(), 0); }
  void archive(auto& ar) {
    ar(touching, slip, roll);
    ar.check(slip.size() == 4 * touching.size() && (roll.empty() || roll.size() == slip.size()));
  }
};

/// Shared objects that are made again in place once nobody else holds them.
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

/// The history of a force with contacts, as a value: copies share what they point to, which nobody changes.
/// @tparam Places  enumerates where there may be contacts
/// @tparam Table   their springs
template <class Scalar, class Places, class Table = SpringTable<Scalar>>
struct ContactMemory {
  // An evaluation may find that the places must be enumerated anew, and leaves its springs: hence mutable. What a step
  // commits or drops is always the trial's.
  mutable std::shared_ptr<const Places> places;
  mutable std::shared_ptr<const Table> springs;  ///< ξ(t_c), for `places`
  mutable std::shared_ptr<const Table> last;     ///< ξ(t_e) of the last evaluation, likewise
  mutable const void* body = nullptr;            ///< what `places` were enumerated for
  mutable Scalar last_time = 0;                  ///< t_e
  mutable std::int64_t evaluations = 0;          ///< since the step began
  Scalar time = 0;                               ///< where the step began, or the last one ended
  Scalar step = 0;                               ///< Δt
  Scalar lag = 0;                                ///< time − t_c

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
    ar(its_places, its_springs, time, step, lag);
    if constexpr (std::remove_reference_t<decltype(ar)>::reading) {
      ar.check(its_springs.fits(its_places));
      last.reset();
      body = nullptr;
      evaluations = 0;
      // Compared with what the particles are when they are seen again.
      places = std::make_shared<const Places>(std::move(its_places));
      springs = std::make_shared<const Table>(std::move(its_springs));
    }
  }
};

}  // namespace phistep::inline PHISTEP_ABI

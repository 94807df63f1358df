/// @file
/// The routine of an existing code as a force: it reads a trial state from the code's arrays, and writes Ψ there.
#pragma once

#include <algorithm>
#include <concepts>
#include <cstdint>
#include <stdexcept>
#include <tuple>
#include <type_traits>
#include <utility>

#include "phistep/base/machine/memory.hpp"
#include "phistep/base/numbers/fingerprint.hpp"
#include "phistep/base/outcome/statistics.hpp"
#include "phistep/base/state/blocks.hpp"
#include "phistep/base/state/strided_block.hpp"
#include "phistep/force/sum.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// The fingerprint of all numbers in a tie of places, by bits and order.
template <class Tie>
[[nodiscard]] std::uint64_t fingerprint_of_places(const Tie& blocks) {
  std::uint64_t all = 0;
  for_each_block(
      [&all](auto, const auto& x) {
        using Block = std::remove_cvref_t<decltype(x)>;
        constexpr Index chunk = places_chunk<Block::dim>;
        typename Block::Scalar piece[chunk * Block::dim];
        for (Index p = 0; p < x.count; p += chunk) {
          const Index m = std::min(chunk, x.count - p);
          x.gather(p, m, piece);
          all = fingerprint(piece, m * Block::dim, all);
        }
      },
      blocks);
  return all;
}

/// Ψ of a routine void() or void(t) that works on the arrays of `Arrays`, a state in place.
///
/// The routine may write its forces and whatever else is its own, but not the positions and velocities: that is checked
/// in some of the calls (`is_looked_at`). @throws std::logic_error where it did
template <class Arrays, class Routine, bool reads_velocities>
class RoutineForce : public ForceTerm {
 public:
  static constexpr bool uses_time = std::invocable<Routine&, double>;
  static constexpr bool uses_velocity = reads_velocities;
  static_assert(uses_time || std::invocable<Routine&>,
                "phistep: the routine of a state in place is called as routine() or routine(t)");

  RoutineForce(Arrays& arrays, Routine routine) : arrays_{&arrays}, routine_{std::move(routine)} {}

  /// out += Ψ(t, y). Outside of steps the arrays are put back.
  void add(auto t, const auto& y, auto& out) {
    const bool is_outside = !arrays_->is_held();
    const AtExit back{[this, is_outside] {
      if (!is_outside) return;
      arrays_->put_back();
      arrays_->release();
    }};
    if (is_outside) arrays_->hold();
    show(y);
    call(t);
    const auto psi = arrays_->rate();
    auto& to = std::get<0>(std::remove_cvref_t<decltype(out)>::blocks(out));
    for (Index p = 0, k = 0; p < psi.count; ++p)
      for (Index d = 0; d < psi.dim; ++d, ++k) to.data()[k] += psi.at[static_cast<std::size_t>(d)][p * psi.stride];
  }

  /// The routine, on the arrays as they are.
  void call(auto t) {
    const bool looks = looks_next();
    ++calls_;
    if (!looks) return run(t);
    const std::uint64_t before = fingerprint_of_places(Arrays::blocks(*arrays_));
    run(t);
    if (fingerprint_of_places(Arrays::blocks(*arrays_)) != before)
      throw std::logic_error(
          "phistep: the routine changed the positions or velocities: it may write forces only (wrap or reorder "
          "particles between steps)");
  }
  /// The next call is one of those.
  [[nodiscard]] bool looks_next() const { return is_looked_at(calls_ + 1); }
  [[nodiscard]] const Arrays* arrays() const { return arrays_; }

 private:
  void run(auto t) {
    if constexpr (uses_time) routine_(t);
    else routine_();
    if (!arrays_->has_kept_length())
      throw std::logic_error(
          "phistep: the routine changed the number of particles, and the arrays stay as it left them: add and remove "
          "particles between steps");
  }
  /// The trial state, as far as the routine reads it.
  void show(const auto& y) {
    auto blocks = Arrays::blocks(*arrays_);
    if constexpr (requires { y.r; }) {
      put(std::get<0>(blocks), y.r);
      if constexpr (reads_velocities) put(std::get<1>(blocks), y.v);
    } else {
      put(std::get<0>(blocks), y.y);
    }
  }
  static void put(auto& places, const auto& block) {
    if (places.rows() != block.rows() || places.cols() != block.cols())
      throw std::invalid_argument("phistep: the force of a state in place is for states of its own size");
    assign_block(places, block);
  }

  Arrays* arrays_;
  Routine routine_;
  std::uint64_t calls_ = 0;
};

}}  // namespace phistep::PHISTEP_ABI

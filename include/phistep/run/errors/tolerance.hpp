/// @file
/// Error control, as a user states it: `integrate(stepper, y, {t0, t1}, tolerance{.rtol = 1e-5, .atol = 1e-8})`.
///
/// The tolerance is meant for the result. The error of one step of order p is held to
///
///     ‖e‖ ≤ rtol^{1/p},   ‖·‖ weighted by 1/(atol + rtol |y|)                                                   (1)
///
/// that is to rtol^{(p+1)/p} of y. There are about rtol^{−1/p} steps in the time in which the solution changes by itself,
/// so that what they add up to is rtol: proportional to the tolerance, as under control per unit step (Hairer, Nørsett &
/// Wanner, Solving ODEs I, sect. II.4; G. Söderlind & L. Wang, J. Comput. Appl. Math. 185 (2006) 225), and blind to the
/// unit of time. Held to ‖e‖ ≤ 1, as is usual, the result would be off by rtol^{p/(p+1)}: 1e-8 asked, 5e-6 got.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <limits>
#include <memory>
#include <span>
#include <vector>

#include "phistep/base/state/blocks.hpp"
#include "phistep/run/errors/step_filter.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// Components of one kind and unit, numbered over all blocks of a state: count of them, from `first`, each `stride` after the one
/// before.
struct Quantity {
  std::int64_t first = 0, count = 0, stride = 1;
};
/// `tolerance{.rtol = 1e-4, .atol = quantity(0, 100)}`: the first hundred components are one quantity, as the cells of a field are
/// or a particle's coordinates: of no component digits are asked beyond 1e-3 of the largest of its kind. Several:
/// `.atol = {quantity(0, n, 2), quantity(1, n, 2)}`.
[[nodiscard]] constexpr Quantity quantity(std::int64_t first, std::int64_t count, std::int64_t stride = 1) {
  return {first, count, stride};
}

/// Whether all are of a state of n numbers.
[[nodiscard]] inline bool are_within(std::span<const Quantity> some, std::int64_t n) {
  return std::all_of(some.begin(), some.end(), [n](const Quantity& one) {
    return one.first >= 0 && one.count >= 0 && one.stride > 0 &&
           (one.count == 0 || (one.first < n && one.count - 1 <= (n - 1 - one.first) / one.stride));
  });
}

/// The error below which relative accuracy of a component doesn't matter, in its own units. Left out: each component is
/// measured by its own size, what it is and lately was (automatic_atol.hpp), so that units don't matter.
class AbsoluteTolerance {
 public:
  enum class Kind : std::uint8_t { automatic, everywhere, per_block, per_component };

  AbsoluteTolerance() = default;
  AbsoluteTolerance(double atol) : few_{atol}, size_{1}, kind_{Kind::everywhere} {}  // NOLINT: .atol = 1e-8
  /// One a block of the state, in their order (motion: r, then v): `.atol = {1e-6, 1e-3}`.
  AbsoluteTolerance(std::initializer_list<double> blocks) : size_{blocks.size()}, kind_{Kind::per_block} {
    if (size_ <= few_.size()) std::copy(blocks.begin(), blocks.end(), few_.begin());
    else many_ = blocks;
  }
  /// None, but that these components are of one kind.
  AbsoluteTolerance(Quantity one) : quantities_{one} {}  // NOLINT: .atol = quantity(0, n)
  AbsoluteTolerance(std::initializer_list<Quantity> some) : quantities_{some} {}
  /// One a component, all blocks one after the other, each in storage order.
  template <class Vector>
    requires requires(const Vector& x) {
      x.data();
      x.size();
    }
  AbsoluteTolerance(const Vector& components) : kind_{Kind::per_component} {  // NOLINT: .atol = vector
    for (decltype(components.size()) i = 0; i < components.size(); ++i)
      many_.push_back(static_cast<double>(components.data()[i]));
    size_ = many_.size();
  }

  /// One a component, as a state of the run's own kind: a field of them, or a motion of two.
  template <FieldState Fields>
  AbsoluteTolerance(const Fields& components)  // NOLINT: .atol = field
      : kind_{Kind::per_component},
        fields_{std::make_shared<const PlainState<Fields>>(components)},
        type_{&type_of<PlainState<Fields>>} {}

  [[nodiscard]] Kind kind() const { return kind_; }
  [[nodiscard]] std::span<const double> values() const { return {many_.empty() ? few_.data() : many_.data(), size_}; }
  [[nodiscard]] std::span<const Quantity> quantities() const { return quantities_; }
  /// Those of fields; null where it has none, or of another kind.
  template <class Fields>
  [[nodiscard]] const Fields* fields() const {
    return type_ == &type_of<Fields> ? static_cast<const Fields*>(fields_.get()) : nullptr;
  }

 private:
  template <class Fields>
  static constexpr char type_of = 0;

  std::array<double, 4> few_{};  // a short run should not wait for the heap
  std::vector<double> many_;
  std::vector<Quantity> quantities_;
  std::size_t size_ = 0;
  Kind kind_ = Kind::automatic;
  std::shared_ptr<const void> fields_;
  const void* type_ = nullptr;
};

/// How the errors of a state's components become one number.
enum class Norm : std::uint8_t {
  rms,       ///< root mean square over all components
  particle,  ///< the largest root mean square of a particle (a column of the blocks): one bad particle of many shows
};

/// A component of a state.
struct Component {
  std::int64_t block = -1, index = -1;
  friend bool operator==(const Component&, const Component&) = default;
};

/// What a norm says of an error: its size, and the component that contributes most to it.
struct Measured {
  double square = 0;
  Component worst;
  [[nodiscard]] double size() const { return std::sqrt(square); }
};

/// A run controlled by its error. All of it may be left out.
struct tolerance {
  double rtol = 1e-4;                                         ///< relative error wanted of the result, 0 < rtol < 1
  AbsoluteTolerance atol = {};                                ///< absolute error wanted
  Norm norm = Norm::rms;                                      ///< how the errors of the components become one number
  StepFilter filter = StepFilter::automatic;                  ///< how Δt follows the error; automatic: by the scheme
  double first_step = 0;                                      ///< [time] 0: chosen from the force
  double min_step = 0;                                        ///< [time] a smaller one ends the run
  double max_step = std::numeric_limits<double>::infinity();  ///< [time] no step is longer
  std::int64_t max_steps = 10'000'000;                        ///< tries, the rejected ones included
};

}}  // namespace phistep::PHISTEP_ABI

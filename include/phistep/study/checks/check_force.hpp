/// @file
/// Whether a force keeps what steps rely on: it is a function of its argument, asked twice at one state and at states beside it,
/// and its own Jacobian is what central differences say.
///
///     if (const ForceCheck check = check_force(force, state); !check) std::cerr << check.message() << '\n';
///     if (const JacobianCheck check = check_jacobian(force, state); !check) std::cerr << check.message() << '\n';
///
/// A force that existing code brings along may read that code's own arrays in place of the state it is called with. Schemes
/// that evaluate it inside a step, at trial states, are then wrong without a sign of it. Within a step it can't be distinguished
/// from a constant force, so it is reported on request.
#pragma once

#include <Eigen/Core>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <limits>
#include <string>
#include <tuple>
#include <type_traits>

#include "phistep/base/numbers/arithmetic.hpp"
#include "phistep/base/state/blocks.hpp"
#include "phistep/base/state/reductions.hpp"
#include "phistep/base/state/unknowns.hpp"
#include "phistep/embed/number_parts.hpp"
#include "phistep/force/evaluate.hpp"
#include "phistep/force/signature.hpp"
#include "phistep/step/jacobian/analytic.hpp"
#include "phistep/step/mass/bound_masses.hpp"
#include "phistep/step/mass/mass.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// What a force does with its argument. Contextually true where it is finite, repeatable, and depends on the state.
template <std::size_t blocks>
struct ForceCheck {
  bool is_finite = true;      ///< at the state given
  bool is_repeatable = true;  ///< the same bits whenever it is called with that state, other calls in between or not
  /// Whether it changes with each block of the state (of a motion: r, then v).
  std::array<bool, blocks> depends_on{};

  [[nodiscard]] bool sees_state() const {
    return std::find(depends_on.begin(), depends_on.end(), true) != depends_on.end();
  }
  [[nodiscard]] explicit operator bool() const { return is_finite && is_repeatable && sees_state(); }
  [[nodiscard, gnu::cold]] std::string message() const {
    if (!is_finite) return "phistep: the force is not finite at this state";
    if (!is_repeatable)
      return "phistep: the force gives another answer when it is called again with the same state: it depends on what "
             "it, or something else, has changed meanwhile. A step calls it at trial states, some of which are "
             "rejected: what it keeps from call to call must be a Memory";
    if (!sees_state())
      return "phistep: the force does not change with the state it is called with. If it is not a constant one, it "
             "reads arrays of its own: let it read its argument";
    std::string text = "phistep: the force is repeatable and depends on";
    for (std::size_t k = 0; k < blocks; ++k)
      if (depends_on[k]) text += blocks == 1 ? " y" : k == 0 ? " r" : k == 1 ? " v" : " block " + std::to_string(k);
    return text;
  }
};

/// Asks the force at (state, t), which stays as it is, and at states off by 1e-6, 1e-3 and a tenth of each block's largest
/// component. A force with a history is asked with a new one each time.
template <State S, class F>
[[nodiscard]] auto check_force(F&& force_given, const S& state, ScalarOf<S> t = 0) {
  using Scalar = ScalarOf<S>;
  using Rate = RateOf<S>;
  auto&& its_own = changeable(unwrap(force_given));
  auto&& force = as_stepped<S>(its_own);
  using Force = std::remove_cvref_t<decltype(force)>;
  PlainState<S> y;
  copy_blocks<S>(y, state);
  const auto masses = bind_masses<S>(UnitMasses{}, y);
  const auto evaluate = [&] {
    Rate psi = make_rate<S>(y);
    MemoryOf<Force> memory{};
    begin_force(force, t, Scalar{0}, Blocks<S>::view(y, masses), memory);
    assign_force(force, t, Blocks<S>::view(y, masses), memory, psi);
    return psi;
  };
  const auto same = [](const Rate& a, const Rate& b) { return equal_bits(Rate::blocks(a), Rate::blocks(b)); };

  constexpr std::size_t blocks = std::tuple_size_v<decltype(Blocks<S>::all(y))>;
  ForceCheck<blocks> check;
  const Rate first = evaluate();
  check.is_finite = !first_non_finite(Rate::blocks(first));
  check.is_repeatable = same(first, evaluate());
  Xorshift random(0x9e3779b97f4a7c15u);
  for_each_block(
      [&](auto k, auto& block) {
        const auto kept = block;
        const Scalar size = block.size() > 0 && max_abs(block) > 0 ? max_abs(block) : Scalar{1};
        for (const double by : {1e-6, 1e-3, 0.1}) {
          for (Index i = 0; i < block.size(); ++i)
            block.data()[i] = kept.data()[i] + random.sign(static_cast<Scalar>(by) * size);
          check.depends_on[k] = check.depends_on[k] || !same(first, evaluate());
        }
        block = kept;
        check.is_repeatable = check.is_repeatable && same(first, evaluate());
      },
      Blocks<S>::all(y));
  return check;
}

/// The worst entry of a Jacobian against differences. Contextually true where all entries agree.
struct JacobianCheck {
  bool agrees = true;                ///< to the tolerance asked for
  char matrix = 'J';                 ///< 'J' = ∂Ψ/∂y, 'K' = ∂Ψ/∂r, 'C' = ∂Ψ/∂v
  Eigen::Index row = 0, column = 0;  ///< of the worst entry
  double given = 0;                  ///< the force's own value of that entry
  double differenced = 0;            ///< what central differences make of it
  double error = 0;                  ///< their distance, relative to the largest entry of the row

  [[nodiscard]] explicit operator bool() const { return agrees; }
  [[nodiscard, gnu::cold]] std::string message() const {
    char text[200];
    std::snprintf(
        text, sizeof text,
        "phistep: the Jacobian %s differences; the largest distance is at %c(%td, %td): given %.9g, differences "
        "say %.9g (relative error %.2g)",
        agrees ? "agrees with" : "differs from", matrix, static_cast<std::ptrdiff_t>(row),
        static_cast<std::ptrdiff_t>(column), given, differenced, error);
    return text;
  }
};

/// Collects a Jacobian in two dense matrices.
template <class Scalar>
struct DenseSink {
  Eigen::Matrix<Scalar, Eigen::Dynamic, Eigen::Dynamic> K, C;
  void position(Eigen::Index i, Eigen::Index j, Scalar x) { K(i, j) += x; }
  void velocity(Eigen::Index i, Eigen::Index j, Scalar x) { C(i, j) += x; }
  void rate(Eigen::Index i, Eigen::Index j, Scalar x) { C(i, j) += x; }
};

/// Compares the force's Jacobian at (state, t) with central differences.
/// @param tolerance  allowed error, relative to the largest entry of the row; differences themselves reach about 1e-8
template <State S, class F>
[[nodiscard]] JacobianCheck check_jacobian(F&& force_given, const S& state, ScalarOf<S> t = 0,
                                           double tolerance = 1e-5) {
  using Scalar = ScalarOf<S>;
  using Plain = PlainState<S>;
  using Rate = RateOf<S>;
  Plain y;
  copy_blocks<S>(y, state);
  auto&& its_own = changeable(unwrap(force_given));
  auto&& force = as_stepped<S>(its_own);
  using Force = std::remove_cvref_t<decltype(force)>;
  const auto masses = bind_masses<S>(UnitMasses{}, y);
  using View = std::remove_cvref_t<decltype(Blocks<S>::view(y, masses))>;
  static_assert(ForceTraits<Force, View, Rate>::has_jacobian, "phistep: check_jacobian needs a force with a Jacobian");

  const Index n = unknowns<S>(y);
  MemoryOf<Force> memory{};
  DenseSink<Scalar> given, differenced;
  given.K.setZero(n, n), given.C.setZero(n, n), differenced.K.setZero(n, n), differenced.C.setZero(n, n);
  begin_force(force, t, Scalar{0}, Blocks<S>::view(y, masses), memory);
  add_jacobian<true, Rate, Eigen::Dynamic>(force, t, Blocks<S>::view(y, masses), memory, n, given);

  Rate above = make_rate<S>(y), below = above;
  const auto difference = [&](auto& block, Index at, auto& into) {
    const Scalar scale = max_abs(block);
    for (Index j = 0; j < block.size(); ++j) {
      Scalar& x = block.data()[j];
      const Scalar kept = x;
      const Scalar step = std::cbrt(std::numeric_limits<Scalar>::epsilon()) *
                          std::max({std::abs(kept), scale / 16, scale > 0 ? Scalar{0} : Scalar{1}});
      x = kept + step;
      const Scalar up = x;
      assign_force(force, t, Blocks<S>::view(y, masses), memory, above);
      x = kept - step;
      const Scalar width = up - x;
      assign_force(force, t, Blocks<S>::view(y, masses), memory, below);
      x = kept;
      for_each_number([&](auto i, Scalar a, Scalar b) { into(static_cast<Index>(i), at + j) = (a - b) / width; },
                      Rate::blocks(above), Rate::blocks(below));
    }
  };
  if constexpr (Blocks<S>::drifts) difference(position_of<S>(y), 0, differenced.K);
  for_each_solved<S>([&](Index at, auto& block) { difference(block, at, differenced.C); }, y);

  JacobianCheck check;
  check.matrix = Blocks<S>::drifts ? 'K' : 'J';
  const auto compare = [&](const auto& mine, const auto& theirs, char name) {
    // Rows that vanish by cancellation hold the differences' noise, which the size of the other rows bounds.
    const double noise = n > 0 ? 1e-4 * static_cast<double>(theirs.cwiseAbs().maxCoeff()) : 0.0;
    for (Index i = 0; i < n; ++i) {
      const double size = std::max({noise, static_cast<double>(theirs.row(i).cwiseAbs().maxCoeff()),
                                    static_cast<double>(mine.row(i).cwiseAbs().maxCoeff())});
      for (Index j = 0; j < n; ++j) {
        double error = std::abs(static_cast<double>(mine(i, j) - theirs(i, j))) / (size > 0 ? size : 1.0);
        if (!std::isfinite(error)) error = std::numeric_limits<double>::infinity();
        if (error > check.error)
          check = {true, name, i, j, static_cast<double>(mine(i, j)), static_cast<double>(theirs(i, j)), error};
      }
    }
  };
  if constexpr (Blocks<S>::drifts) compare(given.K, differenced.K, 'K');
  compare(given.C, differenced.C, Blocks<S>::drifts ? 'C' : 'J');
  check.agrees = check.error <= tolerance;
  return check;
}

}}  // namespace phistep::PHISTEP_ABI

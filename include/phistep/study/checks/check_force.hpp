/// @file
/// Whether a force is a function of its argument: asked twice at one state, and at states beside it.
///
///     if (const ForceCheck check = check_force(force, state); !check) std::cerr << check.message() << '\n';
///
/// A force that existing code brings along may read that code's own arrays in place of the state it is called with. Schemes
/// that evaluate it inside a step, at trial states, are then wrong without a sign of it. Nothing in a step can tell this from a
/// constant force, so it is reported on request.
#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <tuple>
#include <type_traits>
#include <utility>

#include "phistep/base/numbers/arithmetic.hpp"
#include "phistep/base/state/blocks.hpp"
#include "phistep/base/state/reductions.hpp"
#include "phistep/base/version.hpp"
#include "phistep/force/evaluate.hpp"
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
    for (const bool depends : depends_on)
      if (depends) return true;
    return false;
  }
  [[nodiscard]] explicit operator bool() const { return is_finite && is_repeatable && sees_state(); }
  [[nodiscard]] std::string message() const {
    if (!is_finite) return "phistep: the force is not finite at this state";
    if (!is_repeatable)
      return "phistep: the force gives another answer when it is called again with the same state: it depends on what "
             "it, or something else, has changed meanwhile. A step calls it at trial states, some of which are "
             "rejected: "
             "what it keeps from call to call must be a Memory";
    if (!sees_state())
      return "phistep: the force does not change with the state it is called with. If it is not a constant one, it "
             "reads "
             "arrays of its own: let it read its argument";
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
  auto&& force = changeable(unwrap(force_given));
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

}}  // namespace phistep::PHISTEP_ABI

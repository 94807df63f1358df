/// @file
/// Ψ of any force into a rate: the only place where forces that return and forces that add, with and without memory, differ; and V
/// of those that have a potential energy, by an optional member beside `add`, with the same view,
///
///     auto energy(auto t, const auto& y) const;        // V(t, r) [energy], −∂V/∂r being the term's force at v = 0
///
/// which a term with a memory may take as energy(t, y, memory). No step calls it; study/energy/energy_ledger.hpp does.
#pragma once

#include <Eigen/Core>

#include <algorithm>
#include <array>
#include <concepts>
#include <limits>
#include <memory>
#include <new>
#include <stdexcept>
#include <string>
#include <string_view>
#include <tuple>
#include <type_traits>
#include <utility>

#include "phistep/base/machine/shares.hpp"
#include "phistep/base/state/active_set.hpp"
#include "phistep/base/state/blocks.hpp"
#include "phistep/base/state/reductions.hpp"
#include "phistep/force/signature.hpp"
#include "phistep/force/sum.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// The history of term k.
template <std::size_t k, class Memory>
[[nodiscard]] constexpr auto& memory_of_term(Memory& memory) {
  if constexpr (std::is_same_v<std::remove_const_t<Memory>, NoMemory>) return memory;
  else return std::get<k>(memory);
}

/// Calls f(k, term k, its memory) for every term of a sum.
template <class SumOfTerms, class Memory, class F>
  requires is_sum<std::remove_const_t<SumOfTerms>>
constexpr void for_each_term(SumOfTerms& sum, Memory& memory, F&& f) {
  [&]<std::size_t... K>(std::index_sequence<K...>) {
    (f(std::integral_constant<std::size_t, K>{}, unwrap(std::get<K>(sum.terms)), memory_of_term<K>(memory)), ...);
  }
  (std::make_index_sequence<std::tuple_size_v<decltype(sum.terms)>>{});
}

/// The result of a force that returns, checked for what would dangle or not fit.
template <class F, class View, class Rate, class Scalar>
[[nodiscard]] decltype(auto) returned_force(F& force, const View& y, Scalar t, const Rate& out) {
  using Traits = ForceTraits<F, View, Rate>;
  static_assert(Refusal<Traits::fault, MotionLike<View>>::is_said);
  if constexpr (Traits::valid) return call_with<Traits::arity>(force, y, t);
  else return std::remove_cvref_t<decltype(std::get<0>(Rate::blocks(out)))>{};  // the assertion is the only error then
}

/// A result of the wrong size, outside of steps; in a step it becomes Outcome::wrong_size.
struct WrongSize : std::invalid_argument {
  Index rows, columns;  ///< of the result
  WrongSize(const std::string& what, Index r, Index c) : std::invalid_argument{what}, rows{r}, columns{c} {}
};
[[noreturn, gnu::cold, gnu::noinline]] inline void throw_wrong_size(Index rows, Index columns, Index right_rows,
                                                                    Index right_columns) {
  throw WrongSize("phistep: the force returned " + std::to_string(rows) + " x " + std::to_string(columns) +
                      " values, the state has " + std::to_string(right_rows) + " x " + std::to_string(right_columns),
                  rows, columns);
}

/// @throws WrongSize where a force's result has another size than the block it belongs to.
template <class Result, class Block>
void check_result_size(const Result& result, const Block& block) {
  if (result.rows() != block.rows() || result.cols() != block.cols())
    throw_wrong_size(result.rows(), result.cols(), block.rows(), block.cols());
}
/// A force that adds must not make what it adds to another size. @throws WrongSize where it did
template <class Block>
void restore_size(Block& block, Index rows, Index columns) {
  if (block.rows() == rows && block.cols() == columns) return;
  const Index its_rows = block.rows(), its_columns = block.cols();
  if constexpr (Block::SizeAtCompileTime == Eigen::Dynamic) block.setZero(rows, columns);
  throw_wrong_size(its_rows, its_columns, rows, columns);
}

/// What stands for v in the view of a term that says `uses_velocity = false`: reading it doesn't compile.
struct VelocityThatIsNotUsed {};
template <class View>
struct WithoutVelocity : View {
  VelocityThatIsNotUsed v;
};
/// The view as term F may read it.
template <class F, class View>
[[nodiscard]] constexpr decltype(auto) view_for(const View& y) {
  if constexpr (MotionLike<View> && std::is_trivially_copy_constructible_v<View> && ignores_velocity<F>)
    return WithoutVelocity<View>{y, {}};
  else return (y);
}
/// t as term F may read it: NaN where it says `uses_time = false`.
template <class F, class Scalar>
[[nodiscard]] constexpr Scalar time_for(Scalar t) {
  if constexpr (ignores_time<F>) return std::numeric_limits<Scalar>::quiet_NaN();
  else return t;
}

/// out += Ψ.
template <class F, class View, class Memory, class Rate, class Scalar>
void add_force(F& force, Scalar t, const View& y, const Memory& memory, Rate& out) {
  if constexpr (is_sum<F>) {
    for_each_term(force, memory,
                  [&](auto, auto& part, const auto& its_memory) { add_force(part, t, y, its_memory, out); });
  } else if constexpr (!ForceTraits<F, View, Rate>::accumulates) {
    auto& block = std::get<0>(Rate::blocks(out));
    const auto& result = returned_force(force, y, t, out);
    check_result_size(result, block);
    block += result;
  } else if constexpr (remembers<F>) {
    force.add(time_for<F>(t), view_for<F>(y), memory, out);
  } else {
    force.add(time_for<F>(t), view_for<F>(y), out);
  }
}

template <class... T>
inline constexpr bool computes_active_only<Sum<T...>> = (computes_active_only<Unwrapped<T>> && ...);

/// psi = 0, but where no term adds to the forces on particles outside the active set: they are of no interest.
template <class F, class View, class Block>
void clear_force(Block& psi, const View& y) {
  if constexpr (computes_active_only<F> && Block::ColsAtCompileTime == Eigen::Dynamic && !Block::IsRowMajor)
    if (const ActiveSet* active = active_set(y); active != nullptr && psi.cols() == active->size()) {
      for (const std::int32_t i : active->list()) psi.col(i).setZero();
      return;
    }
  if constexpr (Block::SizeAtCompileTime == Eigen::Dynamic)
    for_each_range(psi.size(), 64, [&psi](Index begin, Index end) {
      std::fill(psi.data() + begin, psi.data() + end, typename Block::Scalar{0});
    });
  else psi.setZero();
}

/// out = Ψ.
template <class F, class View, class Memory, class Rate, class Scalar>
void assign_force(F& force, Scalar t, const View& y, const Memory& memory, Rate& out) {
  if constexpr (ForceTraits<F, View, Rate>::accumulates) {
    std::array<Index, 2 * std::tuple_size_v<decltype(Rate::blocks(out))>> sizes;
    for_each_block(
        [&](auto k, auto& psi) {
          clear_force<F>(psi, y);
          sizes[2 * k] = psi.rows(), sizes[2 * k + 1] = psi.cols();
        },
        Rate::blocks(out));
    add_force(force, t, y, memory, out);
    for_each_block([&sizes](auto k, auto& psi) { restore_size(psi, sizes[2 * k], sizes[2 * k + 1]); },
                   Rate::blocks(out));
  } else {
    auto& block = std::get<0>(Rate::blocks(out));
    using Block = std::remove_cvref_t<decltype(block)>;
    if constexpr (Block::SizeAtCompileTime != Eigen::Dynamic && std::is_trivially_destructible_v<Block> &&
                  std::is_same_v<decltype(returned_force(force, y, t, out)), Block>) {
      // In its place: a copy would load by packets what the force has just written by single numbers, and such loads
      // wait until the stores have left the store buffer.
      ::new (static_cast<void*>(std::addressof(block))) Block(returned_force(force, y, t, out));
    } else {
      decltype(auto) result = returned_force(force, y, t, out);
      check_result_size(result, block);
      block = static_cast<decltype(result)&&>(result);  // a vector's numbers are handed over, not copied
    }
  }
}

/// Starts a step of a force with memory: the trial history sees the state that the step starts from.
template <class F, class View, class Memory, class Scalar>
void begin_force(F& force, Scalar t, Scalar dt, const View& y, Memory& memory) {
  if constexpr (is_sum<F>)
    for_each_term(force, memory, [&](auto, auto& part, auto& its_memory) { begin_force(part, t, dt, y, its_memory); });
  else if constexpr (requires { force.begin(t, dt, y, memory); }) force.begin(t, dt, y, memory);
}

/// Ends an accepted step: the history becomes that of the accepted state.
template <class F, class View, class Memory, class Scalar>
void commit_force(F& force, Scalar t, const View& y, Memory& memory) {
  if constexpr (is_sum<F>)
    for_each_term(force, memory, [&](auto, auto& part, auto& its_memory) { commit_force(part, t, y, its_memory); });
  else if constexpr (remembers<F>) force.commit(t, y, memory);
}

/// The memory of a force, for a checkpoint: a section for each term that has one, by the term's name.
template <class F>
void archive_memory(auto& ar, auto& memory) {
  if constexpr (is_sum<F>) {
    [&]<class... T, std::size_t... K>(std::type_identity<Sum<T...>>, std::index_sequence<K...>) {
      (archive_memory<Unwrapped<T>>(ar, memory_of_term<K>(memory)), ...);
    }(std::type_identity<F>{}, std::make_index_sequence<std::tuple_size_v<decltype(F::terms)>>{});
  } else if constexpr (remembers<F>) {
    constexpr bool has_name = requires { std::string_view(F::name); };
    static_assert(has_name,
                  "phistep: a force with a Memory needs a name to be in a checkpoint: static constexpr const char* "
                  "name = \"friction\";");
    if constexpr (has_name) ar.value(F::name, memory);
  }
}

/// A force term with a potential energy. (Where that depends on its numbers, `bool has_energy() const` answers.)
template <class F, class View>
concept HasEnergy = requires(F& f, typename ViewScalar<View>::type t, const View& y) {
  { f.energy(t, y) } -> std::convertible_to<typename ViewScalar<View>::type>;
}
|| requires(F& f, typename ViewScalar<View>::type t, const View& y, const MemoryOf<F>& memory) {
  { f.energy(t, y, memory) } -> std::convertible_to<typename ViewScalar<View>::type>;
};

/// Whether a term has a potential energy, its numbers included.
template <class View, class F>
[[nodiscard]] bool has_energy(F& force) {
  if constexpr (!HasEnergy<F, View>) return false;
  else if constexpr (requires { force.has_energy(); }) return force.has_energy();
  else return true;
}

/// V(t, r) of a force with this memory [energy]; of a sum, that of those terms that have one. 0 where there is none.
template <class F, class View, class Memory, class Scalar>
[[nodiscard]] Scalar potential_energy(F& force, Scalar t, const View& y, const Memory& memory) {
  if constexpr (is_sum<std::remove_const_t<F>>) {
    Scalar sum{0};
    for_each_term(force, memory, [&](auto, auto& term, const auto& its) { sum += potential_energy(term, t, y, its); });
    return sum;
  } else if constexpr (HasEnergy<F, View>) {
    if (!has_energy<View>(force)) return Scalar{0};
    if constexpr (requires { force.energy(t, y, memory); }) return static_cast<Scalar>(force.energy(t, y, memory));
    else return static_cast<Scalar>(force.energy(t, y));
  } else {
    return Scalar{0};
  }
}

/// Which term of a sum is not finite at (t, y), or has the wrong size; −1 if none is, or if the force is not a sum.
template <class F, class View, class Memory, class Rate, class Scalar>
[[nodiscard]] int offending_term(F& force, Scalar t, const View& y, const Memory& memory, Rate& scratch) {
  int found = -1;
  if constexpr (is_sum<F>)
    for_each_term(force, memory, [&](auto k, auto& part, const auto& its_memory) {
      if (found >= 0) return;
      try {
        assign_force(part, t, y, its_memory, scratch);
        if (first_non_finite(Rate::blocks(scratch))) found = static_cast<int>(k());
      } catch (const WrongSize&) {
        found = static_cast<int>(k());
      }
    });
  return found;
}

}}  // namespace phistep::PHISTEP_ABI

/// @file
/// Ψ of any force into a rate: the only place that knows that a force may return or add, remember or not.
#pragma once

#include <Eigen/Core>

#include <stdexcept>
#include <string>
#include <tuple>
#include <type_traits>
#include <utility>

#include "phistep/core/version.hpp"
#include "phistep/force/signature.hpp"
#include "phistep/force/sum.hpp"
#include "phistep/state/blocks.hpp"

namespace phistep::inline PHISTEP_ABI {

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
  using Result = decltype(call_with<Traits::arity>(force, y, t));
  static_assert(PlainResult<Result>,
                "phistep: the force returns a lazy Eigen expression, which would refer to dead temporaries; "
                "give the lambda a return type (-> Vec) or end with .eval()");
  using Block = std::remove_cvref_t<decltype(std::get<0>(Rate::blocks(out)))>;
  using R = std::remove_cvref_t<Result>;
  constexpr bool same_scalar = [] {
    if constexpr (PlainResult<Result>) return std::is_same_v<typename R::Scalar, typename Block::Scalar>;
    else return true;
  }();
  static_assert(same_scalar, "phistep: the force returns another scalar type than the state's");
  if constexpr (PlainResult<Result>)
    static_assert(R::SizeAtCompileTime == Eigen::Dynamic || Block::SizeAtCompileTime == Eigen::Dynamic ||
                      (int{R::RowsAtCompileTime} == int{Block::RowsAtCompileTime} &&
                       int{R::ColsAtCompileTime} == int{Block::ColsAtCompileTime}),
                  "phistep: the force returns a vector of another size than the state's");
  if constexpr (same_scalar) return call_with<Traits::arity>(force, y, t);
  else return Block{};  // so that the one message above is the only one
}

/// @throws std::invalid_argument where a force's result has another size than the block it belongs to.
template <class Result, class Block>
void check_result_size(const Result& result, const Block& block) {
  if (result.rows() != block.rows() || result.cols() != block.cols())
    throw std::invalid_argument("phistep: the force returned " + std::to_string(result.rows()) + " x " +
                                std::to_string(result.cols()) + " values, the state has " +
                                std::to_string(block.rows()) + " x " + std::to_string(block.cols()));
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
    force.add(t, y, memory, out);
  } else {
    force.add(t, y, out);
  }
}

/// out = Ψ.
template <class F, class View, class Memory, class Rate, class Scalar>
void assign_force(F& force, Scalar t, const View& y, const Memory& memory, Rate& out) {
  if constexpr (ForceTraits<F, View, Rate>::accumulates) {
    for_each_block([](auto, auto& psi) { psi.setZero(); }, Rate::blocks(out));
    add_force(force, t, y, memory, out);
  } else {
    auto& block = std::get<0>(Rate::blocks(out));
    const auto& result = returned_force(force, y, t, out);
    check_result_size(result, block);
    block = result;
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

/// Which term of a sum is not finite at (t, y); −1 where none is, or where the force is no sum.
template <class F, class View, class Memory, class Rate, class Scalar>
[[nodiscard]] int offending_term(F& force, Scalar t, const View& y, const Memory& memory, Rate& scratch) {
  int found = -1;
  if constexpr (is_sum<F>)
    for_each_term(force, memory, [&](auto k, auto& part, const auto& its_memory) {
      if (found >= 0) return;
      assign_force(part, t, y, its_memory, scratch);
      if (first_non_finite(Rate::blocks(scratch))) found = static_cast<int>(k());
    });
  return found;
}

}  // namespace phistep::inline PHISTEP_ABI

/// @file
/// The stages of an explicit pair, Runge-Kutta's or Nyström's: their slopes k_j = M⁻¹Ψ, how the first of them comes about, sums
/// of them with weights known at compile time, and to which of them a failure is due.
#pragma once

#include <array>
#include <cstddef>
#include <tuple>
#include <type_traits>
#include <utility>

#include "phistep/base/outcome/outcome.hpp"
#include "phistep/base/state/blocks.hpp"
#include "phistep/base/state/non_finite.hpp"
#include "phistep/base/version.hpp"
#include "phistep/schemes/update_block.hpp"
#include "phistep/schemes/weighted_sum.hpp"
#include "phistep/step/mass/bound_masses.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// @tparam exact  sums with what Scalar's weights lack (weighted_sum.hpp)
template <State S, std::size_t stages, bool exact = false>
class ExplicitStages {
 public:
  using Scalar = ScalarOf<S>;
  using Rate = RateOf<S>;
  template <class Block>
  static constexpr int size_of = std::remove_cvref_t<Block>::SizeAtCompileTime;

  void resize(const PlainState<S>& y) { k_.fill(make_rate<S>(y)); }
  [[nodiscard]] Rate& operator[](std::size_t j) { return k_[j]; }
  [[nodiscard]] const Rate& operator[](std::size_t j) const { return k_[j]; }
  [[nodiscard]] const std::array<Rate, stages>& all() const { return k_; }

  /// k_j = M⁻¹Ψ(t, Y). False: it isn't finite.
  [[nodiscard]] bool evaluate(auto& rhs, std::size_t j, Scalar t, const PlainState<S>& Y) {
    rhs.evaluate_into(t, Y, k_[j]);
    return divide_by_mass(RateOf<S>::blocks(k_[j]), rhs.masses());
  }
  /// Σ_j w_j k_j of a block, for a kernel of update_block.
  template <class Weights, std::size_t block = 0>
  [[nodiscard]] auto sum() const {
    return WeightedSum<Weights, Rate, exact, block>{k_};
  }
  /// factor Σ_j w_j k_j of a field, as a term of a linear combination.
  template <class Weights, std::size_t block = 0>
  [[nodiscard]] auto field_sum(Scalar factor) const {
    using Used = NonZero<Weights, Scalar>;
    using Block = std::remove_cvref_t<decltype(std::get<block>(Rate::blocks(k_[0])))>;
    return [&]<std::size_t... n>(std::index_sequence<n...>) {
      return typename Block::template Combination<Used::count>{
          {(factor * Used::template of<n>)...}, {&std::get<block>(Rate::blocks(k_[Used::places[n]]))...}};
    }
    (typename Used::Indices{});
  }
  /// to = factor Σ_j w_j k_j: an error. Where it isn't finite, the norm of it will tell.
  template <class Weights, std::size_t block = 0>
  void put(Scalar factor, auto& to) const {
    if constexpr (FieldState<S>) {
      to = field_sum<Weights, block>(factor);
    } else {
      const auto kernel = [factor, sum = sum<Weights, block>()](auto i, auto& x) { x = factor * sum(i); };
      static_cast<void>(update_block<size_of<decltype(to)>>(to.size(), kernel, to.data()));
    }
  }
  /// psi: kept for the failure message: the first k that isn't finite.
  [[gnu::cold, gnu::noinline]] void blame(Rate& psi) const {
    psi = k_[0];
    for (const Rate& k : k_)
      if (first_non_finite(Rate::blocks(k))) {
        psi = k;
        return;
      }
  }

 private:
  std::array<Rate, stages> k_;
};

}}  // namespace phistep::PHISTEP_ABI

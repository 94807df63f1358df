/// @file
/// The step's matrix W = M − γ_f C − γ_f γ_d K, banded: one-dimensional grids and chains.
#pragma once

#include <Eigen/Core>

#include "phistep/base/numbers/arithmetic.hpp"
#include "phistep/base/outcome/outcome.hpp"
#include "phistep/base/outcome/statistics.hpp"
#include "phistep/base/version.hpp"
#include "phistep/linear/banded/band_tangent.hpp"
#include "phistep/linear/banded/banded_lu.hpp"
#include "phistep/step/matrix/choice.hpp"
#include "phistep/step/matrix/dense_system.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// Banded W, factorized by LU with row pivoting. The bandwidths are those of the entries that arrive, masses included;
/// after the first factorization nothing is allocated unless one falls outside.
template <class Scalar, bool has_K, bool has_C>
class BandedSystem : public Sizes {
 public:
  using Index = Eigen::Index;
  using Tangent = BandTangent<Scalar, has_K, has_C>;

  void resize(Index n) {
    tangent_.resize(n);
    lu_ = {};
    knows_masses_ = false;
  }

  void clear() { tangent_.clear(); }
  void position(Index i, Index j, Scalar x) { tangent_.position(i, j, x); }
  void velocity(Index i, Index j, Scalar x) { tangent_.velocity(i, j, x); }
  void rate(Index i, Index j, Scalar x) { tangent_.velocity(i, j, x); }
  [[nodiscard]] bool is_finite() const { return tangent_.is_finite(); }
  [[nodiscard]] const Tangent& tangent() const { return tangent_; }

  /// The band of W, settled.
  [[nodiscard]] BandWidth band(const auto& masses) {
    if (!knows_masses_) masses([this](Index i, Index j, auto) { tangent_.include(i, j); });
    knows_masses_ = true;
    tangent_.settle();
    return {tangent_.rows(), tangent_.lower(), tangent_.upper()};
  }
  void for_each_tangent(auto&& f) const { tangent_.for_each_entry(f); }
  [[nodiscard]] Outcome factorize(const auto& masses, Scalar gamma_force, Scalar gamma_drift, Statistics& statistics) {
    const auto [n, lower, upper] = band(masses);
    if (lu_.rows() != n || lu_.lower() != lower || lu_.upper() != upper) lu_.resize(n, lower, upper);
    else lu_.clear();
    lu_.band() = tangent_.part(gamma_force, gamma_drift);
    masses([this](Index i, Index j, auto m) { lu_.column(j)[i - j] += static_cast<Scalar>(m); });
    measure(static_cast<double>(gamma_force * gamma_drift), tangent_.largest_K(), largest(lu_.band()));
    ++statistics.factorizations;
    return lu_.factorize() ? Outcome::success : Outcome::singular_matrix;
  }
  [[nodiscard]] Outcome solve(auto& x) {
    lu_.solve_in_place(x);
    return Outcome::success;
  }
  void add_position_product(Scalar factor, const auto& x, auto& out) const {
    tangent_.add_position_product(factor, x, out);
  }

 private:
  Tangent tangent_;
  BandedLu<Scalar> lu_;
  bool knows_masses_ = false;
};

template <MatrixFacts facts, class Scalar, class Solver, class Force>
struct SystemFor<SystemKind::banded, facts, Scalar, Solver, Force> {
  using type = BandedSystem<Scalar, facts.has_K, facts.has_C>;
};

}}  // namespace phistep::PHISTEP_ABI

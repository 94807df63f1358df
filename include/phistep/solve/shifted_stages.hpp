/// @file
/// What implicit Runge-Kutta schemes are made of once their stages are decoupled: one linearisation, and with it several
/// complex matrices that are factorized and solved with side by side,
///
///     W_l = λ_l/h M − C − h/λ_l K
///
/// (Hairer & Wanner, Solving ODEs II, sect. IV.8, eq. 8.9).
#pragma once

#include <Eigen/Core>

#include <type_traits>

#include "phistep/core/outcome.hpp"
#include "phistep/core/version.hpp"
#include "phistep/equation/right_hand_side.hpp"
#include "phistep/matrix/lane_system.hpp"
#include "phistep/solve/linearisation.hpp"
#include "phistep/solve/newton.hpp"
#include "phistep/state/blocks.hpp"
#include "phistep/state/unknowns.hpp"

namespace phistep::inline PHISTEP_ABI {

template <State S, class Rhs, class LinearSolver>
class ShiftedStages {
 public:
  using Scalar = ScalarOf<S>;
  using Plain = PlainState<S>;
  using Rate = RateOf<S>;
  static constexpr int lanes = 4;
  using Matrix = Linearisation<S, Rhs, LinearSolver, true, true, true>;
  using Lanes = LaneSystem<Matrix::row.kind, Matrix::facts, Scalar, lanes>;
  using Shift = LaneShift<Scalar, lanes>;
  static constexpr bool analytic = Matrix::analytic;

  /// @throws std::invalid_argument where a dense Jacobian of more than 1000 unknowns would be formed by differences.
  ShiftedStages(const Plain& y, Rhs& rhs, const auto& solver) : options_{solver.options} { resize(y, rhs); }
  void resize(const Plain& y, Rhs& rhs) {
    matrix_.resize(y, rhs);  // may throw, so it comes first
    lanes_.resize(unknowns<S>(y));
  }
  /// Forgets what solves have left.
  void forget() { matrix_.drop(); }
  /// … and that the force is still the same.
  void reset() { matrix_.forget(); }
  /// … and the matrix's pattern: all that a new one hasn't.
  void forget_unsaved() {
    matrix_.forget_pattern();
    if constexpr (requires { lanes_.forget_pattern(); }) lanes_.forget_pattern();
  }
  static void forget_force() {}

  [[nodiscard]] bool has_jacobian() const { return matrix_.has_jacobian(); }
  /// J at (t, y). Differences look at psi, which is Ψ there.
  [[nodiscard]] Outcome tangent(Rhs& rhs, Scalar t, Scalar dt, const Plain& y, const Rate& psi,
                                const SolveTolerance<Plain>& allowed) {
    matrix_.drop();
    const Gamma<Scalar> gamma{dt, dt};
    matrix_.begin(gamma, Scalar{0});
    return matrix_.linearise(rhs, gamma, t, y, psi, options_, allowed);
  }
  /// All W_l of the J at hand.
  [[nodiscard]] Outcome factorize(Rhs& rhs, const Shift& shift, const auto& masses) {
    return lanes_.factorize(matrix_.system(), masses, shift, rhs.statistics());
  }
  /// x ← W⁻¹ x
  void solve_in_place(typename Shift::Number* x) { lanes_.solve_in_place(x); }
  /// out += factor K x, x of the positions
  void add_position_product(Scalar factor, const auto& x, auto& out) {
    lanes_.add_position_product(matrix_.system(), factor, x, out);
  }

  [[nodiscard]] const char* solver_name() const { return matrix_.name(); }

 private:
  NewtonOptions options_;
  Matrix matrix_;
  Lanes lanes_;
};

}  // namespace phistep::inline PHISTEP_ABI

/// @file
/// One particle's force, applied to every particle: Ψ_i = f(r_i, v_i, t), or Ψ_i = f(y_i, t) of a first-order state whose
/// particles are groups of `dim` components. ∂Ψ/∂r and ∂Ψ/∂v are then dim×dim blocks on the diagonal, nothing else.
#pragma once

#include <Eigen/Core>

#include <stdexcept>
#include <string>
#include <tuple>
#include <type_traits>
#include <utility>

#include "phistep/base/facts/structure.hpp"
#include "phistep/base/state/blocks.hpp"
#include "phistep/base/state/motion.hpp"
#include "phistep/force/annotate.hpp"
#include "phistep/force/arity.hpp"
#include "phistep/force/evaluate.hpp"
#include "phistep/force/sum.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// Whether force F, or every term of it, does to one particle of `dim` coordinates alone what it does to it among others:
/// a particle's equations may then be solved by themselves. A term of one's own says so by
/// `template <int dim> static constexpr bool is_particlewise = …`, and must have an `add` for views of one particle.
template <class F, int dim>
inline constexpr bool is_particlewise = requires {
  requires F::template is_particlewise<dim>;
};
template <class... T, int dim>
inline constexpr bool is_particlewise<Sum<T...>, dim> = (is_particlewise<Unwrapped<T>, dim> && ...);

/// @throws std::invalid_argument where the block isn't made of particles of dim coordinates.
template <int dim, class Block>
void check_particles(const Block& block, const char* whose = "local") {
  static_assert(
      !Block::IsRowMajor || Block::IsVectorAtCompileTime,
      "phistep: local<dim>(f) and its like need particles as columns of a column-major matrix, or one flat vector");
  if (block.size() % dim != 0 || (!Block::IsVectorAtCompileTime && block.cols() > 1 && block.rows() != dim))
    throw std::invalid_argument("phistep: " + std::string(whose) + "<" + std::to_string(dim) +
                                "> does not fit a state of " + std::to_string(block.rows()) + " x " +
                                std::to_string(block.cols()));
}

/// What `local<dim>(f)` returns; with is_field, what f sees of a particle is its position alone.
template <int dim, class F, bool is_field = false>
class Local : public ForceTerm {
  static_assert(dim > 0, "phistep: local<dim>(f) needs the number of coordinates of a particle");
  using Function = Unwrapped<F>;
  template <class View>
  using One = Eigen::Matrix<typename ViewScalar<View>::type, dim, 1>;
  struct NoMass {};
  /// A particle of a motion, and what f sees of one of a state seen through View.
  template <class View>
  using OneMotion = MotionView<One<View>, NoMass>;
  template <class View>
  using Seen = std::conditional_t<MotionLike<View> && !is_field, OneMotion<View>, FirstOrderView<One<View>, NoMass>>;
  template <class View>
  static constexpr int arity = call_arity<Function, Seen<View>>();

 public:
  static constexpr Structure structure = Structure::local;
  static constexpr int block = dim;
  template <class View>
  static constexpr bool uses_velocity_of = !MotionLike<View> || (!is_field && arity<View> >= 2);
  template <class View>
  static constexpr bool uses_time_of = arity<View> == (MotionLike<Seen<View>> ? 3 : 2);
  template <int coordinates>
  static constexpr bool is_particlewise = coordinates == dim;

  explicit constexpr Local(F f) : f_{std::move(f)} {}

  /// @throws std::invalid_argument where the state isn't made of particles of dim coordinates.
  template <class View>
  void add(auto t, const View& y, auto& out) {
    static_assert(MotionLike<View> || !is_field, "phistep: ExternalField needs a motion, with forces");
    static_assert(arity<View> > 0,
                  "phistep: the f of local<dim>(f) must be callable as f(r_i), f(r_i, v_i) or f(r_i, v_i, t), for a "
                  "first-order state as f(y_i) or f(y_i, t), that of ExternalField{f} as f(r_i) or f(r_i, t), with "
                  "Eigen vectors of dim components");
    if constexpr ((MotionLike<View> || !is_field) && arity < View >> 0) {
      using Result = decltype(call_with<arity<View>>(unwrap(f_), std::declval<const Seen<View>&>(), t));
      constexpr ForceFault fault = fault_of_result<Result, One<View>>();
      static_assert(Refusal<fault, true>::is_said);
      if constexpr (fault == ForceFault::none) {
        auto* const rate = std::get<0>(std::remove_cvref_t<decltype(out)>::blocks(out)).data();
        for_each_particle<Seen<View>>(y, [&](Index at, const Seen<View>& one) {
          const auto& psi = call_with<arity<View>>(unwrap(f_), one, t);
          Eigen::Map<One<View>> to{rate + at};
          check_result_size(psi, to);
          to += psi;
        });
      }
    }
  }

  /// From f's own member jacobian(…), where it has one: dim×dim, or MotionJacobian{K, C} where it takes v_i.
  template <class View>
  void add_jacobian(auto t, const View& y,
                    auto& sink) requires(takes<arity<View>, JacobianOf<Function>, Seen<View>>()) {
    for_each_particle<Seen<View>>(y, [&](Index at, const Seen<View>& one) {
      const auto& jacobian = call_jacobian<arity<View>>(unwrap(f_), one, t);
      if constexpr (!MotionLike<View>) {
        put(at, jacobian, [&sink](Index i, Index j, auto x) { sink.rate(i, j, x); });
      } else if constexpr (is_field || arity<View> == 1) {
        put(at, jacobian, [&sink](Index i, Index j, auto x) { sink.position(i, j, x); });
      } else {
        static_assert(BothTangents<std::remove_cvref_t<decltype(jacobian)>>,
                      "phistep: jacobian(r_i, v_i) must return phistep::MotionJacobian{K, C}");
        put(at, jacobian.K, [&sink](Index i, Index j, auto x) { sink.position(i, j, x); });
        put(at, jacobian.C, [&sink](Index i, Index j, auto x) { sink.velocity(i, j, x); });
      }
    });
  }

  /// The sum of the particles' energies, where f has one (`with_energy(f, V)`). [energy]
  template <MotionLike View>
  [[nodiscard]] auto energy(auto t, const View& y) requires HasEnergy<Function, OneMotion<View>> {
    typename ViewScalar<View>::type sum{0};
    for_each_particle<OneMotion<View>>(y, [&](Index, const OneMotion<View>& one) { sum += unwrap(f_).energy(t, one); });
    return sum;
  }

  /// A tangent's pattern: dim×dim diagonal blocks, found by `dim` differences.
  [[nodiscard]] static ColumnPattern pattern(Index n) { return band_pattern(n, 0, 0, dim); }

  /// f itself, to change its parameters.
  [[nodiscard]] auto& function() { return unwrap(f_); }

 private:
  /// visit(offset of the particle's components, it as an `Each`): copies, so that f sees plain vectors, aligned and without aliases.
  template <class Each, class View>
  static void for_each_particle(const View& y, auto&& visit) {
    const auto& x = first_of(y);
    check_particles<dim>(x, is_field ? "ExternalField" : "local");
    for (Index at = 0; at < x.size(); at += dim) {
      if constexpr (is_field && requires { y.body; })
        if (y.body.is_still(at / dim)) continue;
      const One<View> r = Eigen::Map<const One<View>>(x.data() + at);
      if constexpr (MotionLike<Each>) {
        const One<View> v = Eigen::Map<const One<View>>(y.v.data() + at);
        visit(at, Each{r, v, NoMass{}});
      } else {
        visit(at, Each{r, NoMass{}});
      }
    }
  }
  template <class J>
  static void put(Index at, const J& jacobian, auto&& entry) {
    static_assert(
        int{J::RowsAtCompileTime} == dim && int{J::ColsAtCompileTime} == dim,
        "phistep: the jacobian of local<dim>(f) and of ExternalField{f} must return fixed dim x dim matrices");
    for (int j = 0; j < dim; ++j)
      for (int i = 0; i < dim; ++i) entry(at + i, at + j, jacobian(i, j));
  }

  F f_;
};

/// The force f(r_i), f(r_i, v_i) or f(r_i, v_i, t) on every particle i of `dim` coordinates; f(y_i) or f(y_i, t) for a
/// first-order state. f takes and returns Eigen vectors of fixed size dim:
///
///     auto wells = local<3>([](const Vector3d& r) -> Vector3d { return -r.squaredNorm() * r; });
///
/// A member f.jacobian(…) with f's own arguments returns the dim×dim matrix, or MotionJacobian{K, C} if f takes v_i.
template <int dim, class F>
[[nodiscard]] constexpr Local<dim, F> local(F f) {
  return Local<dim, F>{std::move(f)};
}

/// A field of force in space and time, F_i = f(r_i) or f(r_i, t) on every particle; f takes and returns Eigen vectors of dim
/// components [length] → [force]:
///
///     ExternalField{[](const Vector3d& r, double t) -> Vector3d { return -k * r * std::cos(w * t); }};
///     external_field<2>([](const Vector2d& r) -> Vector2d { … });
///
/// Its tangent comes from a member f.jacobian(r) or f.jacobian(r, t), dim × dim, as `autodiff(f)` has one; without it the
/// stepper takes dim differences for all particles together. Its energy from `with_energy(f, V)`, V(r) or V(r, t).
/// Particles held still get no force.
template <class F, int dim = 3>
class ExternalField : public Local<dim, F, true> {
 public:
  explicit constexpr ExternalField(F f) : Local<dim, F, true>{std::move(f)} {}
};

/// A field on particles of dim coordinates.
template <int dim, class F>
[[nodiscard]] constexpr ExternalField<F, dim> external_field(F f) {
  return ExternalField<F, dim>{std::move(f)};
}

}}  // namespace phistep::PHISTEP_ABI

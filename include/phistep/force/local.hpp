/// @file
/// One particle's force, applied to every particle: Ψ_i = f(r_i, v_i, t), or Ψ_i = f(y_i, t) of a first-order state whose
/// particles are groups of `dim` components. ∂Ψ/∂r and ∂Ψ/∂v are then dim×dim blocks on the diagonal, nothing else.
#pragma once

#include <Eigen/Core>

#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>

#include "phistep/base/facts/structure.hpp"
#include "phistep/base/state/blocks.hpp"
#include "phistep/base/state/motion.hpp"
#include "phistep/base/version.hpp"
#include "phistep/force/annotate.hpp"
#include "phistep/force/energy.hpp"
#include "phistep/force/signature.hpp"
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

/// What `local<dim>(f)` returns.
template <int dim, class F>
class Local : public ForceTerm {
  static_assert(dim > 0, "phistep: local<dim>(f) needs the number of coordinates of a particle");
  using Function = Unwrapped<F>;
  template <class Scalar>
  using One = Eigen::Matrix<Scalar, dim, 1>;
  struct NoMass {};
  template <class Scalar>
  using OneMotion = MotionView<One<Scalar>, NoMass>;
  template <class Scalar>
  using OneFirstOrder = FirstOrderView<One<Scalar>, NoMass>;

  template <class View>
  static constexpr bool is_motion = MotionLike<View>;
  /// What f sees of one particle of a state seen through View.
  template <class View>
  using Seen = std::conditional_t<is_motion<View>, OneMotion<typename ViewScalar<View>::type>,
                                  OneFirstOrder<typename ViewScalar<View>::type>>;
  template <class View>
  static constexpr int arity = call_arity<Function, Seen<View>>();

 public:
  static constexpr Structure structure = Structure::local;
  static constexpr int block = dim;
  template <class View>
  static constexpr bool uses_velocity_of = !is_motion<View> || arity<View> >= 2;
  template <class View>
  static constexpr bool uses_time_of = arity<View> == (is_motion<View> ? 3 : 2);
  template <int coordinates>
  static constexpr bool is_particlewise = coordinates == dim;

  explicit constexpr Local(F f) : f_{std::move(f)} {}

  /// @throws std::invalid_argument where the state isn't made of particles of dim coordinates.
  void add(auto t, const auto& y, auto& out) {
    using View = std::remove_cvref_t<decltype(y)>;
    static_assert(arity<View> > 0,
                  "phistep: the f of local<dim>(f) must be callable as f(r_i), f(r_i, v_i) or f(r_i, v_i, t), for a "
                  "first-order state as f(y_i) or f(y_i, t), with Eigen vectors of dim components");
    if constexpr (arity < View >> 0) {
      using Result = decltype(call_with<arity<View>>(unwrap(f_), std::declval<const Seen<View>&>(), t));
      static_assert(!std::is_void_v<Result>,
                    "phistep: the f of local<dim>(f) returns nothing; it must return a vector");
      static_assert(PlainResult<Result> || std::is_void_v<Result>,
                    "phistep: the f of local<dim>(f) returns a lazy Eigen expression, which would refer to dead "
                    "temporaries; give the lambda a return type (-> Eigen::Vector3d) or end with .eval()");
      using R = std::remove_cvref_t<Result>;
      constexpr bool fits = [] {
        if constexpr (PlainResult<Result>)
          return int{R::RowsAtCompileTime} == dim && int{R::ColsAtCompileTime} == 1 &&
                 std::is_same_v<typename R::Scalar, typename ViewScalar<View>::type>;
        else return true;
      }();
      static_assert(fits, "phistep: the f of local<dim>(f) must return a fixed Eigen vector of dim components");
      if constexpr (fits && PlainResult<Result>) {
        auto* const rate = rate_of(out).data();
        for_each_particle(y, [&](Index at, const Seen<View>& one) {
          const auto& psi = call_with<arity<View>>(unwrap(f_), one, t);
          Eigen::Map<One<typename ViewScalar<View>::type>>{rate + at} += psi;
        });
      }
    }
  }

  /// From f's own member jacobian(…), where it has one: dim×dim, or MotionJacobian{K, C} where it takes v_i.
  template <class View>
  void add_jacobian(auto t, const View& y,
                    auto& sink) requires(phistep::returns_jacobian<Function, Seen<View>, arity<View>>()) {
    for_each_particle(y, [&](Index at, const Seen<View>& one) {
      const auto& jacobian = call_jacobian<arity<View>>(unwrap(f_), one, t);
      if constexpr (!is_motion<View>) {
        put(at, jacobian, [&sink](Index i, Index j, auto x) { sink.rate(i, j, x); });
      } else if constexpr (arity<View> == 1) {
        put(at, jacobian, [&sink](Index i, Index j, auto x) { sink.position(i, j, x); });
      } else {
        static_assert(
            requires {
              jacobian.K;
              jacobian.C;
            },
            "phistep: jacobian(r_i, v_i) must return phistep::MotionJacobian{K, C}");
        put(at, jacobian.K, [&sink](Index i, Index j, auto x) { sink.position(i, j, x); });
        put(at, jacobian.C, [&sink](Index i, Index j, auto x) { sink.velocity(i, j, x); });
      }
    });
  }

  /// The sum of the particles' energies, where f has one (`with_energy(f, V)`). [energy]
  template <class View>
  [[nodiscard]] auto energy(auto t, const View& y) requires HasEnergy<Function, Seen<View>> {
    typename ViewScalar<View>::type sum{0};
    for_each_particle(y, [&](Index, const Seen<View>& one) { sum += unwrap(f_).energy(t, one); });
    return sum;
  }

  /// Blocks on the diagonal: `dim` differences give them all.
  [[nodiscard]] static ColumnPattern pattern(Index n) { return band_pattern(n, 0, 0, dim); }

  /// f itself, to change its parameters.
  [[nodiscard]] auto& function() { return unwrap(f_); }

 private:
  [[nodiscard]] static auto& rate_of(auto& out) {
    if constexpr (requires { out.force; }) return out.force;
    else return out.rate;
  }

  /// visit(offset of the particle's components, what f sees of it)
  template <class View>
  static void for_each_particle(const View& y, auto&& visit) {
    using Scalar = typename ViewScalar<View>::type;
    if constexpr (is_motion<View>) {
      check_particles<dim>(y.r);
      for (Index at = 0; at < y.r.size(); at += dim) {
        // Copies, so that f sees plain vectors, aligned and without aliases.
        const One<Scalar> r = Eigen::Map<const One<Scalar>>(y.r.data() + at),
                          v = Eigen::Map<const One<Scalar>>(y.v.data() + at);
        visit(at, OneMotion<Scalar>{r, v, NoMass{}});
      }
    } else {
      check_particles<dim>(y.y);
      for (Index at = 0; at < y.y.size(); at += dim) {
        const One<Scalar> one = Eigen::Map<const One<Scalar>>(y.y.data() + at);
        visit(at, OneFirstOrder<Scalar>{one, NoMass{}});
      }
    }
  }
  template <class J>
  static void put(Index at, const J& jacobian, auto&& entry) {
    static_assert(int{J::RowsAtCompileTime} == dim && int{J::ColsAtCompileTime} == dim,
                  "phistep: the jacobian of local<dim>(f) must return fixed dim x dim matrices");
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

}}  // namespace phistep::PHISTEP_ABI

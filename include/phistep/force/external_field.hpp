/// @file
/// A field of force in space and time: F_i = f(r_i, t) on every particle.
#pragma once

#include <Eigen/Core>

#include <type_traits>
#include <utility>

#include "phistep/base/facts/structure.hpp"
#include "phistep/base/state/motion.hpp"
#include "phistep/base/version.hpp"
#include "phistep/force/annotate.hpp"
#include "phistep/force/evaluate.hpp"
#include "phistep/force/local.hpp"
#include "phistep/force/sum.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// f(r) or f(r, t) takes and returns Eigen vectors of dim components [length] → [force]:
///
///     ExternalField{[](const Vector3d& r, double t) -> Vector3d { return -k * r * std::cos(w * t); }};
///     external_field<2>([](const Vector2d& r) -> Vector2d { … });
///
/// Its tangent comes from a member f.jacobian(r) or f.jacobian(r, t), dim × dim, as `autodiff(f)` has one; without it the
/// stepper takes dim differences for all particles together. Its energy from `with_energy(f, V)`, V(r) or V(r, t).
/// Particles held still get no force.
template <class F, int dim = 3>
class ExternalField : public ForceTerm {
  static_assert(dim > 0);
  using Function = Unwrapped<F>;
  template <class Scalar>
  using Vector = Eigen::Matrix<Scalar, dim, 1>;
  struct NoMass {};
  template <class View>
  using ScalarOfView = typename ViewScalar<View>::type;
  template <class View>
  using One = MotionView<Vector<ScalarOfView<View>>, NoMass>;
  /// Whether f takes the time.
  template <class View>
  static constexpr bool is_timed =
      std::is_invocable_v<Function&, const Vector<ScalarOfView<View>>&, ScalarOfView<View>>;
  /// Arity alone decides, as in force/signature.hpp: a body is never instantiated with fewer arguments.
  template <class View>
  [[nodiscard]] static consteval bool has_jacobian() {
    using Scalar = ScalarOfView<View>;
    if constexpr (is_timed<View>) return requires(Function & f, const Vector<Scalar>& r, Scalar t) {
        f.jacobian(r, t);
      };
    else return requires(Function & f, const Vector<Scalar>& r) {
        f.jacobian(r);
      };
  }

 public:
  static constexpr bool uses_velocity = false;
  template <class View>
  static constexpr bool uses_time_of = is_timed<View>;
  static constexpr Structure structure = Structure::local;
  static constexpr int block = dim;
  template <int coordinates>
  static constexpr bool is_particlewise = coordinates == dim;

  explicit constexpr ExternalField(F f) : f_{std::move(f)} {}

  /// @throws std::invalid_argument where the state isn't made of particles of dim coordinates.
  template <class View>
  void add(auto t, const View& y, auto& out) {
    static_assert(
        requires { out.force; }, "phistep: ExternalField needs a motion, with forces");
    if constexpr (requires { out.force; }) {
      using Scalar = ScalarOfView<View>;
      static_assert(is_timed<View> || std::is_invocable_v<Function&, const Vector<Scalar>&>,
                    "phistep: the f of ExternalField{f} must be callable as f(r) or f(r, t), r an Eigen vector of dim "
                    "components");
      for_each_position(y, [&](Eigen::Index at, const auto& r) {
        using Result = decltype(call<View>(r, t));
        static_assert(!std::is_void_v<Result>,
                      "phistep: the f of ExternalField{f} returns nothing; it must return a vector");
        static_assert(PlainResult<Result> || std::is_void_v<Result>,
                      "phistep: the f of ExternalField{f} returns a lazy Eigen expression, which would refer to dead "
                      "temporaries; give the lambda a return type (-> Eigen::Vector3d)");
        if constexpr (PlainResult<Result>) {
          const auto& f = call<View>(r, t);
          check_result_size(f, r);
          Eigen::Map<Vector<Scalar>>(out.force.data() + at) += f;
        }
      });
    }
  }

  template <class View>
  void add_jacobian(auto t, const View& y, auto& sink) requires(has_jacobian<View>()) {
    for_each_position(y, [&](Eigen::Index at, const auto& r) {
      const auto put = [&](const auto& K) {
        for (int j = 0; j < dim; ++j)
          for (int i = 0; i < dim; ++i) sink.position(at + i, at + j, K(i, j));
      };
      if constexpr (is_timed<View>) put(unwrap(f_).jacobian(r, t));
      else put(unwrap(f_).jacobian(r));
    });
  }

  /// Σ V(r_i, t) [energy]
  template <class View>
  [[nodiscard]] auto energy(auto t, const View& y) requires requires(Function& f, const One<View>& one) {
    f.energy(t, one);
  }
  {
    ScalarOfView<View> sum{0};
    for_each_position(y, [&](Eigen::Index, const auto& r) { sum += unwrap(f_).energy(t, One<View>{r, r, NoMass{}}); });
    return sum;
  }

  /// Blocks on the diagonal.
  [[nodiscard]] static ColumnPattern pattern(Eigen::Index n) { return band_pattern(n, 0, 0, dim); }

  /// f itself, to change its parameters.
  [[nodiscard]] auto& function() { return unwrap(f_); }

 private:
  template <class View>
  [[nodiscard]] decltype(auto) call(const auto& r, auto t) {
    if constexpr (is_timed<View>) return unwrap(f_)(r, t);
    else return unwrap(f_)(r);
  }
  /// visit(offset of the particle's components, r): a copy, so that f sees a plain vector.
  static void for_each_position(const auto& y, auto&& visit) {
    using Block = std::remove_cvref_t<decltype(y.r)>;
    check_particles<dim>(y.r, "ExternalField");
    for (Eigen::Index at = 0; at < y.r.size(); at += dim) {
      if constexpr (requires { y.body; }) {
        if (y.body.is_still(at / dim)) continue;
      }
      const Vector<typename Block::Scalar> r = Eigen::Map<const Vector<typename Block::Scalar>>(y.r.data() + at);
      visit(at, r);
    }
  }

  F f_;
};

/// A field on particles of dim coordinates.
template <int dim, class F>
[[nodiscard]] constexpr ExternalField<F, dim> external_field(F f) {
  return ExternalField<F, dim>{std::move(f)};
}

}}  // namespace phistep::PHISTEP_ABI

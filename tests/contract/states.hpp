#pragma once

// The same six numbers (two particles in space) in every shape that a state may take, and one force for all of them.

#include <phistep/phistep.hpp>

#include <array>
#include <cmath>
#include <cstring>
#include <random>
#include <string>
#include <type_traits>

namespace states {

using Six = std::array<double, 6>;
inline constexpr Six positions{0.3, -0.7, 0.2, 1.1, 0.4, -0.6}, velocities{0.5, 0.1, -0.4, 0.2, -0.3, 0.6};

using Fixed = Eigen::Matrix<double, 6, 1>;
using Dynamic = Eigen::VectorXd;
using Columns = Eigen::Matrix3Xd;  // one column a particle
using RowMajor = Eigen::Matrix<double, 3, Eigen::Dynamic, Eigen::RowMajor>;
using FixedColumns = Eigen::Matrix<double, 3, 2>;
using Mapped = Eigen::Map<Eigen::VectorXd>;
using Strided = Eigen::Map<Eigen::VectorXd, 0, Eigen::InnerStride<2>>;
using Structs = Eigen::Map<Eigen::Matrix3Xd, 0, Eigen::OuterStride<>>;  // one member of an array of structs
using Reference = Eigen::Ref<Eigen::VectorXd>;

template <class V>
inline constexpr bool is_view = !std::is_same_v<V, typename V::PlainObject>;

/// Component k % 3 of particle k / 3, whatever the shape.
template <class Block>
[[nodiscard]] decltype(auto) component(Block& block, Eigen::Index k) {
  if constexpr (std::remove_cvref_t<Block>::IsVectorAtCompileTime) return block(k);
  else return block(k % 3, k / 3);
}

/// The memory behind a block of type V. It stays where it is, because a view points into it.
template <class V>
struct Home {
  std::array<double, 16> memory{};
  Eigen::VectorXd owned = Eigen::VectorXd::Zero(6);
  Home() = default;
  Home(const Home&) = delete;

  [[nodiscard]] V block(const Six& values) {
    V b = make();
    for (int k = 0; k < 6; ++k) component(b, k) = values[static_cast<std::size_t>(k)];
    return b;
  }

 private:
  [[nodiscard]] V make() {
    if constexpr (std::is_same_v<V, Strided> || std::is_same_v<V, Mapped>) return V(memory.data(), 6);
    else if constexpr (std::is_same_v<V, Structs>) return V(memory.data(), 3, 2, Eigen::OuterStride<>(7));
    else if constexpr (std::is_same_v<V, Reference>) return V(owned);
    else if constexpr (V::IsVectorAtCompileTime) return V(6);
    else return V(3, 2);
  }
};

/// y' = Ψ(y).
template <class V>
struct FirstOrder {
  using State = V;
  using Block = typename V::PlainObject;
  Home<V> home;
  State state;
  explicit FirstOrder(const Six& y = positions) : state(home.block(y)) {}
  [[nodiscard]] static auto& block(State& y) { return y; }
  [[nodiscard]] static const auto& block(const State& y) { return y; }
};

/// r' = v, v' = Ψ(r, v, t).
template <class V>
struct SecondOrder {
  using State = phistep::Motion<V>;
  using Block = typename V::PlainObject;
  Home<V> home_r, home_v;
  State state;
  explicit SecondOrder(const Six& r = positions, const Six& v = velocities) : state{home_r.block(r), home_v.block(v)} {}
};

/// A state of the user's own: a motion with a temperature that the motion heats.
struct Warm {
  Eigen::VectorXd r, v, T;
  static constexpr bool drifts = true;
  static auto blocks(auto& y) { return std::tie(y.r, y.v, y.T); }
  struct Rate {
    Eigen::VectorXd force, heat;
    static auto blocks(auto& q) { return std::tie(q.force, q.heat); }
  };
};
struct Coupled {
  using State = Warm;
  State state;
  explicit Coupled(const Six& r = positions, const Six& v = velocities)
      : state{Eigen::Map<const Eigen::VectorXd>(r.data(), 6), Eigen::Map<const Eigen::VectorXd>(v.data(), 6),
              Eigen::VectorXd::Constant(2, 1.5)} {}
};

/// Ψ: a nonlinear pull to the origin, a spring between the particles, drag, a drive. Each component is written by the
/// same expression in every shape, so that explicit schemes agree to the bit.
[[nodiscard]] inline double pull(double mine, double other) {
  return -2.0 * mine - 0.3 * mine * mine * mine + 0.5 * (other - mine);
}

struct Pull {  // f(r) or f(y)
  auto operator()(const auto& r) const {
    typename std::remove_cvref_t<decltype(r)>::PlainObject f = r;
    for (Eigen::Index k = 0; k < r.size(); ++k)
      component(f, k) = pull(component(r, k), component(r, (k + 3) % r.size()));
    return f;
  }
};
struct DampedPull {  // f(r, v, t)
  auto operator()(const auto& r, const auto& v, double t) const {
    auto f = Pull{}(r);
    for (Eigen::Index k = 0; k < r.size(); ++k) component(f, k) += -0.4 * component(v, k) + 0.2 * std::sin(3 * t);
    return f;
  }
};
struct DrivenPull {  // f(y, t)
  auto operator()(const auto& y, double t) const {
    auto f = Pull{}(y);
    for (Eigen::Index k = 0; k < y.size(); ++k) component(f, k) += 0.2 * std::sin(3 * t);
    return f;
  }
};
/// The same for the user's own state; T grows by friction, and softens the pull.
struct WarmPull {
  static constexpr bool uses_time = false;
  void add(double, const Warm& y, Warm::Rate& out) const {
    for (Eigen::Index k = 0; k < y.r.size(); ++k) {
      out.force[k] += pull(y.r[k], y.r[(k + 3) % y.r.size()]) / (1 + 0.1 * y.T[k / 3]) - 0.4 * y.v[k];
      out.heat[k / 3] += 0.4 * y.v[k] * y.v[k];
    }
  }
};

/// All numbers of a state, block by block, in the order (component, particle).
template <class S>
[[nodiscard]] Eigen::VectorXd numbers(const S& state) {
  Eigen::VectorXd all(0);
  phistep::for_each_block(
      [&all](auto, const auto& block) {
        for (Eigen::Index k = 0; k < block.size(); ++k) {
          all.conservativeResize(all.size() + 1);
          all[all.size() - 1] = component(block, k);
        }
      },
      phistep::Blocks<S>::all(state));
  return all;
}

/// Equal to the last bit: NaN equals itself, and −0 is not 0.
[[nodiscard]] inline bool same_bits(const Eigen::VectorXd& a, const Eigen::VectorXd& b) {
  return a.size() == b.size() &&
         std::memcmp(a.data(), b.data(), sizeof(double) * static_cast<std::size_t>(a.size())) == 0;
}
[[nodiscard]] inline double distance(const Eigen::VectorXd& a, const Eigen::VectorXd& b) {
  return a.size() == b.size() ? (a - b).cwiseAbs().maxCoeff() : INFINITY;
}

/// Calls f(name, scheme).
void for_each_first_order_scheme(auto&& f) {
  using namespace phistep;
  f("forward_euler", forward_euler);
  f("trapezoidal", trapezoidal);
  f("backward_euler", backward_euler);
  f("midpoint", midpoint);
  f("phi(0.7)", phi(0.7));
  f("phi_stage(0.7)", phi_stage(0.7));
  f("tr_bdf2", tr_bdf2);
  f("generalized_alpha(0.6)", generalized_alpha(0.6));
}
void for_each_motion_scheme(auto&& f) {
  for_each_first_order_scheme(f);
  using namespace phistep;
  f("symplectic_euler", symplectic_euler);
  f("symplectic_euler_adjoint", symplectic_euler_adjoint);
  f("velocity_verlet", velocity_verlet);
  f("phi(0.6, 0.8)", phi(0.6, 0.8));
  f("hht(-0.2)", hht(-0.2));
}

}  // namespace states

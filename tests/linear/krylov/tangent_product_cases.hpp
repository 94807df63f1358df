#pragma once

// What the files linear/krylov/tangent_product* share.
#include <phistep/krylov.hpp>

#include <cmath>
#include <random>
#include <tuple>

#include "problems/march.hpp"
#include "support/catch.hpp"

using namespace phistep;
using Vec = Eigen::VectorXd;

namespace tangent_product_cases {

inline constexpr double pi = 3.14159265358979323846;

/// u_t = Δu on the unit square, u = 0 around it, m × m inner points.
struct Heat2d {
  Index m;
  int* calls;
  int* products;

  void laplacian(const auto& u, auto& out) const {
    const double scale = static_cast<double>((m + 1) * (m + 1));
    for (Index j = 0; j < m; ++j)
      for (Index i = 0; i < m; ++i) {
        const Index at = j * m + i;
        out[at] += scale * ((i > 0 ? u[at - 1] : 0.0) + (i + 1 < m ? u[at + 1] : 0.0) + (j > 0 ? u[at - m] : 0.0) +
                            (j + 1 < m ? u[at + m] : 0.0) - 4 * u[at]);
      }
  }
  Vec operator()(const Vec& u) const {
    ++*calls;
    Vec out = Vec::Zero(u.size());
    laplacian(u, out);
    return out;
  }
};
struct HeatWithProduct : Heat2d {
  void apply_jacobian(auto /*t*/, const auto& /*y*/, const auto& x, auto& out) const {
    ++*products;
    laplacian(x.y, out.rate);
  }
};
struct HeatWithDiagonal : HeatWithProduct {
  void jacobian_diagonal(auto /*t*/, const auto& y, auto& sink) const {
    for (Index i = 0; i < y.y.size(); ++i) sink.rate(i, i, -4.0 * static_cast<double>((m + 1) * (m + 1)));
  }
};
struct HeatWithWrongSign : Heat2d {
  void apply_jacobian(auto /*t*/, const auto& /*y*/, const auto& x, auto& out) const {
    Vec product = Vec::Zero(x.y.size());
    laplacian(x.y, product);
    out.rate -= product;
  }
};

inline Vec mode(Index m, int a, int b) {
  Vec u(m * m);
  const double h = 1.0 / static_cast<double>(m + 1);
  for (Index j = 0; j < m; ++j)
    for (Index i = 0; i < m; ++i)
      u[j * m + i] =
          std::sin(a * pi * h * static_cast<double>(i + 1)) * std::sin(b * pi * h * static_cast<double>(j + 1));
  return u;
}
inline double eigenvalue(Index m, int a, int b) {
  const double n = static_cast<double>(m + 1), s = std::sin(a * pi / (2 * n)), t = std::sin(b * pi / (2 * n));
  return -4 * n * n * (s * s + t * t);
}

/// The Brusselator on a periodic grid, u_t = 1 + u²v − 4.4u + αΔu, v_t = 3.4u − u²v + αΔv (Hairer & Wanner II, sect. IV.10,
/// with α = 0.002 and without the source term); u, then v.
struct Brusselator {
  Index m;
  template <class Vector>
  Vector operator()(const Vector& y) const {
    const Index n = m * m;
    const double scale = 0.002 * static_cast<double>(m * m);
    Vector out(2 * n);
    for (Index j = 0; j < m; ++j)
      for (Index i = 0; i < m; ++i) {
        const Index at = j * m + i, w = j * m + (i + m - 1) % m, e = j * m + (i + 1) % m, s = (j + m - 1) % m * m + i,
                    t = (j + 1) % m * m + i;
        const auto u = y[at], v = y[n + at];
        out[at] = 1.0 + u * u * v - 4.4 * u + scale * (y[w] + y[e] + y[s] + y[t] - 4.0 * u);
        out[n + at] = 3.4 * u - u * u * v + scale * (y[n + w] + y[n + e] + y[n + s] + y[n + t] - 4.0 * v);
      }
    return out;
  }
  [[nodiscard]] Vec start() const {
    Vec y(2 * m * m);
    for (Index j = 0; j < m; ++j)
      for (Index i = 0; i < m; ++i) {
        const double x = static_cast<double>(i) / static_cast<double>(m),
                     z = static_cast<double>(j) / static_cast<double>(m);
        y[j * m + i] = 22 * z * std::pow(1 - z, 1.5);
        y[m * m + j * m + i] = 27 * x * std::pow(1 - x, 1.5);
      }
    return y;
  }
};

struct Chain {  // springs in a row, anharmonic, and dragged by neighbours
  Vec operator()(const Vec& r, const Vec& v) const {
    Vec f = -r.array().cube() - r.array();
    const Index n = r.size();
    f.head(n - 1) += 30 * (r.tail(n - 1) - r.head(n - 1)) + 2 * (v.tail(n - 1) - v.head(n - 1));
    f.tail(n - 1) -= 30 * (r.tail(n - 1) - r.head(n - 1)) + 2 * (v.tail(n - 1) - v.head(n - 1));
    return f;
  }
};
struct ChainWithProduct : Chain {
  void apply_jacobian(auto /*t*/, const auto& y, const auto& x, auto& out) const {
    out.force.array() -= (3 * y.r.array().square() + 1) * x.r.array();
    const Index n = y.r.size();
    const Vec pull = 30 * (x.r.tail(n - 1) - x.r.head(n - 1)) + 2 * (x.v.tail(n - 1) - x.v.head(n - 1));
    out.force.head(n - 1) += pull;
    out.force.tail(n - 1) -= pull;
  }
};
struct Nan : Heat2d {
  void apply_jacobian(auto, const auto&, const auto&, auto& out) const { out.rate[7] = NAN; }
};
struct Null {
  Vec operator()(const Vec& x) const { return Vec::Constant(x.size(), 1.0) + x; }
  void apply_jacobian(auto, const auto&, const auto& x, auto& out) const { out.rate += x.y; }
};

struct Counts {
  int calls = 0, products = 0;
};

}  // namespace tangent_product_cases

namespace tangent_product_cases {
/// A preconditioner of the user's own: counts its setups, and divides by what W's diagonal is known to be.
struct Own {
  static inline int setups = 0;
  double inverse = 1;
  void compute(const KnownOfProducts<double>& W) {
    ++setups;
    inverse = 1 / (1 + W.gamma_force * 4 * 21 * 21);
  }
  [[nodiscard]] Vec solve(const Vec& b) const { return inverse * b; }
};
}  // namespace tangent_product_cases

namespace tangent_product_cases {
/// Points that move, heat by drag and cool: r, v and a temperature of another unit and size.
struct Warm {
  Vec r, v, T;
  static constexpr bool drifts = true;
  static auto blocks(auto& y) { return std::tie(y.r, y.v, y.T); }
  struct Rate {
    Vec force, heat;
    static auto blocks(auto& rate) { return std::tie(rate.force, rate.heat); }
  };
};
struct WarmForce {
  static void add(double /*t*/, const Warm& y, Warm::Rate& out) {
    out.force.array() -= 5 * y.r.array() + 1e-3 * y.T.array() * y.v.array();
    out.heat.array() += 10 * y.v.array().square() - 3 * (y.T.array() - 300);
  }
};
struct WarmWithProduct : WarmForce {
  static void apply_jacobian(double /*t*/, const Warm& y, const Warm& x, Warm::Rate& out) {
    out.force.array() -= 5 * x.r.array() + 1e-3 * (x.T.array() * y.v.array() + y.T.array() * x.v.array());
    out.heat.array() += 20 * y.v.array() * x.v.array() - 3 * x.T.array();
  }
};
struct WarmWithEntries : WarmForce {
  static void add_jacobian(double /*t*/, const Warm& y, auto& sink) {
    const Index n = y.r.size();
    for (Index i = 0; i < n; ++i) {
      sink.position(i, i, -5);
      sink.velocity(i, i, -1e-3 * y.T[i]);
      sink.velocity(i, n + i, -1e-3 * y.v[i]);
      sink.velocity(n + i, i, 20 * y.v[i]);
      sink.velocity(n + i, n + i, -3);
    }
  }
};
}  // namespace tangent_product_cases

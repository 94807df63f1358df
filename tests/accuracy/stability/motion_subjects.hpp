#pragma once

// All schemes for r'' = −kr − cv, beside their theory.

#include <phistep/phistep.hpp>

#include <array>
#include <cmath>
#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include "accuracy/stability/motion.hpp"

namespace stability::motion {

struct Entry {
  std::string family;
  double a_most;  ///< of the grid
  Subject subject;
};

namespace bounds {

/// A coefficient printed with sixteen digits (models.hpp).
[[nodiscard]] inline Number published(Real coefficient, const Number& x) {
  Number out = scaled(coefficient, x);
  out.e += 4.5L * std::abs(out.x);
  return out;
}
[[nodiscard]] inline Motion tr_bdf2(const Law& law, const Motion& y, Solve how) {
  const Real gamma = 2 - std::sqrt(Real{2}), beta = (1 + std::sqrt(Real{2})) / 2, a = gamma / 2;
  const auto off = [](Number x, const Number& term) {  // √2 is off by u, and 2 − √2 so by 2u of itself
    x.e += 2 * term.size();
    return x;
  };
  const Number drift = scaled(a, y.v), kick = scaled(a, law(y.r, y.v));
  const Motion b{off(y.r + drift, drift), off(y.v + kick, kick)};
  const auto solve = [&](const Motion& base, const Motion& guess) {
    Motion Y = resolve(law, base, guess, a, a, how).Y;
    // The same of γ in the equation: Y moves by γ/W of its terms.
    const Real W = 1 + a * law.c + a * a * law.k;
    const Real terms = 4 * a * (law.k * Y.r.size() + law.c * Y.v.size()) + 4 * a * a * law.k * Y.v.size();
    Y.v.e += terms / W;
    Y.r.e += a * terms / W + 4 * a * Y.v.size() / W * (1 + a * law.c);
    return Y;
  };
  const Motion Y = solve(b, y);
  return solve({y.r + scaled(beta, Y.r - y.r), y.v + scaled(beta, Y.v - y.v)}, Y);
}
[[nodiscard]] inline Motion two_halves(const Law& law, const Motion& y, Solve how) {
  const Motion middle = resolve(law, y, y, 0.5L, 0.5L, how).Y;
  Motion out = resolve(law, middle, y, 0.5L, 0.5L, how).Y;
  // From y, which may be far away, the iteration ends where its corrections are rounding beside b.
  out.v.e += 2 * std::max(middle.v.size(), 2 * middle.r.size());
  out.r.e += std::max(middle.v.size(), 2 * middle.r.size());
  return out;
}
[[nodiscard]] inline Motion kicks_and_drifts(const Law& law, Motion y, const std::vector<Real>& b,
                                             const std::vector<Real>& a) {
  // The centre is what others leave of 1: off by a rounding for each.
  const auto weigh = [&](Real weight, const Number& x) {
    Number out = published(weight, x);
    out.e += static_cast<Real>(2 * b.size()) * x.size();
    return out;
  };
  for (std::size_t i = 0; i < b.size(); ++i) {
    y.v = y.v + weigh(b[i], law(y.r, y.v));
    if (i < a.size()) y.r = y.r + weigh(a[i], y.v);
  }
  return y;
}
template <class Tableau>
[[nodiscard]] Motion nystrom(const Law& law, const Motion& y) {
  std::vector<Number> k;
  for (std::size_t i = 0; i < Tableau::stages; ++i) {
    Number r = y.r + scaled(Tableau::c[i], y.v);
    for (std::size_t j = 0; j < i; ++j)
      if (Tableau::a[i][j] != 0) r = r + scaled(Tableau::a[i][j], k[j]);
    k.push_back(law(r, y.v));
  }
  Motion out{y.r + y.v, y.v};
  for (std::size_t j = 0; j < Tableau::stages; ++j) {
    if (Tableau::b[0][j] != 0) out.r = out.r + scaled(Tableau::b[0][j], k[j]);
    if (Tableau::b[1][j] != 0) out.v = out.v + scaled(Tableau::b[1][j], k[j]);
  }
  return out;
}
template <class Tableau>
[[nodiscard]] Motion explicit_rk(const Law& law, const Motion& y) {
  std::vector<Motion> k;
  for (std::size_t i = 0;; ++i) {
    Motion moved{Number{0}, Number{0}};
    for (std::size_t j = 0; j < i; ++j)
      if (Tableau::a[i][j] != 0)
        moved = {moved.r + scaled(Tableau::a[i][j], k[j].r), moved.v + scaled(Tableau::a[i][j], k[j].v)};
    const Motion Y{y.r + moved.r, y.v + moved.v};
    if (i == Tableau::end) return Y;
    k.push_back({Y.v, law(Y.r, Y.v)});
  }
}
/// (M + γc + γ²k) x_v = b_v − γk b_r,  x_r = b_r + γ x_v
[[nodiscard]] inline Motion solve_linear(const Law& law, const Motion& b, Real gamma) {
  const Real W = 1 + gamma * law.c + gamma * gamma * law.k;
  const Number v = solved(Number{W, 6 * W, W}, b.v - scaled(gamma * law.k, b.r));
  return {b.r + scaled(gamma, v), v};
}
template <class Tableau>
[[nodiscard]] Motion rosenbrock(const Law& law, const Motion& y) {
  const auto gamma = Tableau::gamma;
  std::vector<Motion> u;
  Motion Y = y;
  for (std::size_t i = 0; i < Tableau::stages; ++i) {
    Y = y;
    Motion weighted{Number{0}, Number{0}};
    for (std::size_t j = 0; j < i; ++j) {
      const Real a = Tableau::a[i][j], c = Tableau::c[i][j];
      if (a != 0) Y = {Y.r + published(a, u[j].r), Y.v + published(a, u[j].v)};
      if (c != 0) weighted = {weighted.r + published(c, u[j].r), weighted.v + published(c, u[j].v)};
    }
    u.push_back(solve_linear(law,
                             {published(gamma, Y.v) + published(gamma, weighted.r),
                              published(gamma, law(Y.r, Y.v)) + published(gamma, weighted.v)},
                             gamma));
  }
  return {Y.r + u.back().r, Y.v + u.back().v};
}
/// As for y' = λy (models.hpp), with the lanes (1/μ + c + μk) w, and R = r + A V.
template <int s>
[[nodiscard]] Motion radau(const Law& law, const Motion& y, const Matrix& P) {
  const auto& tableau = phistep::radau_tableau<s>;
  constexpr std::size_t lanes = (s + 1) / 2, n = s;
  const auto magnitude = [](auto z) { return std::hypot(static_cast<Real>(z.re), static_cast<Real>(z.im)); };
  const Real k = law.k, c = law.c, r0 = y.r.size(), v0 = y.v.size();
  std::array<Real, lanes> w{}, nu{}, matrix{};
  for (std::size_t l = 0; l < lanes; ++l) {
    const Complex inverse = Complex{1} / Complex{tableau.mu[l].re, tableau.mu[l].im};
    nu[l] = std::abs(inverse);
    matrix[l] = std::abs(inverse + Complex{c} + Complex{k} / inverse);
    Complex g{0};
    for (std::size_t j = 0; j < n; ++j)
      g += Complex{tableau.T_inverse[l][j].re, tableau.T_inverse[l][j].im} *
           (k * y.r.x + k * static_cast<Real>(tableau.c[j]) * y.v.x + c * y.v.x);
    w[l] = std::abs(g) / matrix[l];
  }
  std::array<Real, n> moved{}, R{}, e_psi{};
  for (std::size_t j = 0; j < n; ++j)
    for (std::size_t l = 0; l < lanes; ++l) moved[j] += magnitude(tableau.T[j][l]) * w[l];
  for (std::size_t j = 0; j < n; ++j) {
    R[j] = r0;
    for (std::size_t i = 0; i < n; ++i) {
      Real a = 0;  // A = T μ T⁻¹
      for (std::size_t l = 0; l < lanes; ++l) {
        const auto z = tableau.T[j][l] * tableau.mu[l] * tableau.T_inverse[l][i];
        a += static_cast<Real>(z.re);
      }
      R[j] += std::abs(a) * (v0 + moved[i]);
    }
    e_psi[j] = k * (s + 6) * R[j] + c * (s + 6) * (v0 + moved[j]);
  }
  std::array<Real, lanes> e_w{};
  for (std::size_t l = 0; l < lanes; ++l) {
    Real residual = 4 * nu[l] * w[l];
    for (std::size_t j = 0; j < n; ++j) residual += magnitude(tableau.T_inverse[l][j]) * e_psi[j];
    e_w[l] = 2 * residual / matrix[l] + (s + 4) * w[l];
  }
  Motion out{Number{P[0][0] * y.r.x + P[0][1] * y.v.x}, Number{P[1][0] * y.r.x + P[1][1] * y.v.x}};
  out.v.e = out.v.size() + v0;
  out.r.e = out.r.size() + r0;
  for (std::size_t j = 0; j < n; ++j) {
    Real e = (s + 4) * (v0 + moved[j]);
    for (std::size_t l = 0; l < lanes; ++l) e += magnitude(tableau.T[j][l]) * e_w[l];
    out.r.e += static_cast<Real>(tableau.b[j]) * e;
    if (j + 1 == n) out.v.e += e;
  }
  out.v.peak = std::max({k * R[n - 1], k, w[0]});
  return out;
}

}  // namespace bounds

namespace maps {

/// v ← v + b_i Ψ, r ← r + a_i v, and a last kick: shears, one after the other.
[[nodiscard]] inline Matrix kicks_and_drifts(Real k, const std::vector<Real>& b, const std::vector<Real>& a) {
  Matrix P{{{1, 0}, {0, 1}}};
  for (std::size_t i = 0; i < b.size(); ++i) {
    P = product({{{1, 0}, {-b[i] * k, 1}}}, P);
    if (i < a.size()) P = product({{{1, a[i]}, {0, 1}}}, P);
  }
  return P;
}
/// S. Blanes & P. C. Moan, J. Comput. Appl. Math. 142 (2002) 313, tables 2 and 3.
[[nodiscard]] inline std::vector<Real> symmetric(const std::vector<Real>& half, std::size_t n) {
  std::vector<Real> all(n);
  Real sum = 0;
  for (std::size_t i = 0; i < half.size(); ++i) all[i] = all[n - 1 - i] = half[i], sum += half[i];
  if (n % 2 == 1) all[n / 2] = 1 - 2 * sum;
  else all[n / 2 - 1] = all[n / 2] = 0.5L - sum;
  return all;
}
inline const std::vector<Real> kicks6 = symmetric({.0829844064174052L, .396309801498368L, -.0390563049223486L}, 7),
                               drifts6 = symmetric({.245298957184271L, .604872665711080L}, 6),
                               kicks11 = symmetric({.0414649985182624L, .198128671918067L, -.0400061921041533L,
                                                    .0752539843015807L, -.0115113874206879L},
                                                   12),
                               drifts11 = symmetric({.123229775946271L, .290553797799558L, -.127049212625417L,
                                                     -.246331761062075L, .357208872795928L},
                                                    11);

[[nodiscard]] inline Matrix composed_verlet(Real k, Real c) {
  Matrix P{{{1, 0}, {0, 1}}};
  for (const Real share : stability::theory::kahan_li()) P = product(verlet(k, c, share), P);
  return P;
}
/// A Nyström tableau's own polynomials in k, in extended precision.
template <class Tableau>
[[nodiscard]] Matrix nystrom(Real k) {
  Matrix P{};
  for (const std::size_t column : {std::size_t{0}, std::size_t{1}}) {
    const Real r0 = column == 0 ? 1 : 0, v0 = 1 - r0;
    std::array<Real, Tableau::stages> a{};
    Real r = r0 + v0, v = v0;
    for (std::size_t i = 0; i < Tableau::stages; ++i) {
      Real at = r0 + Tableau::c[i] * v0;
      for (std::size_t j = 0; j < i; ++j)
        if (Tableau::a[i][j] != 0) at += Tableau::a[i][j] * a[j];
      a[i] = -k * at;
    }
    for (std::size_t i = 0; i < Tableau::stages; ++i) r += Tableau::b[0][i] * a[i], v += Tableau::b[1][i] * a[i];
    P[0][column] = r;
    P[1][column] = v;
  }
  return P;
}

}  // namespace maps

namespace subjects {

using bounds::Law;
using bounds::Solve;

inline const State rest{Vector{0}, Vector{0}};

template <class R, class Model>
void add(std::vector<Entry>& all, std::string family, double a_most, std::string name, Stepping step, R r, Model model,
         bool damped, bool symplectic = false) {
  Subject subject;
  subject.name = std::move(name);
  subject.step = std::move(step);
  subject.R = r;
  subject.model = model;
  subject.damped = damped;
  subject.symplectic = symplectic;
  all.push_back({std::move(family), a_most, std::move(subject)});
}

template <bool damped = true>
[[nodiscard]] Stepping of(auto scheme, auto... solver) {
  return stepping(phistep::PhiStepper{rest, Spring<damped>{}, scheme, solver...});
}

void add_pair(auto& all, const std::string& name, Stepping step, double f, double d, Solve how = Solve::iterated) {
  add(
      all, "pairs", 8, name, std::move(step), [=](Real k, Real c) { return maps::pair(k, c, f, d); },
      [=](const Law& law, const bounds::Motion& y) { return bounds::pair(law, y, f, d, how); }, true, f + d == 1);
}
void add_pairs(auto& all) {
  using namespace phistep;
  add_pair(all, "forward_euler", of(forward_euler), 0, 0);
  add_pair(all, "symplectic_euler", of(symplectic_euler), 0, 1);
  add_pair(all, "symplectic_euler_adjoint", of(symplectic_euler_adjoint), 1, 0);
  add_pair(all, "trapezoidal", of(trapezoidal), 0.5, 0.5);
  add_pair(all, "backward_euler", of(backward_euler), 1, 1);
  for (const double f : {0.0, 0.2, 0.25, 0.5, 0.6, 0.75, 1.0})
    for (const double d : {0.0, 0.25, 0.4, 0.5, 0.75, 1.0})
      add_pair(all, "phi(" + std::to_string(f) + ", " + std::to_string(d) + ")", of(phi(f, d)), f, d);
  for (const double f : {0.25, 0.5, 0.7, 1.0}) {
    add_pair(all, "phi(" + std::to_string(f) + "), affine", stepping(PhiStepper{rest, affine(Spring<true>{}), phi(f)}),
             f, f, Solve::once);
    add_pair(all, "phi(" + std::to_string(f) + "), linearly_implicit", of(phi(f), linearly_implicit()), f, f,
             Solve::once_from_v);
    all.back().family = "linearly_implicit";
    add_pair(all, "phi_stage(" + std::to_string(f) + ")", of(phi_stage(f)), f, f);
    all.back().subject.model = [f](const Law& law, const bounds::Motion& y) {
      return bounds::stage(law, y, f, Solve::iterated);
    };
    all.back().family = "stages";
  }
}
void add_verlet(auto& all) {
  using namespace phistep;
  const auto model = [](const Law& law, const bounds::Motion& y) { return bounds::verlet(law, y, 1, Solve::iterated); };
  const auto R = [](Real k, Real c) { return maps::verlet(k, c); };
  add(all, "velocity_verlet", 4, "velocity_verlet", of<false>(velocity_verlet), R, model, false, true);
  add(all, "velocity_verlet", 4, "velocity_verlet, damped", of(velocity_verlet), R, model, true);
}
void add_two_solves(auto& all) {
  using namespace phistep;
  add(
      all, "tr_bdf2", 8, "tr_bdf2", of(tr_bdf2),
      [](Real k, Real c) { return maps::of([](Complex z) { return theory::tr_bdf2(z); }, k, c); },
      [](const Law& law, const bounds::Motion& y) { return bounds::tr_bdf2(law, y, Solve::iterated); }, true);
  add(
      all, "rannacher", 8, "rannacher, first step", of(rannacher),
      [](Real k, Real c) { return maps::of([](Complex z) { return theory::two_halves(z); }, k, c); },
      [](const Law& law, const bounds::Motion& y) { return bounds::two_halves(law, y, Solve::iterated); }, true);
}

void add_compositions(auto& all) {
  using namespace phistep;
  add(
      all, "srkn", 8, "srkn6b", of<false>(srkn6b),
      [](Real k, Real) { return maps::kicks_and_drifts(k, maps::kicks6, maps::drifts6); },
      [](const Law& law, const bounds::Motion& y) {
        return bounds::kicks_and_drifts(law, y, maps::kicks6, maps::drifts6);
      },
      false, true);
  add(
      all, "srkn", 8, "srkn11b", of<false>(srkn11b),
      [](Real k, Real) { return maps::kicks_and_drifts(k, maps::kicks11, maps::drifts11); },
      [](const Law& law, const bounds::Motion& y) {
        return bounds::kicks_and_drifts(law, y, maps::kicks11, maps::drifts11);
      },
      false, true);
  const auto composed_model = [](const Law& law, bounds::Motion y) {
    for (const Real share : stability::theory::kahan_li()) {
      y = bounds::verlet(law, y, share, Solve::iterated);
      // The centre's share is what eight others leave of 1.
      y.r.e += 32 * y.v.size();
      y.v.e += 32 * law(y.r, y.v).size();
    }
    return y;
  };
  add(all, "composed", 8, "composed(velocity_verlet)", of<false>(composed(velocity_verlet)), maps::composed_verlet,
      composed_model, false, true);
}
void add_nystrom(auto& all) {
  using namespace phistep;
  add(
      all, "rkn", 16, "rkn86", of<false>(rkn86), [](Real k, Real) { return maps::nystrom<Rkn86>(k); },
      [](const Law& law, const bounds::Motion& y) { return bounds::nystrom<Rkn86>(law, y); }, false);
  add(
      all, "rkn", 16, "rkn1210", of<false>(rkn1210), [](Real k, Real) { return maps::nystrom<Rkn1210>(k); },
      [](const Law& law, const bounds::Motion& y) { return bounds::nystrom<Rkn1210>(law, y); }, false);
}
void add_runge_kutta(auto& all) {
  using namespace phistep;
  add(
      all, "explicit Runge-Kutta", 8, "tsit5", of(tsit5),
      [](Real k, Real c) { return maps::of([](Complex z) { return theory::explicit_rk<Tsit5>(z); }, k, c); },
      [](const Law& law, const bounds::Motion& y) { return bounds::explicit_rk<Tsit5>(law, y); }, true);
  add(
      all, "explicit Runge-Kutta", 8, "dop853", of(dop853),
      [](Real k, Real c) { return maps::of([](Complex z) { return theory::explicit_rk<Dop853>(z); }, k, c); },
      [](const Law& law, const bounds::Motion& y) { return bounds::explicit_rk<Dop853>(law, y); }, true);
}
void add_rosenbrock(auto& all) {
  using namespace phistep;
  add(
      all, "rodas", 16, "rodas4", of(rodas4),
      [](Real k, Real c) { return maps::of([](Complex z) { return theory::rodas4(z); }, k, c); },
      [](const Law& law, const bounds::Motion& y) { return bounds::rosenbrock<Rodas4>(law, y); }, true);
  add(
      all, "rodas", 16, "rodas5p", of(rodas5p),
      [](Real k, Real c) { return maps::of([](Complex z) { return theory::rodas5p(z); }, k, c); },
      [](const Law& law, const bounds::Motion& y) { return bounds::rosenbrock<Rodas5P>(law, y); }, true);
}
template <int s>
void add_radau_of(std::vector<Entry>& all) {
  const auto R = [](Real k, Real c) { return maps::of([](Complex z) { return theory::radau(z, s); }, k, c); };
  add(
      all, "radau", 16, "radau(" + std::to_string(s) + ")", of(phistep::radau(s)), R,
      [R](const Law& law, const bounds::Motion& y) { return bounds::radau<s>(law, y, R(law.k, law.c)); }, true);
}
void add_radau(auto& all) {
  add_radau_of<3>(all);
  add_radau_of<5>(all);
  add_radau_of<7>(all);
}

}  // namespace subjects

}  // namespace stability::motion

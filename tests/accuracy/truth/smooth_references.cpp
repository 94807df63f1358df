// The answers of problems/detest.hpp and problems/smooth.hpp, in quadruple precision by two solvers that share nothing:
// the extrapolated midpoint rule of ten columns, its Δt chosen here, and Odeint's Fehlberg 7(8). Prints both to 20 digits, and
// how far they are apart. Not part of the tests:
//
//     g++ -std=gnu++17 -O2 -I tests tests/accuracy/truth/smooth_references.cpp -o /tmp/references -lquadmath && /tmp/references

#include <algorithm>
#include <array>
#include <boost/multiprecision/float128.hpp>
#include <boost/numeric/odeint.hpp>
#include <cstddef>
#include <cstdio>
#include <string>

#include "problems/detest.hpp"
#include "problems/smooth.hpp"

using Real = boost::multiprecision::float128;

// Odeint of Boost 1.74 takes its value_type for that of a container.
template <>
struct boost::numeric::odeint::detail::extract_value_type<Real> {
  using type = Real;
};

namespace {

/// max |a_i − b_i| / (|a_i| + 1)
template <class State>
Real distance(const State& a, const State& b) {
  Real largest = 0;
  for (std::size_t i = 0; i < a.size(); ++i) largest = std::max<Real>(largest, fabs(a[i] - b[i]) / (fabs(a[i]) + 1));
  return largest;
}

/// Hairer, Nørsett & Wanner, Solving ODEs I, sect. II.9, with n_j = 2j.
template <class P>
std::array<Real, P::n> extrapolated(Real tolerance) {
  using State = std::array<Real, P::n>;
  constexpr std::size_t columns = 10;
  State y;
  const auto start = P::start();
  std::copy(start.begin(), start.end(), y.begin());
  const Real end = P::end;
  Real t = 0, h = 0.01;
  const auto substeps = [](std::size_t j) { return static_cast<int>(2 * (j + 1)); };
  while (t < end) {
    const bool lands = t + h >= end;
    if (lands) h = end - t;
    std::array<State, columns> table;
    State before{};
    for (std::size_t j = 0; j < columns; ++j) {
      const Real step = h / substeps(j);
      State a = y, b, f;
      P::rate(t, &a[0], &f[0]);
      for (std::size_t i = 0; i < P::n; ++i) b[i] = a[i] + step * f[i];
      for (int k = 1; k < substeps(j); ++k) {
        P::rate(Real(t + k * step), &b[0], &f[0]);
        for (std::size_t i = 0; i < P::n; ++i) a[i] += 2 * step * f[i];
        std::swap(a, b);
      }
      table[j] = b;
      for (std::size_t k = j; k > 0; --k) {
        const Real ratio = Real(substeps(j)) / substeps(k - 1), w = 1 / (ratio * ratio - 1);
        if (k == 1) before = table[0];
        for (std::size_t i = 0; i < P::n; ++i) table[k - 1][i] = table[k][i] + w * (table[k][i] - table[k - 1][i]);
      }
    }
    const Real error = distance(table[0], before) / tolerance;
    if (error <= 1) y = table[0], t = lands ? end : Real(t + h);
    const Real by = pow(Real(0.5) / std::max<Real>(error, Real(1e-12)), Real(1) / 19);
    h *= std::min<Real>(Real(3), std::max<Real>(Real(0.2), by));
  }
  return y;
}

template <class P>
std::array<Real, P::n> fehlberg(Real tolerance) {
  using State = std::array<Real, P::n>;
  namespace odeint = boost::numeric::odeint;
  State y;
  const auto start = P::start();
  std::copy(start.begin(), start.end(), y.begin());
  const auto f = [](const State& now, State& out, Real t) { P::rate(t, &now[0], &out[0]); };
  odeint::integrate_adaptive(
      odeint::make_controlled(tolerance, tolerance, odeint::runge_kutta_fehlberg78<State, Real>()), f, y, Real(0),
      Real(P::end), Real(1e-4));
  return y;
}

template <class P>
void show(P, const std::string& only) {
  if (!only.empty() && only != P::name) return;
  const auto a = extrapolated<P>(Real(1e-26)), b = fehlberg<P>(Real(1e-22));
  std::printf("%s apart %.1e\n", P::name, static_cast<double>(distance(a, b)));
  for (const auto* y : {&a, &b}) {
    for (const Real& x : *y) std::printf(" %s", x.str(20, std::ios_base::scientific).c_str());
    std::printf("\n");
  }
  std::fflush(stdout);
}

}  // namespace

int main(int argc, char** argv) {
  const std::string only = argc > 1 ? argv[1] : "";
  const auto each = [&](auto problem) { show(problem, only); };
  problems::for_each_of_detest(each);
  problems::for_each_smooth(each);
}

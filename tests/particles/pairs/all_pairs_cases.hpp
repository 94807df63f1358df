// What all_pairs.test.cpp and all_pairs.full.cpp share.
#pragma once

#include <phistep/particles/bodies/particles.hpp>
#include <phistep/particles/pairs/all_pairs.hpp>
#include <phistep/phistep.hpp>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <functional>
#include <limits>
#include <random>
#include <stdexcept>

#include "support/catch.hpp"
#ifdef _OPENMP
#include <omp.h>
#endif

using namespace phistep;

namespace all_pairs_cases {

template <class Scalar, int dim>
Particles<Scalar, dim> cloud(Index n, unsigned seed = 5) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<Scalar> u(-1, 1);
  Particles<Scalar, dim> y{Eigen::Matrix<Scalar, dim, Eigen::Dynamic>::NullaryExpr(dim, n, [&] { return u(random); })};
  y.set_mass(Eigen::VectorXd::NullaryExpr(n, [&] { return 1.5 + static_cast<double>(u(random)); }));
  y.set_charge(Eigen::VectorXd::NullaryExpr(n, [&] { return static_cast<double>(u(random)); }));
  return y;
}
template <class S, class F>
auto force_on(F& force, const S& y) {
  auto out = make_rate<S>(y);
  const auto masses = S::masses(y);
  add_force(force, ScalarOf<S>{0}, Blocks<S>::view(y, masses), NoMemory{}, out);
  return out.force;
}
template <class S, class F>
auto energy_of(F& force, const S& y) {
  const auto masses = S::masses(y);
  return force.energy(0, Blocks<S>::view(y, masses));
}
using Law = std::function<long double(long double)>;

/// Σ_j w_i w_j f(r²) d in long double, and the sum of the terms' sizes, of which rounding is a part.
template <class S>
void check_against_sum(const S& y, const auto& force, const Law& law, const Eigen::VectorXd& w, double terms = 40) {
  using Scalar = ScalarOf<S>;
  constexpr int dim = S::dimensions;
  double worst = 0;
  for (Index i = 0; i < y.size(); ++i) {
    if (y.body().is_still(i)) continue;
    Eigen::Matrix<long double, dim, 1> sum = Eigen::Matrix<long double, dim, 1>::Zero();
    long double size = 0;
    for (Index j = 0; j < y.size(); ++j) {
      if (j == i) continue;
      const Eigen::Matrix<long double, dim, 1> d =
          y.r.col(i).template cast<long double>() - y.r.col(j).template cast<long double>();
      const Eigen::Matrix<long double, dim, 1> f = static_cast<long double>(w[i]) * w[j] * law(d.squaredNorm()) * d;
      sum += f;
      size += f.norm();
    }
    const auto off = (force.col(i).template cast<long double>() - sum).norm();
    worst = std::max(worst, static_cast<double>(off / (size * std::numeric_limits<Scalar>::epsilon())));
  }
  CHECK(worst <= terms);
}
template <class Matrix>
bool same_bits(const Matrix& a, const Matrix& b) {
  return std::memcmp(a.data(), b.data(), sizeof(typename Matrix::Scalar) * static_cast<std::size_t>(a.size())) == 0;
}

inline const auto gravity_law = [](long double r2) { return -2.0L / ((r2 + 0.01L) * std::sqrt(r2 + 0.01L)); };

// Each term is off by some eps (differences ½, square 2, law 4, products 2), and so is the sum of them by sizes; sums of n
// terms in long lanes add n/(4 · lanes) more at worst, and some √n in fact.
template <class S>
void check_sums() {
  using Scalar = ScalarOf<S>;
  // Around lanes, groups of four and teams of 256, whose number is odd and even; the pairwise loop of few.
  for (const Index n : {1, 2, 6, 7, 8, 9, 11, 16, 17, 33, 100, 256, 257, 520, 1025}) {
    CAPTURE(n);
    const auto y = cloud<Scalar, S::dimensions>(n);
    AllPairs gravity{SoftenedGravity{2.0, 0.1}};
    const auto f = force_on(gravity, y);
    check_against_sum(y, f, gravity_law, y.mass().template cast<double>());
    // Newton's third law to rounding: of the sum of all sizes.
    CHECK(f.rowwise().sum().norm() <= 20 * std::numeric_limits<Scalar>::epsilon() * f.norm() * static_cast<Scalar>(n));
  }
}

}  // namespace all_pairs_cases

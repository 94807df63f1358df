#pragma once

// What the quick and the full half of schemes/nystrom/nystrom share.
#include <phistep/phistep.hpp>

#include <cmath>
#include <limits>

#include "contract/states.hpp"
#include "convergence/observed_order.hpp"
#include "problems/driven_motion.hpp"
#include "problems/kepler.hpp"
#include "problems/march.hpp"
#include "support/catch.hpp"

using namespace phistep;
using convergence::check_order;
using convergence::errors;
using problems::distance;
using problems::error_at_end;
using problems::march;
using Vec = Eigen::VectorXd;

namespace nystrom_cases {

/// Σ w_j c_j^q − x, over the largest |w_j|
template <class Tableau>
long double defect(const long double* w, int count, int q, long double x) {
  long double sum = -x, largest = 0;
  for (int j = 0; j < count; ++j) {
    sum += w[j] * (q == 0 ? 1 : std::pow(Tableau::c[j], static_cast<long double>(q)));
    largest = std::max(largest, std::abs(w[j]));
  }
  return std::abs(sum) / std::max(largest, 1.0L);
}
/// Quadrature up to the orders, b_j = b'_j (1 − c_j), and what the stages integrate exactly: `stage_order` from stage 5 on.
template <class Tableau>
void check_conditions(int low, int stage_order) {
  constexpr long double u = 17 * std::numeric_limits<long double>::epsilon();  // a rounding for each term
  for (int q = 0; q <= Tableau::order; ++q) {
    CAPTURE(q);
    const long double once = 1.0L / (q + 1), twice = 1.0L / ((q + 1) * (q + 2));
    const auto v = defect<Tableau>(Tableau::b_velocity, Tableau::stages, q, once);
    const auto r = defect<Tableau>(Tableau::b, Tableau::stages, q, twice);
    if (q < Tableau::order) CHECK(v <= u);
    else CHECK(v > 1e-10L);
    if (q < Tableau::order - 1) CHECK(r <= u);
    if (q < low) CHECK(defect<Tableau>(Tableau::b_velocity_hat, Tableau::stages, q, once) <= u);
    if (q < low - 1) CHECK(defect<Tableau>(Tableau::b_hat, Tableau::stages, q, twice) <= u);
    if (q <= stage_order)
      for (int i = 5; i < Tableau::stages; ++i)
        CHECK(defect<Tableau>(Tableau::a[i], i, q, std::pow(Tableau::c[i], static_cast<long double>(q + 2)) * twice) <=
              u);
  }
  for (int j = 0; j < Tableau::stages; ++j)
    CHECK(std::abs(Tableau::b[j] - Tableau::b_velocity[j] * (1 - Tableau::c[j])) <= u);
}

struct Wall : ForceTerm {
  static constexpr bool uses_velocity = false, uses_time = true;
  double from = 0.15, value = std::numeric_limits<double>::quiet_NaN();
  void add(double t, const auto& y, auto& out) const {
    out.force -= y.r;
    if (t > from) out.force[3] = value;
  }
};
struct Hardening : ForceTerm {
  static constexpr bool uses_velocity = false, uses_time = false;
  double k = 2, cubic = 1;
  void add(auto, const auto& at, auto& out) const {
    out.force -= k * at.r + cubic * at.r.cwiseProduct(at.r).cwiseProduct(at.r);
  }
};
inline Motion<Vec> six() {
  return {Eigen::Map<const Vec>(states::positions.data(), 6), Eigen::Map<const Vec>(states::velocities.data(), 6)};
}

}  // namespace nystrom_cases

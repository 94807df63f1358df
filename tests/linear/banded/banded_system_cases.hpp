#pragma once

// What the files banded_system* share.

#include <phistep/phistep.hpp>

#include <cmath>
#include <stdexcept>

#include "support/catch.hpp"

namespace banded_cases {

using namespace phistep;
using Vec = Eigen::VectorXd;
using Mat = Eigen::MatrixXd;

inline Vec wave(Eigen::Index n) { return Vec::LinSpaced(n, 0, 7).array().sin(); }

/// u_t = Δ_h u, linear or with a sink u³; into an array that is there already.
struct Heat {
  double sink = 0;
  void add(double, const auto& y, auto& out) const {
    const auto& u = y.y;
    const Eigen::Index n = u.size();
    out.rate -= 100 * u;
    out.rate.head(n - 1) += 50 * u.tail(n - 1);
    out.rate.tail(n - 1) += 50 * u.head(n - 1);
    out.rate.array() -= sink * u.array().cube();
  }
};
struct BandedHeat : Heat {
  static constexpr Structure structure = Structure::banded;
  [[nodiscard]] static ColumnPattern pattern(Eigen::Index n) { return band_pattern(n, 1, 1); }
};
/// Its own Jacobian, row by row.
struct AnalyticHeat : Heat {
  static constexpr Structure structure = Structure::banded;
  void add_jacobian(double, const auto& y, auto& to) const {
    const Eigen::Index n = y.y.size();
    for (Eigen::Index i = 0; i < n; ++i) {
      if (i > 0) to.rate(i, i - 1, 50.0);
      to.rate(i, i, -100 - 3 * sink * y.y[i] * y.y[i]);
      if (i + 1 < n) to.rate(i, i + 1, 50.0);
    }
  }
};
static_assert(ForceTraits<AnalyticHeat, FirstOrderView<Vec, UnitMass>, RateOf<Vec>>::has_jacobian);

template <class State>
Statistics steps(State& y, auto force, auto scheme, int count, const auto&... more) {
  PhiStepper stepper{y, force, scheme, more...};
  for (int k = 0; k < count; ++k) {
    const StepReport report = stepper.step(y, 0.1 * k, 0.1);
    if (!report) throw std::runtime_error(report.message());
  }
  return stepper.statistics();
}

}  // namespace banded_cases

// Stiff problems of public sets, as vectors of a size known at run time; and bands and rings.
#include "problems/hydrogen.hpp"
#include "problems/stiff_sets.hpp"

#include "rows.hpp"

namespace automatic {
namespace {

using Vec = Eigen::VectorXd;

/// A rate on bare arrays as a term.
struct Autonomous {
  void (*rate)(double, const double*, double*);
  Vec operator()(const Vec& y) const {
    Vec f(y.size());
    rate(0, y.data(), f.data());
    return f;
  }
};
struct Timed {
  void (*rate)(double, const double*, double*);
  Vec operator()(const Vec& y, double t) const {
    Vec f(y.size());
    rate(t, y.data(), f.data());
    return f;
  }
};

/// Ten species, 29 reactions, and the temperature.
struct Burning {
  Vec operator()(const Vec& y) const { return problems::Hydrogen{}(y); }
};

/// The end to twelve digits or so.
Vec end_of(const Vec& start, const auto& force, double end, double a) {
  Vec y = start;
  phistep::PhiStepper stepper{y, force, phistep::radau};
  const phistep::tolerance tight{.rtol = 3e-14, .atol = 3e-14 * a, .max_steps = 1'000'000};
  if (const auto report = phistep::integrate(stepper, y, {0.0, end}, tight); !report)
    std::puts(report.message().c_str());
  return y;
}
void measure_flow(const char* name, const Vec& start, const auto& force, double end, double a) {
  Problem all = problem(name, start, force, end, end_of(start, force, end, a), a);
  all.tightest = 1e-11;
  measure(std::move(all));
}

/// A ring of n points: diffusion, wind, and a reaction at each.
struct Ring {
  double spread, wind, reaction;
  Vec operator()(const Vec& y) const {
    const Eigen::Index n = y.size();
    Vec f(n);
    for (Eigen::Index i = 0; i < n; ++i) {
      const double left = y[i > 0 ? i - 1 : n - 1], right = y[i + 1 < n ? i + 1 : 0];
      f[i] = spread * (left - 2 * y[i] + right) - wind * (right - left) + reaction * y[i] * (1 - y[i]);
    }
    return f;
  }
};
/// The same between two ends that stay.
struct Band : Ring {
  Vec operator()(const Vec& y) const {
    Vec f = Ring::operator()(y);
    f[0] = f[f.size() - 1] = 0;
    return f;
  }
};
Vec hump(Eigen::Index n) {
  return Vec::NullaryExpr(n, [n](Eigen::Index i) {
    const double x = (static_cast<double>(i) + 0.5) / static_cast<double>(n) - 0.4;
    return std::exp(-60 * x * x);
  });
}

}  // namespace

void sets() {
  for (const problems::Flow& flow : problems::stiff_sets()) {
    const Vec start = Eigen::Map<const Vec>(flow.start.data(), static_cast<Eigen::Index>(flow.start.size()));
    if (flow.uses_time) measure_flow(flow.name, start, Timed{flow.rate}, flow.end, flow.small);
    else measure_flow(flow.name, start, Autonomous{flow.rate}, flow.end, flow.small);
  }
  measure_flow("hydrogen burns in air", problems::Hydrogen::start(), Burning{}, problems::Hydrogen::end, 1e-6);
  measure_flow("ring of 40, mild", hump(40), Ring{2, 1, 1}, 5, 1e-1);
  measure_flow("ring of 40, stiff", hump(40), Ring{1600, 20, 10}, 1, 1e-1);
  measure_flow("ring of 200, stiff", hump(200), Ring{4e4, 100, 10}, 0.1, 1e-1);
  measure_flow("band of 100, told", hump(100), phistep::banded(Band{{1e4, 20, 10}}, 1, 1), 1, 1e-1);
  measure_flow("band of 400, told, mild", hump(400), phistep::banded(Band{{1.6e5, 0, 10}}, 1, 1), 0.01, 1e-1);
  measure_flow("band of 1000, told", hump(1000), phistep::banded(Band{{1e6, 100, 10}}, 1, 1), 0.01, 1e-1);
}

}  // namespace automatic

// expect: then needs checkpoint\(\) and restore\(past\) of the one inside
#include <phistep/phistep.hpp>

using One = Eigen::Matrix<double, 1, 1>;
using Pair = phistep::Motion<One>;

template <class Inner>
struct Around {
  Inner inside;
  [[nodiscard]] Inner& stepper() { return inside; }
  phistep::StepReport step(Pair& y, double t, double dt) { return inside.step(y, t, dt); }
  [[nodiscard]] int order() const { return inside.order(); }
  [[nodiscard]] phistep::Statistics statistics() const { return inside.statistics(); }
  [[nodiscard]] const phistep::SolveRecord& last_solve() const { return inside.last_solve(); }
  bool slope(double t, const Pair& y, Pair& out) { return inside.slope(t, y, out); }
#ifndef MUST_FAIL
  [[nodiscard]] auto checkpoint() const { return inside.checkpoint(); }
  void restore(auto past) { inside.restore(std::move(past)); }
#endif
};
template <class Inner>
Around(Inner) -> Around<Inner>;

int main() {
  Pair y{One{1.0}, One{0.0}};
  Around stepper{phistep::PhiStepper{y, phistep::LinearDrag{1.0}, phistep::midpoint}};
  return phistep::integrate(stepper, y, {0.0, 1.0}, phistep::tolerance{.rtol = 1e-3}) ? 0 : 1;
}

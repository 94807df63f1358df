#include "problems/plate.hpp"

#include "driven.hpp"

namespace {

/// The same as a motion of 40 points: a band of two rows of the plate, constant.
struct PlateMotion : phistep::ForceTerm {
  using P = problems::Plate;
  static constexpr bool is_affine = true;
  static constexpr int width = 2 * P::columns;
  void add(double t, const auto& y, auto& out) const {
    Eigen::VectorXd both(2 * P::points), rate(2 * P::points);
    both << y.r, y.v;
    P::rate(t, both, rate);
    out.force += rate.tail(P::points);
  }
  void add_jacobian(double t, const auto& y, auto& sink) const {
    P::entries(t, y.r, [&sink](int i, int j, double x) {
      if (i < P::points) return;
      if (j < P::points) sink.position(i - P::points, j, x);
      else sink.velocity(i - P::points, j - P::points, x);
    });
  }
};

}  // namespace

work_precision::Table work_precision::plate() {
  using P = problems::Plate;
  Table table = driven_stiff<P>("plate", "Plate: 8 x 5 points under a car, to t = 7", 1e-3);
  const phistep::Motion<Eigen::VectorXd> start{Eigen::VectorXd::Zero(P::points), Eigen::VectorXd::Zero(P::points)};
  PhistepRows rows{
      table, start, [](const auto& y, auto scheme, std::size_t) {
        return phistep::PhiStepper{y, phistep::banded(PlateMotion{}, PlateMotion::width, PlateMotion::width), scheme};
      }};
  rows.controlled("Rodas4P2, banded motion", phistep::rodas4p2);
  rows.controlled("Rodas5P, banded motion", phistep::rodas5p);
  rows.controlled("Radau, banded motion", phistep::radau);
  return table;
}

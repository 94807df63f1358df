// Bands, fields, and dense matrices of more than a few unknowns.
#include <phistep/sparse.hpp>

#include "problems/beam.hpp"
#include "problems/brusselator_1d.hpp"
#include "problems/heat.hpp"
#include "problems/heat_2d.hpp"

#include "rows.hpp"

namespace {
/// With its Jacobian by differences.
struct Bent {
  Eigen::VectorXd operator()(const Eigen::VectorXd& y, double t) const {
    Eigen::VectorXd out(y.size());
    problems::Beam::rate(t, y, out);
    return out;
  }
};
}  // namespace

void automatic::fields() {
  using namespace problems;
  constexpr int points = 20;
  using H = Heat<Eigen::MatrixXd>;
  const auto modes = [](double t) -> Eigen::VectorXd {
    return std::exp(H::eigenvalue(points, 1) * t) * H::mode(points, 1) +
           std::exp(H::eigenvalue(points, 4) * t) * H::mode(points, 4);
  };
  measure(problem("heat, 20 points", Eigen::VectorXd(modes(0)), H(points), 0.1, modes(0.1), 1.0));
  measure(problem("Beam", Beam::start(), Bent{}, Beam::end, Beam::exact(), 1.0));
  measure(problem("Brusselator, 500 points", Brusselator1D::start(), Brusselator1D{}, Brusselator1D::end,
                  Brusselator1D::exact(), 1.0, phistep::UnitMasses{}, Brusselator1D::samples()));
  measure(problem("heat, 64 x 64 points", Heat2D::State(Heat2D::exact(0)), Heat2D{}, Heat2D::end,
                  Heat2D::exact(Heat2D::end), 0.1));
}

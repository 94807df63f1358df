// A structure that hangs at rest in its equilibrium: an implicit scheme has nothing to do there, and does it.
#include <phistep/sparse.hpp>

#include <algorithm>
#include <cmath>
#include <string>

#include "accuracy/contact_chance.hpp"
#include "support/battery.hpp"
#include "support/catch.hpp"

using namespace phistep;
using namespace contact_scenes;

#if PHISTEP_STRESS
constexpr int members = 200;
#elif PHISTEP_FULL
constexpr int members = 24;
#endif

namespace {

using Sparse = Eigen::SparseMatrix<double>;
using Values = Eigen::VectorXd;

struct Weight : ForceTerm {
  Values force;
  static constexpr bool uses_velocity = false, uses_time = false;
  void add(double, const auto&, auto& out) const { out.force += force; }
  void add_jacobian(double, const auto&, auto&&) const {}
};

/// A rod of n elements that hangs from its upper end, under its weight.
struct Rod {
  Sparse stiffness, mass;
  Weight weight;
  Values rest;        // where the forces balance, by Cholesky
  double period = 0;  // of the slowest vibration [time]
};
Rod hanging_rod(int n, double E = 1e9, double rho = 1000, double A = 1e-2, double L = 10) {
  Rod rod;
  rod.stiffness.resize(n, n), rod.mass.resize(n, n);
  const double h = L / n;
  rod.weight.force = Values::Zero(n);
  for (int e = 0; e < n; ++e)
    for (int i = std::max(0, e - 1); i <= e; ++i) {
      rod.weight.force[i] += rho * A * h / 2 * 9.81;
      for (int j = std::max(0, e - 1); j <= e; ++j) {
        rod.stiffness.coeffRef(i, j) -= (i == j ? 1 : -1) * E * A / h;
        rod.mass.coeffRef(i, j) += (i == j ? 2 : 1) * rho * A * h / 6;
      }
    }
  rod.rest = Eigen::MatrixXd(-Eigen::MatrixXd(rod.stiffness)).llt().solve(rod.weight.force);
  rod.period = 4 * L / std::sqrt(E / rho);
  return rod;
}

struct End {
  std::string says;
  double deviation = 0;  // relative to the extension at rest
  bool success = false;
};
End stay(const Rod& rod, auto scheme, double dt, double t1, double displaced) {
  Motion y{rod.rest, Values::Zero(rod.rest.size()).eval()};
  y.r *= 1 + displaced;
  PhiStepper stepper{y, linear(rod.stiffness) + rod.weight, scheme, mass(rod.mass)};
  const auto report = integrate(stepper, y, {0.0, t1}, fixed(dt));
  return {describe(report.outcome), (y.r - rod.rest).norm() / rod.rest.norm(), static_cast<bool>(report)};
}

battery::Tally run(bool moving) {
  battery::Tally tally{.name = moving ? "rods that swing" : "rods at rest"};
  Chance chance{10};
  for (int n = 0; n < members; ++n) {
    const double L = chance.ratio(0.1, 100), A = chance.ratio(1e-6, 1e-1), rho = chance.ratio(100, 1e4);
    const double E = chance.ratio(1e6, 2e11);
    const Rod rod = hanging_rod(1 + chance.one_of(20), E, rho, A, L);
    const double dt = rod.period / chance.ratio(20, 500), displaced = moving ? chance.ratio(1e-3, 1) : 0;
    const int stages = n % 3;
    const End end = stages == 0   ? stay(rod, radau(3), dt, 100 * dt, displaced)
                    : stages == 1 ? stay(rod, radau, dt, 100 * dt, displaced)
                                  : stay(rod, radau(7), dt, 100 * dt, displaced);
    tally.count(end.success && end.deviation <= (moving ? 1.1 * displaced : 1e-9),
                text(n, ": ", end.says, ", deviation ", end.deviation));
  }
  return tally;
}

}  // namespace

TEST_CASE("rods that swing are stepped") { battery::none(run(true)); }
TEST_CASE("rods at rest are stepped") { battery::none(run(false)); }

TEST_CASE("a rod of ten elements at rest is stepped by radau") {
  const Rod rod = hanging_rod(10);
  const End end = stay(rod, radau, rod.period / 200, 5 * rod.period, 0);
  CAPTURE(end.says, end.deviation);
  CHECK((end.success && end.deviation < 1e-9));
}

// energy_ledger: maps, 3xN states and scalars; matrices are in energy_ledger_states.stress.cpp.
// In short: energy_ledger.test.cpp.
#include "study/energy/energy_ledger_cases.hpp"

using namespace energy_ledger_cases;

TEST_CASE("masses that are matrices, 3xN states, maps, float and long double") {
  const int n = 300;
  {
    std::vector<double> r{0, 0, 0, 1.2, 0, 0, 0, 1.1, 0}, v{0, 0, 0.1, 0, 0.2, 0, 0, 0, 0};
    using Columns = Eigen::Map<Eigen::Matrix3Xd>;
    Motion<Columns> y{Columns(r.data(), 3, 3), Columns(v.data(), 3, 3)};
    PhiStepper stepper{
        y, spring_network<3>({{0, 1, 50.0, 1.0}, {1, 2, 50.0, 1.0}}) + Gravity{Eigen::Vector3d(0, 0, -9.81)},
        velocity_verlet, mass(Eigen::Vector3d(1, 2, 3))};
    EnergyLedger ledger{stepper};
    ledger.begin(0, y);
    using Plain = Motion<Eigen::Matrix3Xd>;
    DenseOutput<Motion<Columns>> dense;
    for (int k = 0; k < n; ++k) {
      const Plain start{y.r, y.v};
      REQUIRE(stepper.step(y, 0.01 * k, 0.01));
      const Plain end{y.r, y.v};
      ledger(CompletedStep<Motion<Columns>>{0.01 * k, 0.01, 0.01 * (k + 1), start, end, dense});
    }
    // They fall 44 m: what is rounded is of the size of T and V, far above their sum.
    CHECK(std::abs(ledger.closure()) <= rounding(n) * (ledger.kinetic() + std::abs(ledger.potential())));
    CHECK(ledger.external() == 0);
  }
  const auto scalar = [&](auto one) {
    using T = decltype(one);
    using V = Eigen::Matrix<T, 1, 1>;
    const auto force =
        with_energy([](const V& x) -> V { return -4 * x; }, [](const V& x) { return 2 * x.squaredNorm(); });
    Motion<V> y{V{T{1}}, V{T{0}}};
    PhiStepper stepper{y, force, backward_euler};
    EnergyLedger ledger{stepper};
    DenseOutput<Motion<V>> dense;
    for (int k = 0; k < n; ++k) {
      const auto start = y;
      REQUIRE(stepper.step(y, static_cast<T>(k) / 100, T{1} / 100));
      const auto end = y;
      ledger(CompletedStep<Motion<V>>{static_cast<T>(k) / 100, T{1} / 100, static_cast<T>(k + 1) / 100, start, end,
                                      dense});
    }
    CHECK(std::abs(ledger.closure()) <= n * std::numeric_limits<T>::epsilon() * 2);
    CHECK(ledger.scheme() < -0.01);
  };
  scalar(1.0f);
  scalar(1.0l);
}

// assess, its dear cases: every structure, and states of every kind. In short: tests/study/preflight.test.cpp.
#include "study/assess_cases.hpp"

using namespace assess_cases;

TEST_CASE("every structure gives the same bound") {
  for (const int n : {50, 300}) {
    const auto y = chain_state(n);
    const double k = 8, m = 2;
    const auto check = [&](const char* name, auto force, double rounding) {
      PhiStepper stepper{y, force, velocity_verlet, mass(m)};
      check_structure(name, n, preflight(stepper, y, 0.01), rounding);
    };
    check("network", spring_network<1>(chain(n, k)), 1e-12);
    check("linear, sparse", linear(chain_matrix(n, k)), 1e-12);
    check("linear, dense", linear(Eigen::MatrixXd(chain_matrix(n, k))), 1e-12);
    // Differences: increments √u × position/16 … position.
    check("differences", ChainForce{k}, 1e-5);
    check("affine", affine(ChainForce{k}), 1e-10);
    check("symmetric", symmetric(ChainForce{k}), 1e-5);
    check("banded", banded(ChainForce{k}, 1, 1), 1e-5);
    check("sparsity", sparsity(ChainForce{k}, chain_matrix(n, 1)), 1e-5);
    check("a sum", term(ChainForce{k}) + UniformForce{Eigen::Matrix<double, 1, 1>{1}}, 1e-5);
    check("by reference", std::ref(*new ChainForce{k}), 1e-5);
  }
}

namespace {

/// r, v and a temperature that decays and drags.
struct Warm {
  Eigen::Vector2d r, v;
  Eigen::Matrix<double, 1, 1> T;
  static constexpr bool drifts = true;
  static auto blocks(auto& y) { return std::tie(y.r, y.v, y.T); }
  struct Rate {
    Eigen::Vector2d force;
    Eigen::Matrix<double, 1, 1> heat;
    static auto blocks(auto& rate) { return std::tie(rate.force, rate.heat); }
  };
};
struct WarmForce {
  void add(double, const auto& y, auto& out) const {
    out.force += -4 * y.r - 0.1 * y.v;
    out.heat -= 50 * y.T;
  }
};
/// A spring whose rest position is remembered.
struct Remembers {
  struct Memory {
    double stiffness = 9;
  };
  void begin(double, double, const auto&, Memory&) const {}
  void add(double, const auto& y, const Memory& memory, auto& out) const { out.force -= memory.stiffness * y.r; }
  void commit(double, const auto&, Memory&) const {}
};

}  // namespace

TEST_CASE("a state of three blocks, a force with memory") {
  const Warm y{{1, 0}, {0, 1}, Eigen::Matrix<double, 1, 1>{3}};
  PhiStepper stepper{y, WarmForce{}, forward_euler};
  const auto report = preflight(stepper, y, 1e-3);
  CHECK(report.whole.rate == Approx(50).epsilon(1e-6));
  CHECK(report.stable_dt == Approx(0.999 * 0.1 / 4).epsilon(1e-5));  // the oscillator's c/ω², below 2/50

  const Motion one{Eigen::Vector2d{1, 0}, Eigen::Vector2d{0, 0}};
  PhiStepper remembering{one, Remembers{}, velocity_verlet};
  CHECK(preflight(remembering, one, 0.1).whole.frequency == Approx(3).epsilon(1e-6));
  remembering.set_memory({25});
  CHECK(preflight(remembering, one, 0.1).whole.frequency == Approx(5).epsilon(1e-6));
}

TEST_CASE("float, long double, maps, several blocks, memory") {
  Motion<Eigen::Vector2f> f{{1, 0}, {0, 0}};
  PhiStepper single{f, [](const Eigen::Vector2f& r) -> Eigen::Vector2f { return -4 * r; }, velocity_verlet};
  CHECK(preflight(single, f, 0.1).stable_dt == Approx(0.999).epsilon(1e-3));
  using Long = Eigen::Matrix<long double, 2, 1>;
  Motion<Long> l{Long{1, 0}, Long{0, 0}};
  PhiStepper extended{l, [](const Long& r) -> Long { return -4 * r; }, velocity_verlet};
  CHECK(preflight(extended, l, 0.1).stable_dt == Approx(0.999).epsilon(1e-8));
  double memory[] = {1, 0, 0, 0};
  using Mapped = Eigen::Map<Eigen::Vector2d>;
  Motion<Mapped> map{Mapped(memory), Mapped(memory + 2)};
  PhiStepper mapped{map, [](const Eigen::Vector2d& r) -> Eigen::Vector2d { return -4 * r; }, velocity_verlet};
  CHECK(preflight(mapped, map, 0.1).stable_dt == Approx(0.999).epsilon(1e-8));
}

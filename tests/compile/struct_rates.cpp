// expect: the state.s Rate needs a block for each of its blocks
// errors: 3
// lines: 30
#include <phistep/phistep.hpp>

#include <tuple>

struct Beads {
  Eigen::VectorXd x, u;
#ifndef MUST_FAIL
  static constexpr bool drifts = true;
#endif
  static auto blocks(auto& all) { return std::tie(all.x, all.u); }
  struct Rate {
    Eigen::VectorXd pull;
    static auto blocks(auto& all) { return std::tie(all.pull); }
  };
};
struct Springs {
  void add(double, const auto& y, auto& out) const { out.pull -= y.x; }
};

int main() {
  Beads y{Eigen::VectorXd::Ones(3), Eigen::VectorXd::Zero(3)};
  phistep::PhiStepper stepper{y, Springs{}, phistep::velocity_verlet};
  return stepper.step(y, 0, 0.1) ? 0 : 1;
}

// expect: give one mass per solved block of the state
#include <phistep/phistep.hpp>

struct Warm {
  Eigen::VectorXd r, v, T;
  static constexpr bool drifts = true;
  static auto blocks(auto& y) { return std::tie(y.r, y.v, y.T); }
  struct Rate {
    Eigen::VectorXd force, heat;
    static auto blocks(auto& q) { return std::tie(q.force, q.heat); }
  };
};
struct Nothing {
  void add(double, const Warm&, Warm::Rate&) const {}
};

int main() {
  Warm y{Eigen::VectorXd::Zero(3), Eigen::VectorXd::Zero(3), Eigen::VectorXd::Zero(1)};
#ifdef MUST_FAIL
  phistep::PhiStepper stepper{y, Nothing{}, phistep::forward_euler, phistep::mass(2.0)};
#else
  phistep::PhiStepper stepper{y, Nothing{}, phistep::forward_euler, phistep::mass(2.0, 3.0)};
#endif
  return stepper.step(y, 0, 0.1) ? 0 : 1;
}

// expect: EnergyLedger needs a motion
#include <phistep/phistep.hpp>

int main() {
  using Vec = Eigen::Vector2d;
  auto decay = [](const Vec& y) -> Vec { return -y; };
#ifdef MUST_FAIL
  Vec state{1, 0};
#else
  phistep::Motion state{Vec{1, 0}, Vec{0, 0}};
#endif
  phistep::PhiStepper stepper{state, decay, phistep::trapezoidal};
  phistep::EnergyLedger ledger{stepper};
  return static_cast<int>(ledger.steps());
}

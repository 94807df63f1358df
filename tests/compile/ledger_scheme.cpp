// expect: EnergyLedger knows no energy balance of this scheme
#include <phistep/phistep.hpp>

int main() {
  using Vec = Eigen::Vector2d;
  auto spring = [](const Vec& r) -> Vec { return -r; };
  phistep::Motion state{Vec{1, 0}, Vec{0, 0}};
#ifdef MUST_FAIL
  phistep::PhiStepper stepper{state, spring, phistep::tr_bdf2};
#else
  phistep::PhiStepper stepper{state, spring, phistep::trapezoidal};
#endif
  phistep::EnergyLedger ledger{stepper};
  return static_cast<int>(ledger.steps());
}

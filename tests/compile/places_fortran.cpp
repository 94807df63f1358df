// expect: places.x, n. of plain numbers may mean x.n. or x.3, n.: write places<1>.x, n. or places<3>.x, n.
#include <phistep/in_place.hpp>

int main() {
  double x[6]{}, v[6]{}, f[6]{};
#ifdef MUST_FAIL
  phistep::MotionInPlace state{phistep::places(x + 0, 2), phistep::places(v + 0, 2), phistep::places(f + 0, 2)};
#else
  phistep::MotionInPlace state{phistep::places<3>(x, 2), phistep::places<3>(v, 2), phistep::places<3>(f, 2)};
#endif
  phistep::PhiStepper stepper{state, state.force_of_r([] {}), phistep::velocity_verlet};
  return stepper.step(state, 0, 0.1) ? 0 : 1;
}

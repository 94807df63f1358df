// expect: no scheme is chosen for a state in place
#include <phistep/automatic.hpp>
#include <phistep/in_place.hpp>

#include <vector>

int main() {
  std::vector<double> y{1, 2}, rate{0, 0};
  phistep::VectorInPlace state{phistep::places(y), phistep::places(rate)};
  const auto decay = [&] { rate[0] = -y[0], rate[1] = -y[1]; };
#ifdef MUST_FAIL
  const auto report = phistep::integrate(state, state.force(decay), {0.0, 1.0}, phistep::tolerance{});
#else
  phistep::PhiStepper stepper{state, state.force(decay), phistep::dop853};
  const auto report = phistep::integrate(stepper, state, {0.0, 1.0}, phistep::tolerance{});
#endif
  return report ? 0 : 1;
}

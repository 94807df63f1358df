// expect: the routine of a state in place is called as routine\(\) or routine\(t\)
#include <phistep/in_place.hpp>

#include <vector>

int main() {
  std::vector<double> u(4, 1.0), rate(4);
  phistep::VectorInPlace state{phistep::places(u), phistep::places(rate)};
  const auto decay = [&](auto... t) {
    static_assert(sizeof...(t) <= 1);
    for (std::size_t i = 0; i < u.size(); ++i) rate[i] = -u[i];
  };
#ifdef MUST_FAIL
  const auto force = state.force([&](const std::vector<double>& x) { rate = x; });
#else
  const auto force = state.force([&] { decay(); });
#endif
  phistep::PhiStepper stepper{state, force, phistep::forward_euler};
  return stepper.step(state, 0, 0.1) ? 0 : 1;
}

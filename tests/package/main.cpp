#include <phistep/phistep.hpp>

#include <cmath>
#include <cstdio>

// A spring of period 2 pi, half a period: the mass arrives on the other side.
int main() {
  static_assert(PHISTEP_VERSION_MAJOR == phistep::version_major);
  auto spring = [](const Eigen::Vector2d& r) -> Eigen::Vector2d { return -r; };
  phistep::Motion state{Eigen::Vector2d{1, 0}, Eigen::Vector2d{0, 0}};
  phistep::PhiStepper stepper{state, spring, phistep::velocity_verlet};
  const double dt = std::acos(-1.0) / 1000;
  for (int n = 0; n < 1000; ++n)
    if (auto step = stepper.step(state, n * dt, dt); !step) return 1;
  std::printf("%.9f %.9f\n", state.r.x(), state.v.x());
  return std::abs(state.r.x() + 1) < 1e-5 && std::abs(state.v.x()) < 1e-5 ? 0 : 1;
}

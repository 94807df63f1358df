// expect: integrate without a stepper chooses dt by its error: tolerance
#include <phistep/automatic.hpp>
#include <phistep/phistep.hpp>

int main() {
  Eigen::Vector2d y{1, 0};
  const auto decay = [](const Eigen::Vector2d& x) -> Eigen::Vector2d { return -x; };
#ifdef MUST_FAIL
  const auto report = phistep::integrate(y, decay, {0.0, 1.0}, phistep::fixed(0.1));
#else
  const auto report = phistep::integrate(y, decay, {0.0, 1.0}, {.rtol = 1e-6});
#endif
  return report ? 0 : 1;
}

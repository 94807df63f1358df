// expect: it is in <phistep/automatic.hpp>
// lines: 12
#include <phistep/phistep.hpp>
#ifndef MUST_FAIL
#include <phistep/automatic.hpp>
#endif

int main() {
  Eigen::Vector2d y{1, 0};
  const auto force = [](const Eigen::Vector2d& u) -> Eigen::Vector2d { return -u; };
  const auto with_capacity =
      phistep::integrate(y, force, phistep::capacity(2.0), {0, 1}, phistep::tolerance{.rtol = 1e-6});
  return phistep::integrate(y, force, {0, 1}, phistep::tolerance{.rtol = 1e-6}) && with_capacity ? 0 : 1;
}

// expect: a lambda, or any other force without a . of its own, is added as term\(f\)
// lines: 12
#include <phistep/phistep.hpp>

int main() {
  const auto drag = [](const Eigen::Vector2d&, const Eigen::Vector2d& v) -> Eigen::Vector2d { return -v; };
#ifdef MUST_FAIL
  const auto force = drag + phistep::Gravity{Eigen::Vector2d{0, -9.81}};
#else
  const auto force = phistep::term(drag) + phistep::Gravity{Eigen::Vector2d{0, -9.81}};
#endif
  static_cast<void>(force);
}

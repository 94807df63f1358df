// expect: check_jacobian needs a force with a Jacobian
#include <phistep/phistep.hpp>

struct Force {
  Eigen::Vector2d operator()(const Eigen::Vector2d& y) const { return -y; }
#ifndef MUST_FAIL
  Eigen::Matrix2d jacobian(const Eigen::Vector2d&) const { return -Eigen::Matrix2d::Identity(); }
#endif
};

int main() { return phistep::check_jacobian(Force{}, Eigen::Vector2d(1, 0)) ? 0 : 1; }

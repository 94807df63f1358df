// A thousand grains with friction fall onto a floor between two walls.
#include <phistep/particles.hpp>

#include <iostream>

using Grains = phistep::Particles<double, 3, phistep::Spin>;
using Eigen::Vector3d;

int main() {
  Eigen::Matrix3Xd r(3, 1000);
  for (Eigen::Index k = 0; k < r.cols(); ++k) r.col(k) << double(k % 10), double(k / 10 % 10), 0.6 + double(k / 100);
  Grains grains{r};
  grains.set_mass(1.0).set_radius(0.5);
  const phistep::Hooke sand{.stiffness = 1e4, .restitution = 0.5, .friction = 0.5, .rolling_friction = 0.1};
  const auto force = phistep::Contact{sand} +
                     phistep::Walls<phistep::Hooke>{sand, phistep::Plane<3>{Vector3d::Zero(), Vector3d::UnitZ()},
                                                    phistep::Plane<3>{Vector3d{-1, 0, 0}, Vector3d::UnitX()}} +
                     phistep::Gravity{Vector3d{0, 0, -9.81}};
  phistep::PhiStepper stepper{grains, force, phistep::symplectic_euler};
  const auto report = phistep::integrate(stepper, grains, {0.0, 0.1}, phistep::fixed(1e-4));
  std::cout << report << '\n';
  return report ? 0 : 1;
}

// expect: to look inside its steps, a stepper must be copyable: give it the force as std::ref
#include <phistep/phistep.hpp>

#include <functional>
#include <memory>

struct Decay {
  std::unique_ptr<double> rate = std::make_unique<double>(2.0);
  Eigen::Vector2d operator()(const Eigen::Vector2d& y) const { return -*rate * y; }
};

int main() {
  Decay decay;
  Eigen::Vector2d y(1, 2);
#ifdef MUST_FAIL
  phistep::PhiStepper stepper{y, std::move(decay), phistep::tr_bdf2};
#else
  phistep::PhiStepper stepper{y, std::ref(decay), phistep::tr_bdf2};
#endif
  return phistep::integrate(stepper, y, {0, 1}, phistep::tolerance{},
                            [](const auto& step) { return step.at(step.t0() + step.dt() / 2).norm() > 0; })
             ? 0
             : 1;
}

// expect: this force has a sparse Jacobian: #include <phistep/sparse.hpp>
#include <phistep/phistep.hpp>

struct Bonds : phistep::ForceTerm {
  static constexpr bool uses_velocity = false, uses_time = false;
  static constexpr phistep::Structure structure = phistep::Structure::sparse;
  void add(double, const auto& y, auto& out) const { out.force -= y.r; }
  void add_jacobian(double, const auto& y, auto& sink) const {
    for (Eigen::Index i = 0; i < y.r.size(); ++i) sink.position(i, i, -1.0);
  }
};

int main() {
  phistep::Motion y{Eigen::Vector4d(0, 0, 1, 0), Eigen::Vector4d(0, 0, 0, 0)};
#ifdef MUST_FAIL
  phistep::PhiStepper stepper{y, Bonds{}, phistep::trapezoidal};
#else
  phistep::PhiStepper stepper{y, Bonds{}, phistep::velocity_verlet};
#endif
  return stepper.step(y, 0, 0.1) ? 0 : 1;
}

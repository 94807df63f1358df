// expect: no member named .y
// errors: 20
// Known to be wrong [48]: the names of a struct's blocks are its own, so both should compile. Once they do, this test
// fails: delete it.
#include <phistep/phistep.hpp>

#include <tuple>

struct Beads {
#ifdef MUST_FAIL
  Eigen::VectorXd x, u;
  static auto blocks(auto& all) { return std::tie(all.x, all.u); }
#else
  Eigen::VectorXd r, v;
  static auto blocks(auto& all) { return std::tie(all.r, all.v); }
#endif
  static constexpr bool drifts = true;
  struct Rate {
    Eigen::VectorXd force;
    static auto blocks(auto& all) { return std::tie(all.force); }
  };
};
struct Springs {
  void add(double, const auto& y, auto& out) const { out.force -= std::get<0>(Beads::blocks(y)); }
};

int main() {
  Beads y{Eigen::VectorXd::Ones(3), Eigen::VectorXd::Zero(3)};
  phistep::PhiStepper stepper{y, Springs{}, phistep::velocity_verlet};
  return stepper.step(y, 0, 0.1) ? 0 : 1;
}

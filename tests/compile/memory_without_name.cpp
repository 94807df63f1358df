// expect: a force with a Memory needs a name to be in a checkpoint
#include <phistep/io/checkpoint.hpp>
#include <phistep/phistep.hpp>

struct Friction : phistep::ForceTerm {
#ifndef MUST_FAIL
  static constexpr const char* name = "friction";
#endif
  struct Memory {
    Eigen::Vector2d anchor{0, 0};
    void archive(auto& ar) { ar("anchor", anchor); }
  };
  static constexpr bool uses_velocity = false, uses_time = false;
  static void add(double /*t*/, const auto& y, const Memory& m, auto& out) { out.force += m.anchor - y.r; }
  static void commit(double /*t*/, const auto& y, Memory& m) { m.anchor = y.r; }
};

int main() {
  phistep::Motion<Eigen::Vector2d> y{{1, 0}, {0, 0}};
  phistep::PhiStepper stepper{y, phistep::UniformForce{Eigen::Vector2d{0, -1}} + Friction{}, phistep::velocity_verlet};
  phistep::save_checkpoint("run.checkpoint", stepper, y);
}

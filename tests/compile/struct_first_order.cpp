// expect: no member named .y
// errors: 20
// Known to be wrong [48]: the names of a struct's blocks are its own, so both should compile. Once they do, this test
// fails: delete it.
#include <phistep/phistep.hpp>

#include <tuple>

struct Pair {
#ifdef MUST_FAIL
  Eigen::Vector2d prey, hunter;
  static auto blocks(auto& all) { return std::tie(all.prey, all.hunter); }
#else
  Eigen::Vector2d y, hunter;
  static auto blocks(auto& all) { return std::tie(all.y, all.hunter); }
#endif
  static constexpr bool drifts = false;
  struct Rate {
    Eigen::Vector2d prey, hunter;
    static auto blocks(auto& all) { return std::tie(all.prey, all.hunter); }
  };
};
struct Decay {
  void add(double, const auto& y, auto& out) const { out.hunter -= y.hunter; }
};

int main() {
  Pair y{Eigen::Vector2d::Ones(), Eigen::Vector2d::Ones()};
  phistep::PhiStepper stepper{y, Decay{}, phistep::forward_euler};
  return stepper.step(y, 0, 0.1) ? 0 : 1;
}

// expect: no scheme is chosen for a force with a history \(contacts, friction\)
#include <phistep/automatic.hpp>
#include <phistep/phistep.hpp>

struct Pull : phistep::ForceTerm {
  struct Memory {
    double largest = 0;
    void begin(auto&&...) {}
    void commit(auto&&...) {}
  };
  static constexpr const char* memory_name = "pull";
  void add(auto, const auto& state, auto& out) const { out.force -= state.r; }
};

int main() {
  phistep::Motion y{Eigen::Vector2d{1, 0}, Eigen::Vector2d{0, 1}};
#ifdef MUST_FAIL
  const auto report = phistep::integrate(y, Pull{}, {0.0, 1.0}, phistep::tolerance{});
#else
  const auto pull = [](const Eigen::Vector2d& r) -> Eigen::Vector2d { return -r; };
  const auto report = phistep::integrate(y, pull, {0.0, 1.0}, phistep::tolerance{});
#endif
  return report ? 0 : 1;
}

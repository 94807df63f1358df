// A run of a state in place, saved and resumed: the file holds what the arrays held, the bits go on.
#include <phistep/in_place.hpp>
#include <phistep/io.hpp>

#include <cmath>
#include <cstddef>
#include <sstream>
#include <vector>

#include "support/catch.hpp"

using namespace phistep;

namespace {

struct Code {
  struct Bead {
    double x[3], v[3], f[3];
  };
  std::vector<Bead> beads;
  Code() : beads(6) {
    for (std::size_t i = 0; i < 6; ++i) {
      const double k = static_cast<double>(i);
      beads[i] = {{0.1 * k + 0.2, 0, 0.1}, {0, 0.3 - 0.1 * k, 0}, {}};
    }
  }
  void forces() {
    for (Bead& bead : beads)
      for (int d = 0; d < 3; ++d) bead.f[d] = -4 * std::sin(bead.x[d]) - 0.3 * bead.x[d] * bead.x[(d + 1) % 3];
  }
};
void check_same(const Code& a, const Code& b) {
  for (std::size_t i = 0; i < 6; ++i)
    for (int d = 0; d < 3; ++d) CHECK((a.beads[i].x[d] == b.beads[i].x[d] && a.beads[i].v[d] == b.beads[i].v[d]));
}
template <class Scheme>
void check_resumed(Scheme scheme, const auto& control) {
  Code saved, resumed;
  std::stringstream file;
  const auto run_of = [&](Code& code, auto&& what) {
    MotionInPlace state{places(code.beads, &Code::Bead::x), places(code.beads, &Code::Bead::v),
                        places(code.beads, &Code::Bead::f)};
    PhiStepper stepper{state, state.force_of_r([&code] { code.forces(); }), scheme};
    Run run{stepper, state, {0, 3}, control};
    what(run);
    REQUIRE(run.finish());
  };
  run_of(saved, [&file](auto& run) {
    for (int k = 0; k < 10; ++k) REQUIRE(run.advance());
    save_checkpoint(file, run);
  });
  run_of(resumed, [&file](auto& run) { load_checkpoint(file, run); });
  check_same(saved, resumed);
}

}  // namespace

TEST_CASE("in place: a run that resumes from a checkpoint goes on with the bits of the run that saved", "[embed]") {
  check_resumed(velocity_verlet, fixed(0.05));
  check_resumed(velocity_verlet, tolerance{.rtol = 1e-5});
}

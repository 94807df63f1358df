// Spring networks, restarted anywhere. In short: restart_motion.test.cpp.
#include <phistep/phistep.hpp>
#include <phistep/sparse.hpp>

#include <utility>

#include "contract/restart.hpp"
#include "contract/restart_motion_cases.hpp"
#include "contract/states.hpp"
#include "problems/spring_net.hpp"
#include "support/catch.hpp"

using namespace phistep;
using namespace restart_motion;
using problems::SpringNet;

namespace {

auto masses() { return mass(SpringNet::masses()); }
/// Pressed to 0.6 of its size, the net wants to buckle: its tangent is indefinite.
Motion<Vec> pressed() {
  auto y = SpringNet::start();
  y.r *= 0.6;
  return y;
}

/// Its Jacobian, entry by entry, as a sparse matrix.
template <class Net>
struct ByEntries : Net {
  static constexpr Structure structure = Structure::sparse;
  static constexpr bool has_edges = false, is_symmetric = false;
  explicit ByEntries(Net net) : Net(std::move(net)) {}
};
template <class Net>
ByEntries(Net) -> ByEntries<Net>;

}  // namespace

TEST_CASE("spring networks solved by conjugate gradients restart to the same bits") {
  const auto start = [] { return SpringNet::start(); };
  const Statistics kept =
      check(loosely({0.001, false}), start, steps(SpringNet::elastic(), tr_bdf2, masses(), tolerant()));
  CHECK(kept.jacobians < kept.steps);
  CHECK(kept.analyses == 1);
  check(uneven, start, steps(SpringNet::damped(), backward_euler, masses()));
  // Pressed springs buckle: what a solve leaves grows with that.
  const Statistics clamped = check({.dt = 0.2, .even = false, .count = 40, .near = 1}, pressed,
                                   steps(SpringNet::elastic(), tr_bdf2, masses(), tolerant()));
  CHECK(clamped.fallbacks > 0);
  check(loosely(uneven), start, steps(SpringNet::elastic() + Driven{}, trapezoidal, masses(), tolerant()));
}

TEST_CASE("spring networks solved by sparse factors restart to the same bits") {
  const auto start = [] { return SpringNet::start(); };
  check(loosely(uneven), start, steps(ByEntries{SpringNet::damped()}, tr_bdf2, masses(), tolerant()));
  const auto by_entries = symmetric(ByEntries{SpringNet::elastic()});
  const Statistics s = check({0.4, false, 30}, pressed, steps(by_entries, backward_euler, masses()));
  CHECK(s.fallbacks > 0);
}

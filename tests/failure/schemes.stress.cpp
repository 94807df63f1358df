// Every scheme × every kind of failure of its force × every call of a whole run: typed and told, no bit changed, and the
// run goes on to the end of the unbroken one.
#include <phistep/phistep.hpp>

#include <string>
#include <vector>

#include "failure/group.hpp"

using namespace faults;
using Vec = Eigen::VectorXd;

namespace {

struct Still {  // Ψ(r)
  Vec operator()(const Vec& r) const { return struck<Vec>(Site::force, states::Pull{}(r)); }
};
struct Damped {  // Ψ(r, v, t)
  Vec operator()(const Vec& r, const Vec& v, double t) const {
    return struck<Vec>(Site::force, states::DampedPull{}(r, v, t));
  }
};
struct Driven {  // Ψ(y, t)
  Vec operator()(const Vec& y, double t) const { return struck<Vec>(Site::force, states::DrivenPull{}(y, t)); }
};
struct Steady {  // Ψ(y)
  Vec operator()(const Vec& y) const { return struck<Vec>(Site::force, states::Pull{}(y)); }
};
const auto motion = [] { return states::SecondOrder<Vec>{}.state; };
const auto flow = [] { return states::FirstOrder<Vec>{}.state; };

const std::vector<Kind> kinds{Kind::nan, Kind::inf, Kind::exception, Kind::size};

/// A class of schemes.
struct Schemes {
  Group group;
  Promise promise{};

  template <class F>
  void add(const char* scheme_name, auto start, F f, auto scheme) {
    const auto make = [f, scheme](auto& y) { return PhiStepper{y, f, scheme}; };
    group.add(scheme_name, machine(start, make, 0.6, fixed(0.1)), Site::force, kinds, promise);
  }
  void tell() const {
    group.tell();
    if (promise.same_end > 0)
      figures::at_most(promise.same_end, group.all.farthest, group.name + ": ends apart", "relative");
  }
};

}  // namespace

TEST_CASE("schemes that iterate nothing: the same bits after any failure") {
  Schemes group{{"no iteration"}};
  group.add("forward_euler", motion, Still{}, forward_euler);
  group.add("symplectic_euler", motion, Still{}, symplectic_euler);
  group.add("velocity_verlet", motion, Still{}, velocity_verlet);
  group.add("rkn86", motion, Still{}, rkn86);
  group.add("rkn1210", motion, Still{}, rkn1210);
  group.add("srkn6b", motion, Still{}, srkn6b);
  group.add("srkn11b", motion, Still{}, srkn11b);
  group.add("tsit5", flow, Steady{}, tsit5);
  group.add("tsit5, motion", motion, Still{}, tsit5);
  group.add("dop853", flow, Steady{}, dop853);
  group.add("dop853, motion", motion, Still{}, dop853);
  group.tell();
}

TEST_CASE("schemes of linear stages, and Radau: the same bits after any failure") {
  Schemes group{{"linear stages, Radau"}};
  group.add("rodas4", flow, Steady{}, rodas4);
  group.add("rodas5p", motion, Still{}, rodas5p);
  group.add("radau", flow, Steady{}, radau);
  group.add("radau, motion", motion, Still{}, radau);
  group.tell();
}

// A run that goes on is a run that starts: it asks six roundings behind its start, where the force may jump.
TEST_CASE("forces of time: the same end up to rounding") {
  Schemes group{{"forces of time"}, {.same_end = 1e-14, .renewed = 1e-13}};
  group.add("forward_euler", motion, Damped{}, forward_euler);
  group.add("symplectic_euler", motion, Damped{}, symplectic_euler);
  group.add("tsit5", flow, Driven{}, tsit5);
  group.add("tsit5, motion", motion, Damped{}, tsit5);
  group.add("dop853", flow, Driven{}, dop853);
  group.add("dop853, motion", motion, Damped{}, dop853);
  group.add("radau", flow, Driven{}, radau);
  group.tell();
}
TEST_CASE("forces of time, with dPsi/dt by differences: the same end up to those") {
  Schemes group{{"dPsi/dt by differences"}, {.same_end = 1e-10, .renewed = 1e-10}};
  group.add("rodas4", flow, Driven{}, rodas4);
  group.add("rodas5p", motion, Damped{}, rodas5p);
  group.tell();
}

TEST_CASE("schemes that Newton solves: the same end up to rounding") {
  Schemes group{{"Newton"}, {.same_end = 1e-14, .renewed = 1e-13}};
  group.add("velocity_verlet, drag", motion, Damped{}, velocity_verlet);
  group.add("symplectic_euler_adjoint, drag", motion, Damped{}, symplectic_euler_adjoint);
  group.add("trapezoidal", motion, Damped{}, trapezoidal);
  group.add("backward_euler", motion, Still{}, backward_euler);
  group.add("midpoint", motion, Damped{}, midpoint);
  group.add("phi(0.7)", motion, Damped{}, phi(0.7));
  group.add("phi(0.6, 0.8)", motion, Damped{}, phi(0.6, 0.8));
  group.add("phi_stage(0.7)", flow, Driven{}, phi_stage(0.7));
  group.add("tr_bdf2", flow, Driven{}, tr_bdf2);
  group.add("rannacher", flow, Driven{}, rannacher);
  group.add("composed(velocity_verlet)", motion, Damped{}, composed(velocity_verlet));
  group.tell();
}

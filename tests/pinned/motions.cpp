// Every scheme on a planet: under a tolerance where the scheme estimates its error, else in equal steps. And what runs have
// around them: events, samples.
#include <Eigen/Core>
#include <phistep/phistep.hpp>

#include <string>
#include <vector>

#include "pinned/pinned.hpp"
#include "problems/kepler_force.hpp"

namespace {

using namespace phistep;
using Eigen::Vector2d;
using Planet = Motion<Vector2d>;
using problems::KeplerForce;

Planet start() { return {Vector2d{0.5, 0}, Vector2d{0, 1.75}}; }

void planet(const char* name, const auto& scheme) {
  pinned::run(std::string("planet, ") + name, [&](pinned::Hash& hash) {
    Planet y = start();
    PhiStepper stepper{y, KeplerForce{}, scheme};
    if constexpr (decltype(stepper)::facts.traces) {
      pinned::good(integrate(stepper, y, {0, 12}, tolerance{.rtol = 1e-6, .atol = 1e-6}));
    } else {
      pinned::good(integrate(stepper, y, {0, 12}, fixed(0.00390625)));
    }
    hash.add(y);
  });
}

const bool added = pinned::added([] {
  planet("trapezoidal", trapezoidal);
  planet("midpoint", midpoint);
  planet("phi(0.6, 0.4)", phi(0.6, 0.4));
  planet("symplectic_euler", symplectic_euler);
  planet("symplectic_euler_adjoint", symplectic_euler_adjoint);
  planet("velocity_verlet", velocity_verlet);
  planet("srkn6b", srkn6b);
  planet("srkn11b", srkn11b);
  planet("composed(velocity_verlet)", composed(velocity_verlet));
  planet("rkn86", rkn86);
  planet("rkn1210", rkn1210);
  planet("tsit5", tsit5);
  planet("dop853", dop853);
  planet("tr_bdf2", tr_bdf2);
  planet("rodas4p2", rodas4p2);
  planet("radau", radau);
  pinned::run("planet, events and samples by rkn86", [](pinned::Hash& hash) {
    Planet y = start();
    PhiStepper stepper{y, KeplerForce{}, rkn86};
    auto turns = event([](const Planet& now) { return now.r.dot(now.v); });
    auto samples =
        sampled(std::vector{0.5, 1.75, 6.0, 11.5}, [&hash](double /*t*/, const Planet& now) { hash.add(now); });
    pinned::good(integrate(stepper, y, {0.125, 20}, tolerance{.rtol = 1e-8, .atol = 1e-8}, turns, samples));
    for (const double t : turns.times()) hash.add(t);
    hash.add(y);
  });
});

}  // namespace

// The same problem in other units. Where length, mass, time and tolerances are scaled by powers of two, every number is
// scaled exactly, and so nothing may change: no bit of the state (scaled back) and no counter. A constant with a hidden
// unit anywhere in the library shows here.
#include <phistep/all.hpp>
#include <phistep/observe/energy_ledger.hpp>

#include <cmath>
#include <source_location>
#include <string>
#include <vector>

#include "acceptance/units.hpp"
#include "support/catch.hpp"

using namespace phistep;
using namespace in_units;

namespace {

const std::vector<Units> others{{20, 0, 0},     {0, -20, 0},   {0, 0, 20},   {-33, 0, 0},  {0, 41, 0},     {0, 0, -60},
                                {-20, 40, -31}, {60, -60, 20}, {-60, 21, 7}, {37, 60, 60}, {-40, -40, -40}};

void check_all(auto&& run, std::source_location where = std::source_location::current()) {
  in_units::check_all(run, others, where);
}
/// A motion under force(units), by scheme and solver(units).
void check_motion(auto scheme, auto&& force, auto&& solver, double dt, int n,
                  std::source_location where = std::source_location::current()) {
  const auto run = [&](const Units& u) {
    Scene scene{u};
    PhiStepper stepper{scene.y, force(u), scheme, mass(scene.masses), solver(u)};
    return march(stepper, scene, dt, n);
  };
  check_all(run, where);
}
const auto to_rounding = [](const Units&) { return newton(); };
const auto chain = [](const Units& u) {
  return [f = Chain{u}](const Vec& r, const Vec& v, double t) -> Vec { return f.all(r, v, t); };
};
const auto tangent_chain = [](const Units& u) { return ChainWithJacobian{u}; };
const auto elastic_chain = [](const Units& u) { return [f = Chain{u}](const Vec& r) -> Vec { return f.elastic(r); }; };

}  // namespace

TEST_CASE("units: explicit schemes and Verlet") {
  check_motion(forward_euler, chain, to_rounding, 0.01, 50);
  check_motion(symplectic_euler, elastic_chain, to_rounding, 0.02, 50);
  check_motion(velocity_verlet, elastic_chain, to_rounding, 0.02, 50);
  check_motion(velocity_verlet, chain, to_rounding, 0.02, 50);  // solves for v
}

TEST_CASE("units: Newton to rounding, by differences") {
  check_motion(trapezoidal, chain, to_rounding, 0.1, 40);
  check_motion(trapezoidal, elastic_chain, to_rounding, 0.3, 40);
  check_motion(backward_euler, chain, to_rounding, 0.5, 20);
  check_motion(midpoint, chain, to_rounding, 0.1, 40);
  check_motion(phi(0.7), chain, to_rounding, 0.1, 40);
  check_motion(phi(0.7, 0.4), chain, to_rounding, 0.05, 40);
  check_motion(tr_bdf2, chain, to_rounding, 0.2, 40);
  check_motion(rannacher(2), chain, to_rounding, 0.1, 20);
}

TEST_CASE("units: Newton to rounding, with an analytic Jacobian") {
  check_motion(trapezoidal, tangent_chain, to_rounding, 0.1, 40);
  check_motion(backward_euler, tangent_chain, to_rounding, 5, 20);
  check_motion(midpoint, tangent_chain, to_rounding, 0.1, 40);
}

TEST_CASE("units: Newton to a tolerance, damped, once") {
  const auto to_tolerance = [](const Units& u) { return newton({.rtol = 1e-4, .atol = u.of(1e-5, 1, 0, -1)}); };
  check_motion(tr_bdf2, chain, to_tolerance, 0.1, 60);
  check_motion(trapezoidal, tangent_chain, to_tolerance, 0.1, 60);
  const auto damped = [](const Units&) { return newton({.line_search = true}); };
  check_motion(backward_euler, tangent_chain, damped, 2, 10);
  const auto once = [](const Units&) { return linearly_implicit(); };
  check_motion(trapezoidal, chain, once, 0.05, 40);
}

TEST_CASE("units: fixed-point iteration, plain and accelerated, to rounding and to a tolerance") {
  const auto solver = [](const Units&) { return fixed_point(); };
  const auto plain = [](const Units&) { return fixed_point({.depth = 0}); };
  const auto to_tolerance = [](const Units& u) { return fixed_point({.rtol = 1e-4, .atol = u.of(1e-5, 1, 0, -1)}); };
  check_motion(trapezoidal, chain, solver, 0.05, 40);
  check_motion(trapezoidal, chain, plain, 0.05, 40);
  check_motion(tr_bdf2, chain, to_tolerance, 0.05, 40);
}

TEST_CASE("units: affine forces, dense and sparse") {
  const auto K = [](const Units& u) {
    Eigen::MatrixXd k = Eigen::MatrixXd::Zero(5, 5);
    for (int i = 0; i < 5; ++i) {
      k(i, i) = u.of(-81.3, 0, 1, -2);
      if (i > 0) k(i, i - 1) = k(i - 1, i) = u.of(40.1, 0, 1, -2);
    }
    return k;
  };
  const auto C = [](const Units& u) { return Eigen::MatrixXd(u.of(-0.3, 0, 1, -1) * Eigen::MatrixXd::Identity(5, 5)); };
  for (const double dt : {0.01, 0.3, 10.0}) {
    check_motion(
        trapezoidal, [&](const Units& u) { return linear(K(u), C(u)); }, to_rounding, dt, 20);
    check_motion(
        backward_euler, [&](const Units& u) { return linear(Eigen::SparseMatrix<double>(K(u).sparseView())); },
        to_rounding, dt, 20);
    check_motion(
        tr_bdf2, [&](const Units& u) { return symmetric(linear(Eigen::SparseMatrix<double>(K(u).sparseView()))); },
        to_rounding, dt, 20);
    check_motion(
        trapezoidal, [&](const Units& u) { return affine([k = K(u)](const Vec& r) -> Vec { return k * r; }); },
        to_rounding, dt, 20);
  }
}

TEST_CASE("units: sparse, banded, chains of blocks, particles by themselves, a matrix-free solver") {
  check_motion(
      trapezoidal, [](const Units& u) { return banded(chain(u), 1, 1); }, to_rounding, 0.1, 20);
  check_motion(
      trapezoidal, [](const Units& u) { return block_tridiagonal<1>(chain(u)); }, to_rounding, 0.1, 20);
  Eigen::SparseMatrix<double> pattern(5, 5);
  for (int i = 0; i < 5; ++i) {
    pattern.insert(i, i) = 1;
    if (i > 0) pattern.insert(i, i - 1) = 1, pattern.insert(i - 1, i) = 1;
  }
  check_motion(
      trapezoidal, [&](const Units& u) { return sparsity(chain(u), pattern); }, to_rounding, 0.1, 20);
  check_motion(
      backward_euler, [&](const Units& u) { return symmetric(sparsity(elastic_chain(u), pattern)); }, to_rounding, 0.1,
      20);
  using One = Eigen::Matrix<double, 1, 1>;
  const auto wells = [](const Units& u) {
    return local<1>([k = u.of(4, 0, 1, -2), q = u.of(9, -2, 1, -2), c = u.of(0.3, 0, 1, -1)](
                        const One& r, const One& v) -> One { return One{-(k + q * r[0] * r[0]) * r[0] - c * v[0]}; });
  };
  check_motion(trapezoidal, wells, to_rounding, 0.2, 40);
  check_motion(
      backward_euler, wells, [](const Units& u) { return newton({.rtol = 1e-4, .atol = u.of(1e-5, 1, 0, -1)}); }, 0.2,
      40);
  const auto krylov = [](const Units&) { return newton<MatrixFree<Eigen::BiCGSTAB>>(); };
  check_motion(trapezoidal, chain, krylov, 0.1, 20);
  check_motion(trapezoidal, tangent_chain, krylov, 0.1, 20);
}

TEST_CASE("units: networks of springs by conjugate gradients") {
  const auto check = [](auto scheme, double dt, auto&& solver, auto&& force) {
    check_all([&](const Units& u) {
      Net net{u};
      PhiStepper stepper{net.y, force(net), scheme, mass(net.masses), solver(u)};
      return march(stepper, net, dt, 15);
    });
  };
  const auto springs = [](const Net& net) { return spring_network<3>(net.springs) + net.gravity(); };
  const auto damped = [](const Net& net) {
    return spring_network<3>(net.springs, SpringDamping{net.u.of(0.8, 0, 1, -1)}) + net.gravity() +
           LinearDrag{net.u.of(0.1, 0, 1, -1)};
  };
  const auto to_tolerance = [](const Units& u) { return newton({.rtol = 1e-4, .atol = u.of(1e-5, 1, 0, -1)}); };
  check(trapezoidal, 0.01, to_rounding, springs);
  check(backward_euler, 0.1, to_rounding, springs);  // with tangents that are indefinite on the way
  check(tr_bdf2, 0.1, to_tolerance, damped);
  check(trapezoidal, 0.05, to_rounding,
        [](const Net& net) { return spring_network<3>(net.springs) + at(forward_euler, net.gravity()); });
}

TEST_CASE("units: steps that are halved") {
  check_all([](const Units& u) {
    Scene scene{u};
    Halving stepper{PhiStepper{scene.y, chain(u), backward_euler, mass(scene.masses), newton({.max_iterations = 4})},
                    12};
    auto result = march(stepper, scene, 0.5, 10);
    CHECK(result.counts.halvings > 0);
    return result;
  });
}

TEST_CASE("units: first-order states") {
  const auto check = [](auto scheme, auto&& force, auto&& solver) {
    check_all([&](const Units& u) {
      Rod rod{u};
      PhiStepper stepper{rod.y, force(rod), scheme, capacity(rod.capacity()), solver(u)};
      return march(stepper, rod, 0.02, 25);
    });
  };
  const auto dense = [](const Rod& rod) { return rod.force(); };
  const auto band = [](const Rod& rod) { return banded(rod.force(), 1, 1); };
  const auto to_tolerance = [](const Units& u) { return newton({.rtol = 1e-4, .atol = u.of(1e-6, 1, 0, 0)}); };
  check(forward_euler, dense, to_rounding);
  check(trapezoidal, dense, to_rounding);
  check(rannacher(2), band, to_rounding);
  check(tr_bdf2, band, to_tolerance);
  check(backward_euler, dense, [](const Units&) { return fixed_point(); });
}

TEST_CASE("units: runs that choose their own steps, the first one included") {
  const auto check = [](auto scheme, auto&& control) {
    check_all([&](const Units& u) {
      Scene scene{u};
      PhiStepper stepper{scene.y, chain(u), scheme, mass(scene.masses)};
      double last = 0, steps = 0;
      const auto report = integrate(stepper, scene.y, {0.0, u.of(3, 0, 0, 1)}, control(u), [&](double t, const auto&) {
        steps += std::ldexp(t - last, -u.time);
        last = t;
      });
      Result result{describe(report.outcome), scene.numbers(), report.statistics};
      result.numbers.conservativeResize(result.numbers.size() + 4);
      result.numbers.tail<4>() << steps, std::ldexp(report.smallest_dt, -u.time),
          std::ldexp(report.largest_dt, -u.time), std::ldexp(report.t, -u.time);
      return result;
    });
    check_all([&](const Units& u) {
      Rod rod{u};
      if constexpr (requires { PhiStepper{rod.y, rod.force(), scheme}; }) {
        PhiStepper stepper{rod.y, rod.force(), scheme, capacity(rod.capacity())};
        const auto report = integrate(stepper, rod.y, {0.0, u.of(1, 0, 0, 1)}, control(u));
        return Result{describe(report.outcome), rod.numbers(), report.statistics};
      } else {
        return Result{"", Vec::Ones(1), {}};
      }
    });
  };
  const auto relative = [](const Units&) { return tolerance{.rtol = 1e-4}; };
  const auto bounded = [](const Units& u) {
    return tolerance{.rtol = 1e-3, .first_step = u.of(0.01, 0, 0, 1), .max_step = u.of(0.1, 0, 0, 1)};
  };
  check(trapezoidal, relative);
  check(backward_euler, bounded);
  check(tr_bdf2, relative);
  check(midpoint, relative);
}

TEST_CASE("units: steps ruled by iterations, or by both; solves by fixed points to the run's own tolerance") {
  const auto by_iterations = [](const Units& u) {
    return iteration_control{.first_step = u.of(0.01, 0, 0, 1), .max_step = u.of(0.5, 0, 0, 1)};
  };
  const auto check = [](auto&& control, auto&& solver) {
    check_all([&](const Units& u) {
      Scene scene{u};
      PhiStepper stepper{scene.y, chain(u), trapezoidal, mass(scene.masses), solver(u)};
      const auto report = integrate(stepper, scene.y, {0.0, u.of(2, 0, 0, 1)}, control(u));
      return Result{describe(report.outcome), scene.numbers(), report.statistics};
    });
  };
  const auto plain = [](const Units& u) {
    return fixed_point({.rtol = 1e-4, .atol = u.of(1e-5, 1, 0, -1), .depth = 0});
  };
  check(by_iterations, plain);
  check([&](const Units& u) { return smaller_of(tolerance{.rtol = 1e-3}, by_iterations(u)); }, plain);
  check([](const Units&) { return tolerance{.rtol = 1e-5}; }, [](const Units&) { return fixed_point(); });
  check([](const Units&) { return tolerance{.rtol = 1e-5}; },
        [](const Units&) { return newton<MatrixFree<Eigen::BiCGSTAB>>(); });
}

TEST_CASE("units: a net in steps of its own choice, with events on the way") {
  check_all([](const Units& u) {
    Net net{u};
    PhiStepper stepper{net.y, spring_network<3>(net.springs) + net.gravity() + LinearDrag{u.of(0.2, 0, 1, -1)}, tr_bdf2,
                       mass(net.masses)};
    double seen = 0, sum = 0;
    const auto height = [low = u.of(-1, 1, 0, 0)](const auto& y) { return y.r.row(2).minCoeff() - low; };
    const auto bounce = [&](double t, auto& y) {
      y.v.row(2) = y.v.row(2).cwiseAbs();
      ++seen;
      sum += std::ldexp(t, -u.time);
    };
    const auto report =
        integrate(stepper, net.y, {0.0, u.of(1.5, 0, 0, 1)}, tolerance{.rtol = 1e-3, .norm = Norm::particle},
                  event(height, {.direction = Direction::falling}, bounce));
    Result result{describe(report.outcome), net.numbers(), report.statistics};
    result.numbers.conservativeResize(98);
    CHECK(seen > 0);
    result.numbers.tail<2>() << seen, sum;
    return result;
  });
}

TEST_CASE("units: a run with an atol of its own") {
  check_all([](const Units& u) {
    Rod rod{u};
    PhiStepper stepper{rod.y, banded(rod.force(), 1, 1), tr_bdf2, capacity(rod.capacity())};
    const auto report =
        integrate(stepper, rod.y, {0.0, u.of(1, 0, 0, 1)}, tolerance{.rtol = 1e-5, .atol = u.of(1e-7, 1, 0, 0)});
    return Result{describe(report.outcome), rod.numbers(), report.statistics};
  });
}

TEST_CASE("units: a run from rest, whose first step only the atol tells") {
  check_all([](const Units& u) {
    Scene scene{u};
    scene.y.r.setZero();
    scene.y.v.setZero();
    PhiStepper stepper{scene.y, chain(u), tr_bdf2, mass(scene.masses)};
    const auto report = integrate(stepper, scene.y, {0.0, u.of(3, 0, 0, 1)},
                                  tolerance{.rtol = 1e-4, .atol = {u.of(1e-5, 1, 0, 0), u.of(1e-4, 1, 0, -1)}});
    return Result{describe(report.outcome), scene.numbers(), report.statistics};
  });
}

TEST_CASE("units: the energy ledger") {
  check_all([](const Units& u) {
    Net net{u};
    PhiStepper stepper{net.y, spring_network<3>(net.springs, SpringDamping{u.of(0.8, 0, 1, -1)}) + net.gravity(),
                       backward_euler, mass(net.masses), newton({.rtol = 1e-3, .atol = u.of(1e-4, 1, 0, -1)})};
    EnergyLedger ledger{stepper};
    const auto report = integrate(stepper, net.y, {0.0, u.of(1, 0, 0, 1)}, fixed(u.of(0.05, 0, 0, 1)), ledger);
    Vec accounts(6);
    accounts << ledger.energy(), ledger.scheme(), ledger.damping(), ledger.solver(), ledger.closure(),
        ledger.largest_closure();
    for (double& x : accounts) x = std::ldexp(x, -2 * u.length - u.mass + 2 * u.time);
    return Result{describe(report.outcome), accounts, report.statistics};
  });
}

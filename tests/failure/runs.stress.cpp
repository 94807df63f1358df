// Failures at every call, around the schemes: Jacobians, linear solvers, every way to solve, controlled runs, observers,
// events and their handlers, forces with a history.
#include <phistep/krylov.hpp>
#include <phistep/sparse.hpp>

#include <Eigen/IterativeLinearSolvers>

#include <limits>
#include <string>
#include <vector>

#include "failure/group.hpp"
#include "problems/slider.hpp"

using namespace faults;
using problems::Slider;
using Vec = Eigen::VectorXd;

namespace {

const auto motion = [] { return states::SecondOrder<Vec>{}.state; };
const auto flow = [] { return states::FirstOrder<Vec>{}.state; };
auto with(auto f, auto... more) {
  return [=](auto& y) { return PhiStepper{y, f, more...}; };
}
const std::vector<Kind> numbers{Kind::nan, Kind::inf, Kind::exception};
const Promise to_rounding{.same_end = 1e-13, .renewed = 1e-12};

/// A chain of cubic springs to the left neighbour; asks the fault before it answers.
struct Chain {
  Vec operator()(const Vec& y) const {
    Vec f(y.size());
    for (Index i = 0; i < y.size(); ++i) f[i] = -2 * y[i] - y[i] * y[i] * y[i] + (i > 0 ? y[i - 1] : 0);
    return struck<Vec>(Site::force, f);
  }
};
struct DenseChain : Chain {
  Eigen::MatrixXd jacobian(const Vec& y) const {
    Eigen::MatrixXd J = Eigen::MatrixXd::Zero(y.size(), y.size());
    for (Index i = 0; i < y.size(); ++i) J(i, i) = -2 - 3 * y[i] * y[i];
    for (Index i = 1; i < y.size(); ++i) J(i, i - 1) = 1;
    return struck<Eigen::MatrixXd>(Site::jacobian, J);
  }
};
struct SparseChain : Chain {
  Eigen::SparseMatrix<double> jacobian(const Vec& y) const {
    Eigen::SparseMatrix<double> J(y.size(), y.size());
    const bool bad = fault.strikes(Site::jacobian);
    std::vector<Eigen::Triplet<double>> entries;
    for (int i = 0; i < static_cast<int>(y.size()); ++i) {
      entries.emplace_back(i, i, bad && i == 2 ? fault.bad() : -2 - 3 * y[i] * y[i]);
      if (i > 0) entries.emplace_back(i, i - 1, 1.0);
    }
    J.setFromTriplets(entries.begin(), entries.end());
    return J;
  }
};
/// LU that refuses, throws, or answers nonsense when the fault says so.
class Fragile : public Eigen::SparseLU<Eigen::SparseMatrix<double>> {
  using Base = Eigen::SparseLU<Eigen::SparseMatrix<double>>;

 public:
  void analyzePattern(const Eigen::SparseMatrix<double>& W) {
    refuses_ = fault.strikes(Site::solver) && fault.kind == Kind::refuses;
    Base::analyzePattern(W);
  }
  void factorize(const Eigen::SparseMatrix<double>& W) {
    refuses_ = fault.strikes(Site::solver) && fault.kind == Kind::refuses;
    Base::factorize(W);
  }
  [[nodiscard]] Eigen::ComputationInfo info() const { return refuses_ ? Eigen::NoConvergence : Base::info(); }
  [[nodiscard]] Vec solve(const auto& b) const {
    Vec x = Base::solve(b);
    if (fault.strikes(Site::solver)) {
      if (fault.kind == Kind::refuses) refuses_ = true;
      else x[0] = fault.bad();
    }
    return x;
  }

 private:
  mutable bool refuses_ = false;
};

struct Damped {
  Vec operator()(const Vec& r, const Vec& v, double t) const {
    return struck<Vec>(Site::force, states::DampedPull{}(r, v, t));
  }
};
struct Pull {
  Vec operator()(const Vec& r) const { return struck<Vec>(Site::force, states::Pull{}(r)); }
};
struct Driven {
  Vec operator()(const Vec& y, double t) const { return struck<Vec>(Site::force, states::DrivenPull{}(y, t)); }
};
struct Push : ForceTerm {  // beside other terms; spoils what they have added
  static constexpr bool uses_velocity = false, uses_time = false;
  void add(double, const auto&, auto& out) const {
    if (fault.strikes(Site::force)) out.force.data()[1] = fault.bad();
  }
};

}  // namespace

TEST_CASE("Jacobians and linear solvers that fail") {
  Group group{"Jacobian or solver"};
  const auto go = [&](const char* label, auto stepper, Site site, const std::vector<Kind>& kinds) {
    group.add(label, machine(flow, stepper, 0.6, fixed(0.1)), site, kinds, to_rounding);
  };
  go("dense Jacobian, trapezoidal", with(DenseChain{}, trapezoidal), Site::jacobian, numbers);
  go("dense Jacobian, rodas4", with(DenseChain{}, rodas4), Site::jacobian, numbers);
  go("dense Jacobian, radau", with(DenseChain{}, radau), Site::jacobian, numbers);
  go("dense Jacobian, rodas4p2", with(DenseChain{}, rodas4p2), Site::jacobian, numbers);
  go("sparse Jacobian, tr_bdf2", with(SparseChain{}, tr_bdf2), Site::jacobian, numbers);
  const std::vector<Kind> solver_kinds{Kind::nan, Kind::refuses, Kind::exception};
  go("own solver, backward_euler", with(SparseChain{}, backward_euler, newton<Fragile>()), Site::solver, solver_kinds);
  go("own solver, rodas4", with(SparseChain{}, rodas4, newton<Fragile>()), Site::solver, solver_kinds);
  group.tell();
}

TEST_CASE("every way to solve") {
  Group group{"ways to solve"};
  const auto go = [&](const char* label, auto start, auto stepper) {
    group.add(label, machine(start, stepper, 0.6, fixed(0.1)), Site::force, numbers, to_rounding);
  };
  go("banded", flow, with(banded(Chain{}, 1, 0), trapezoidal));
  go("fixed_point", flow, with(Chain{}, trapezoidal, fixed_point()));
  go("linearly_implicit", flow, with(Chain{}, trapezoidal, linearly_implicit()));
  Promise by_solver = to_rounding;
  by_solver.in_solver = true;  // products with the matrix are force calls
  group.add("Krylov",
            machine(flow, with(Chain{}, backward_euler, newton<MatrixFree<Eigen::BiCGSTAB>>({.linear_rtol = 1e-12})),
                    0.6, fixed(0.1)),
            Site::force, numbers, by_solver);
  go("springs, conjugate gradients", motion, with(spring_network<3>({{0, 1, 3.0, 1.0}}) + Push{}, backward_euler));
  go("splitting", motion, with(term(Damped{}) + at(forward_euler, Push{}), trapezoidal));
  go("history, Verlet", motion, with(Slider{} + Push{}, velocity_verlet));
  go("history, trapezoidal", motion, with(Slider{} + Push{}, trapezoidal));
  // Around a fault that passes, half steps lead, and are more accurate.
  const Promise by_halves{.same_end = 1e-13, .renewed = 1e-2};
  group.add("Halving",
            machine(
                flow,
                [](auto& y) {
                  return Halving{PhiStepper{y, Chain{}, backward_euler}, 2};
                },
                0.6, fixed(0.1)),
            Site::force, numbers, by_halves);
  group.add("history, Halving",
            machine(
                motion,
                [](auto& y) {
                  return Halving{PhiStepper{y, Slider{} + Push{}, backward_euler}, 2};
                },
                0.6, fixed(0.05)),
            Site::force, numbers, by_halves);
  group.tell();
}

TEST_CASE("controlled runs") {
  Group group{"controlled runs"};
  // What a failure does to Δt changes the end within the tolerance.
  const Promise within{.same_end = 2e-3, .renewed = 2e-3};
  const tolerance control{.rtol = 1e-3, .atol = 1e-4};
  const auto go = [&](const char* label, auto start, auto stepper, const auto& by) {
    group.add(label, machine(start, stepper, 0.6, by), Site::force, numbers, within);
  };
  go("trapezoidal", flow, with(Driven{}, trapezoidal), control);
  go("tr_bdf2", motion, with(Damped{}, tr_bdf2), control);
  go("phi_stage by doubling", flow, with(Driven{}, phi_stage(0.7)), tolerance{.rtol = 1e-2, .atol = 1e-3});
  go("velocity_verlet", motion, with(Damped{}, velocity_verlet), control);
  go("rodas4", flow, with(Driven{}, rodas4), control);
  go("radau", flow, with(Driven{}, radau), control);
  go("tsit5", flow, with(Driven{}, tsit5), control);
  go("dop853", motion, with(Damped{}, dop853), control);
  go("rkn86", motion, with(Pull{}, rkn86), control);
  go("iteration_control", flow, with(Chain{}, trapezoidal, fixed_point()),
     iteration_control{.first_step = 0.05, .order = 1, .max_step = 0.1});
  // Of friction that sticks and slips at rtol = 1e-2, ends can't be compared: another Δt, another slip.
  const double any = std::numeric_limits<double>::infinity();
  group.add("history, Halving, tolerance",
            machine(
                motion,
                [](auto& y) {
                  return Halving{PhiStepper{y, Slider{} + Push{}, backward_euler}, 2};
                },
                0.6, tolerance{.rtol = 1e-2, .atol = 1e-3}),
            Site::force, numbers, {.same_end = any, .renewed = any});
  group.tell();
}

TEST_CASE("observers, events and handlers") {
  Group group{"observers and events"};
  const auto watched = [] {
    return std::tuple{event(
                          [](const auto& y) {
                            const double g = y.r[0] - 0.35;
                            return fault.strikes(Site::event) ? fault.bad() : g;
                          },
                          {},
                          [](double, auto& y) {
                            y.v[0] *= -0.9;
                            static_cast<void>(fault.strikes(Site::handler));
                          }),
                      Recorder<Motion<Vec>>{}, at_times({0.15, 0.33}, [](double, const auto&) {}),
                      sampled(0.07, [](double, const auto&) {}),
                      [](double, const auto&) { static_cast<void>(fault.strikes(Site::observer)); }};
  };
  const auto go = [&](const char* label, auto stepper, const auto& control, double tolerated) {
    const Make make = machine(motion, stepper, 0.9, control, watched);
    const Promise behind{.same_end = tolerated, .renewed = 1e-2, .moves_on = true};  // … with a grid of its own
    // Interpolation asks the force for slopes, for the observers' sake.
    group.add((label + std::string(", force")).c_str(), make, Site::force, numbers, behind);
    group.add((label + std::string(", event")).c_str(), make, Site::event, numbers, behind);
    group.add((label + std::string(", handler")).c_str(), make, Site::handler, {Kind::exception}, behind);
    group.add((label + std::string(", observer")).c_str(), make, Site::observer, {Kind::exception}, behind);
  };
  go("fixed, Verlet", with(Pull{}, velocity_verlet), fixed(0.1), 1e-12);
  go("fixed, trapezoidal", with(Damped{}, trapezoidal), fixed(0.1), 1e-12);
  go("tolerance, tr_bdf2", with(Damped{}, tr_bdf2), tolerance{.rtol = 1e-4, .atol = 1e-5}, 1e-3);
  group.tell();
}

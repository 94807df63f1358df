#include "accuracy/truth/phistep_solvers.hpp"

#include <phistep/advise.hpp>

#include <map>
#include <stdexcept>
#include <string>

#include "accuracy/truth/schemes.hpp"

namespace truth {
namespace {

template <class F>
Solver ours(const char* name, auto scheme, double tightest, bool (*suits)(const Problem&)) {
  return {"phistep", name, tightest, suits,
          [scheme](const Problem& problem, double rtol) { return run<F>(problem, scheme, rtol); }};
}

/// What advise says, done.
Answer advised(const std::vector<Solver>& solvers, const Problem& problem, double rtol) {
  const auto take = [&](const std::string& scheme) -> Answer {
    static const std::map<std::string, std::string> names{
        {"rodas4", "Rodas4"},      {"rodas5p", "Rodas5P"},
        {"rodas4p2", "Rodas4P2"},  {"radau", "Radau"},
        {"tr_bdf2", "TR-BDF2"},    {"rkn86", "RKN 8(6)"},
        {"rkn1210", "RKN 12(10)"}, {"velocity_verlet", "velocity Verlet"},
        {"tsit5", "tsit5"},        {"dop853", "dop853"}};
    const auto name = names.find(scheme);
    if (name != names.end())
      for (const Solver& solver : solvers)
        if (solver.name == name->second) return solver.run(problem, rtol);
    throw std::logic_error("nobody here is called " + scheme);
  };
  const phistep::tolerance wanted{.rtol = rtol, .atol = problem.a * rtol};
  if (is_motion(problem)) {
    const auto n = problem.start.size();
    const phistep::Motion<Eigen::VectorXd> y{problem.start.head(n / 2), problem.start.tail(n / 2)};
    return take(phistep::advise(y, Acceleration{problem}, {0.0, problem.end}, wanted).scheme);
  }
  return take(phistep::advise(problem.start, Force{problem}, {0.0, problem.end}, wanted).scheme);
}

}  // namespace

std::vector<Solver> phistep_solvers() {
  using namespace phistep;
  std::vector<Solver> all;
  all.push_back(ours<Force>("Rodas4", rodas4, 1e-12, has_jacobian));
  all.push_back(ours<Force>("Rodas5P", rodas5p, 1e-12, has_jacobian));
  all.push_back(ours<Force>("Rodas4P2", rodas4p2, 1e-12, has_jacobian));
  all.push_back(ours<Force>("Radau", radau, 1e-12, has_jacobian));
  all.push_back(ours<Force>("TR-BDF2", tr_bdf2, 1e-7, has_jacobian));
  all.push_back(ours<Force>("trapezoidal", trapezoidal, 1e-6, has_jacobian));
  all.push_back(ours<Force>("backward Euler", backward_euler, 1e-3, has_jacobian));
  all.push_back(ours<BareForce>("Rodas5P, differences", rodas5p, 1e-12, has_jacobian));
  all.push_back(ours<Force>("tsit5", tsit5, 1e-12, is_not_stiff));
  all.push_back(ours<Force>("dop853", dop853, 1e-12, is_not_stiff));
  all.push_back(ours<Acceleration>("velocity Verlet", velocity_verlet, 1e-6, is_motion));
  all.push_back(ours<Acceleration>("RKN 8(6)", rkn86, 1e-12, is_motion));
  all.push_back(ours<Acceleration>("RKN 12(10)", rkn1210, 1e-12, is_motion));
  const std::vector<Solver> named = all;
  all.push_back({"phistep", "what advise says", 1e-12, [](const Problem&) { return true; },
                 [named](const Problem& problem, double rtol) { return advised(named, problem, rtol); }});
  return all;
}

Eigen::VectorXd by_radau(const Any& network, const Problem& problem) {
  using Vector = truth::Vector<Eigen::Dynamic>;
  struct LongForce {
    const Any& network;
    Vector operator()(const Vector& y) const {
      Vector rate(y.size());
      network.rate(y, rate);
      return rate;
    }
    [[nodiscard]] Eigen::Matrix<Real, Eigen::Dynamic, Eigen::Dynamic> jacobian(const Vector& y) const {
      Eigen::Matrix<Real, Eigen::Dynamic, Eigen::Dynamic> J;
      J.setZero(y.size(), y.size());
      network.entries(y, [&J](int i, int j, Real x) { J(i, j) += x; });
      return J;
    }
  };
  Vector y = problem.start.cast<Real>();
  phistep::PhiStepper stepper{y, LongForce{network}, phistep::radau};
  const auto report =
      phistep::integrate(stepper, y, {Real(0), static_cast<Real>(problem.end)},
                         phistep::tolerance{.rtol = 1e-13, .atol = 1e-13 * problem.a, .max_steps = 100000});
  if (!report) return {};
  return y.cast<double>();
}

}  // namespace truth

#pragma once

// All schemes for y' = λy, beside their theory.

#include <phistep/phistep.hpp>

#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "accuracy/stability/amplification.hpp"
#include "accuracy/stability/models.hpp"
#include "accuracy/stability/theory.hpp"

namespace stability {

struct Entry {
  std::string family;
  double spacing;  ///< of the grid's cells
  Subject subject;
};

namespace subjects {

using models::Number;
using models::Solve;

inline const Vector zero = Vector::Zero();

template <class R, class Model>
[[nodiscard]] Entry entry(std::string family, double spacing, std::string name, Stepping step, R r, Model model,
                          std::vector<Complex> poles) {
  Subject subject;
  subject.name = std::move(name);
  subject.step = std::move(step);
  subject.R = r;
  subject.model = model;
  subject.poles = std::move(poles);
  return {std::move(family), spacing, std::move(subject)};
}
[[nodiscard]] inline std::vector<Complex> pole_of(double phi) {
  if (phi == 0) return {};
  return {Complex{1 / static_cast<Real>(phi)}};
}

template <bool stage>
void add_phi(std::vector<Entry>& all, const std::string& name, auto scheme, double phi, Solve how, auto... solver) {
  const auto make = [&](auto force) { return stepping(phistep::PhiStepper{zero, force, scheme, solver...}); };
  const auto model = [phi, how](Complex z) {
    return stage ? models::phi_stage(Number{1}, z, phi, how) : models::phi_endpoint(Number{1}, z, phi, how);
  };
  const auto R = [phi](Complex z) { return theory::phi(z, phi); };
  all.push_back(entry(stage ? "phi_stage" : "phi", 1.0 / 16, name, make(Decay{}), R, model, pole_of(phi)));
}

struct WithoutJacobian {
  Point lambda;
  Vector operator()(const Vector& y) const { return Decay{lambda}(y); }
};
/// ½λy
struct Half : phistep::ForceTerm {
  static constexpr bool uses_time = false;
  Point lambda;
  void add(double, const auto& y, auto& out) const { out.rate += 0.5 * (Decay{lambda}.jacobian({}) * y.y); }
  void add_jacobian(double, const auto&, auto& sink) const {
    const Eigen::Matrix2d J = 0.5 * Decay{lambda}.jacobian({});
    for (int i = 0; i < 2; ++i)
      for (int j = 0; j < 2; ++j) sink.rate(i, j, J(i, j));
  }
};

/// The φ-method: named schemes, forms, and ways to solve.
void add_phis(auto& all) {
  using namespace phistep;
  const auto iterated = Solve::iterated, once = Solve::once;
  add_phi<false>(all, "forward_euler", forward_euler, 0, iterated);
  add_phi<false>(all, "trapezoidal", trapezoidal, 0.5, iterated);
  add_phi<false>(all, "backward_euler", backward_euler, 1, iterated);
  add_phi<true>(all, "midpoint", midpoint, 0.5, iterated);
  for (const double x : {0.1, 0.25, 0.4, 0.6, 0.75, 0.9}) {
    add_phi<false>(all, "phi(" + std::to_string(x) + ")", phi(x), x, iterated);
    add_phi<true>(all, "phi_stage(" + std::to_string(x) + ")", phi_stage(x), x, iterated);
  }
  all.push_back(entry(
      "phi", 1.0 / 16, "trapezoidal, Jacobian by differences",
      stepping(PhiStepper{zero, WithoutJacobian{}, trapezoidal}), [](Complex z) { return theory::phi(z, 0.5L); },
      [](Complex z) { return models::phi_endpoint(Number{1}, z, 0.5L, Solve::iterated); }, {Complex{2}}));
  all.back().subject.jacobian = 2 * std::sqrt(2 * unit_roundoff);  // (difference_tangent.hpp)
  for (const double rho : {0.0, 0.3, 0.8, 1.0})
    add_phi<false>(all, "from_spectral_radius(" + std::to_string(rho) + ")", from_spectral_radius(rho), 1 / (1 + rho),
                   iterated);
  for (const double x : {0.3, 0.5, 0.8, 1.0}) {
    add_phi<false>(all, "phi(" + std::to_string(x) + "), linearly_implicit", phi(x), x, once, linearly_implicit());
    add_phi<false>(all, "phi(" + std::to_string(x) + "), fixed_point", phi(x), x, iterated, fixed_point());
    all.back().subject.radius = 1 / x;
    all.back().subject.model = [x](Complex z) { return models::phi_by_iteration(Number{1}, z, x); };
    all.back().family = "phi, fixed_point";
  }
}

/// Schemes of two solves with one matrix.
void add_pairs_of_solves(auto& all) {
  using namespace phistep;
  const Complex pole{2 / (2 - std::sqrt(Real{2}))};
  const auto both = [&](auto force, Solve how, const std::string& suffix) {
    all.push_back(entry(
        "tr_bdf2", 1.0 / 16, "tr_bdf2" + suffix, stepping(PhiStepper{zero, force, tr_bdf2}),
        [](Complex z) { return theory::tr_bdf2(z); }, [how](Complex z) { return models::tr_bdf2(Number{1}, z, how); },
        {pole}));
  };
  both(Decay{}, Solve::iterated, "");
  both(affine(Decay{}), Solve::once, ", affine");
  all.push_back(entry(
      "rannacher", 1.0 / 16, "rannacher, first step", stepping(PhiStepper{zero, Decay{}, rannacher}),
      [](Complex z) { return theory::two_halves(z); },
      [](Complex z) { return models::two_halves(Number{1}, z, Solve::iterated); }, {Complex{2}}));
  all.push_back(entry(
      "rannacher", 1.0 / 16, "rannacher(0), later steps", stepping(PhiStepper{zero, Decay{}, rannacher(0)}),
      [](Complex z) { return theory::phi(z, 0.5L); },
      [](Complex z) { return models::phi_endpoint(Number{1}, z, 0.5L, Solve::iterated); }, {Complex{2}}));
  const auto splits = [&](auto scheme, double x) {
    all.push_back(entry(
        "at(forward_euler, term)", 1.0 / 16, "split, phi = " + std::to_string(x),
        stepping(PhiStepper{zero, Half{} + at(forward_euler, Half{}), scheme}),
        [x](Complex z) { return theory::split(z, x); }, [x](Complex z) { return models::split(Number{1}, z, x); },
        {Complex{2 / static_cast<Real>(x)}}));
  };
  splits(trapezoidal, 0.5);
  splits(backward_euler, 1);
  auto halving = entry(
      "Halving", 1.0 / 16, "Halving of backward_euler", stepping(Halving{PhiStepper{zero, Decay{}, backward_euler}, 4}),
      [](Complex z) { return theory::phi(z, 1); },
      [](Complex z) { return models::phi_endpoint(Number{1}, z, 1, Solve::iterated); }, {Complex{1}});
  halving.subject.instead = [](Complex z) { return theory::two_halves(z); };
  halving.subject.model_instead = [](Complex z) { return models::two_halves(Number{1}, z, Solve::iterated); };
  all.push_back(std::move(halving));
}

void add_rosenbrock(auto& all) {
  using namespace phistep;
  all.push_back(entry(
      "rodas", 1.0 / 8, "rodas4", stepping(PhiStepper{zero, Decay{}, rodas4}),
      [](Complex z) { return theory::rodas4(z); }, [](Complex z) { return models::rosenbrock<Rodas4>(Number{1}, z); },
      {Complex{4}}));
  all.push_back(entry(
      "rodas", 1.0 / 8, "rodas5p", stepping(PhiStepper{zero, Decay{}, rodas5p}),
      [](Complex z) { return theory::rodas5p(z); }, [](Complex z) { return models::rosenbrock<Rodas5P>(Number{1}, z); },
      {Complex{1 / theory::rodas5p.gamma}}));
}

template <int s>
void add_radau_of(std::vector<Entry>& all) {
  using namespace phistep;
  std::vector<Complex> poles;
  for (const auto& mu : radau_tableau<s>.mu) poles.push_back(Complex{1} / Complex{mu.re, mu.im});
  all.push_back(entry(
      "radau", s == 3 ? 1.0 / 8 : 1.0 / 4, "radau(" + std::to_string(s) + ")",
      stepping(PhiStepper{zero, Decay{}, radau(s)}), [](Complex z) { return theory::radau(z, s); },
      [](Complex z) { return models::radau<s>(z); }, std::move(poles)));
}
void add_radau(auto& all) {
  add_radau_of<3>(all);
  add_radau_of<5>(all);
  add_radau_of<7>(all);
}

void add_runge_kutta(auto& all) {
  using namespace phistep;
  all.push_back(entry(
      "explicit Runge-Kutta", 1.0 / 8, "tsit5", stepping(PhiStepper{zero, Decay{}, tsit5}),
      [](Complex z) { return theory::explicit_rk<Tsit5>(z); },
      [](Complex z) { return models::explicit_rk<Tsit5>(Number{1}, z); }, {}));
  all.push_back(entry(
      "explicit Runge-Kutta", 1.0 / 8, "dop853", stepping(PhiStepper{zero, Decay{}, dop853}),
      [](Complex z) { return theory::explicit_rk<Dop853>(z); },
      [](Complex z) { return models::explicit_rk<Dop853>(Number{1}, z); }, {}));
}

void add_composed(auto& all) {
  using namespace phistep;
  std::vector<Complex> poles;
  for (const Real share : theory::kahan_li()) poles.push_back(Complex{2 / share});
  all.push_back(entry(
      "composed", 1.0 / 8, "composed(trapezoidal)", stepping(PhiStepper{zero, Decay{}, composed(trapezoidal)}),
      [](Complex z) { return theory::composed_trapezoidal(z); },
      [](Complex z) { return models::composed_trapezoidal(Number{1}, z, Solve::iterated); }, std::move(poles)));
}

}  // namespace subjects

}  // namespace stability

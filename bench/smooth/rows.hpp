/// @file
/// A problem of tests/problems/detest as a table with phistep's rows.
#pragma once

#include <phistep/phistep.hpp>

#include <Eigen/Core>

#include <algorithm>
#include <type_traits>

#include "../work_precision/phistep_rows.hpp"
#include "tables.hpp"

namespace work_precision::smooth {

/// phistep's schemes for any f(y, t) and f(r, v).
void add_explicit(auto& rows, const std::string& form) {
  rows.controlled("tsit5" + form, phistep::tsit5);
  rows.controlled("dop853" + form, phistep::dop853);
  rows.controlled("extrapolated midpoint" + form, phistep::extrapolated(phistep::forward_euler));
}
/// … and for f(r).
void add_nystrom(auto& rows) {
  rows.controlled("RKN 8(6)", phistep::rkn86);
  rows.controlled("RKN 12(10)", phistep::rkn1210);
}

/// f(y, t)
template <class P>
struct Flow {
  using State = Eigen::Matrix<double, static_cast<int>(P::n), 1>;
  State operator()(const State& y, double t) const {
    State out;
    P::rate(t, y.data(), out.data());
    return out;
  }
};
/// f(r), or f(r, v)
template <class P>
struct Acceleration {
  using Vector = Eigen::Matrix<double, static_cast<int>(P::n) / 2, 1>;
  Vector operator()(const Vector& r) const requires requires(double* x) { P::acceleration(x, x); }
  {
    Vector a;
    P::acceleration(r.data(), a.data());
    return a;
  }
  Vector operator()(const Vector& r, const Vector& v) const requires requires(double* x) { P::acceleration(x, x, x); }
  {
    Vector a;
    P::acceleration(r.data(), v.data(), a.data());
    return a;
  }
};

/// The problem as solvers see it that call back.
template <class P>
struct Callback {
  [[nodiscard]] static Eigen::VectorXd start() {
    const auto y = P::start();
    return Eigen::Map<const Eigen::VectorXd>(y.data(), static_cast<Eigen::Index>(y.size()));
  }
  static void rate(double t, const double* y, double* out) { P::rate(t, y, out); }
  static void jacobian(double, const double*, auto&&) {}  // not stiff: no solver asks for it
};

template <class P>
[[nodiscard]] Table table_of(P) {
  constexpr auto n = static_cast<int>(P::n);
  const auto exact = P::exact();
  Table table{P::name, P::title, Eigen::Map<const Eigen::VectorXd>(exact.data(), n),
              system_of(Shape::explicit_, 1.0, P::end, Callback<P>{})};
  const Eigen::VectorXd start = Callback<P>::start();
  const auto make = [](auto force) {
    return [force](const auto& y, auto scheme, std::size_t) { return phistep::PhiStepper{y, force, scheme}; };
  };
  using State = typename Flow<P>::State;
  PhistepRows flow{table, State(start), make(Flow<P>{})};
  add_explicit(flow, "");
  if constexpr (n % 2 == 0 && (
                                  requires(double* x) { P::acceleration(x, x); } ||
                                  requires(double* x) { P::acceleration(x, x, x); })) {
    using Vector = typename Acceleration<P>::Vector;
    PhistepRows motion{table, phistep::Motion<Vector>{Vector(start.head(n / 2)), Vector(start.tail(n / 2))},
                       make(Acceleration<P>{})};
    if constexpr (requires(double* x) { P::acceleration(x, x); }) add_nystrom(motion);
    else add_explicit(motion, ", f(r, v)");
  }
  return table;
}

template <class... P>
[[nodiscard]] std::vector<Table> tables_of(P... problem) {
  std::vector<Table> tables;
  (tables.push_back(table_of(problem)), ...);
  return tables;
}

}  // namespace work_precision::smooth

/// @file
/// A problem of tests/problems/detest as a table with phistep's rows.
#pragma once

#include <phistep/phistep.hpp>

#include <Eigen/Core>

#include <algorithm>
#include <string>
#include <type_traits>
#include <utility>

#include "../stacked.hpp"
#include "tables.hpp"

namespace work_precision::smooth {

/// phistep's schemes for any f(y, t) and f(r, v).
void add_explicit(auto& rows, const std::string& form) {
  rows.controlled("tsit5" + form, phistep::tsit5);
  rows.controlled("dop853" + form, phistep::dop853);
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

/// phistep's methods on one problem: each stepper serves one call of `integrate`, as in a user's program.
template <class S, class Force>
class Rows {
 public:
  Rows(Table& table, S start) : table_{table}, start_{std::move(start)} {}
  void controlled(const std::string& name, auto scheme) {
    table_.methods.push_back(
        {"phistep", name, "rtol", tolerances(),
         [start = start_, end = table_.system.end(), a = table_.system.a, scheme](double rtol, Film*) {
           S y = start;
           phistep::PhiStepper stepper{y, Force{}, scheme};
           const auto report =
               phistep::integrate(stepper, y, {0.0, end}, phistep::tolerance{.rtol = rtol, .atol = a * rtol});
           if (!report) return Answer{};
           const phistep::Statistics& work = report.statistics;
           return Answer{bench::stacked(y), static_cast<std::int64_t>(work.steps),
                         static_cast<std::int64_t>(work.force_calls)};
         }});
  }

 private:
  Table& table_;
  S start_;
};

template <class P>
[[nodiscard]] Table table_of(P) {
  constexpr auto n = static_cast<int>(P::n);
  const auto exact = P::exact();
  Table table{P::name, P::title, Eigen::Map<const Eigen::VectorXd>(exact.data(), n),
              system_of(Shape::explicit_, 1.0, P::end, Callback<P>{})};
  const Eigen::VectorXd start = Callback<P>::start();
  using State = typename Flow<P>::State;
  Rows<State, Flow<P>> flow{table, start};
  add_explicit(flow, "");
  if constexpr (n % 2 == 0 && (
                                  requires(double* x) { P::acceleration(x, x); } ||
                                  requires(double* x) { P::acceleration(x, x, x); })) {
    using Vector = typename Acceleration<P>::Vector;
    Rows<phistep::Motion<Vector>, Acceleration<P>> motion{table, {start.head(n / 2), start.tail(n / 2)}};
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

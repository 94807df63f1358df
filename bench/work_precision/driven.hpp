/// @file
/// Dense stiff problems whose force uses the time: `rate(t, y, out)` and `entries(t, y, put)`.
#pragma once

#include <phistep/schemes/radau/radau.hpp>
#include <phistep/schemes/rosenbrock.hpp>

#include "first_order.hpp"
#include "phistep_rows.hpp"

namespace work_precision {

/// What phistep steps: the Jacobian is that of everybody.
template <class Problem>
struct Driven {
  using State = typename Problem::State;
  State operator()(const State& y, double t) const {
    State out(y.size());
    Problem::rate(t, y, out);
    return out;
  }
  [[nodiscard]] auto jacobian(const State& y, double t) const {
    constexpr int n = State::RowsAtCompileTime;
    Eigen::Matrix<double, n, n> J = Eigen::Matrix<double, n, n>::Zero(y.size(), y.size());
    Problem::entries(t, y, [&J](auto i, auto j, double x) { J(i, j) += x; });
    return J;
  }
};

template <class Problem>
[[nodiscard]] Table driven_stiff(const char* name, const char* title, double a) {
  using State = typename Problem::State;
  const State start = Problem::start();
  Table table{
      name, title, Problem::exact(), system_of(Shape::dense, a, Problem::end, FirstOrder<State, Problem>{start, {}}),
      0,    6};
  table.system.is_driven = true;
  PhistepRows rows{table, start, [](const auto& y, auto scheme, std::size_t) {
                     return phistep::PhiStepper{y, Driven<Problem>{}, scheme};
                   }};
  // Beyond, rounding in the stages is more than the error allowed (ring modulator): 10⁷ tries.
  rows.controlled("TR-BDF2", phistep::tr_bdf2, -5);
  rows.controlled("Rodas4", phistep::rodas4, -9);
  rows.controlled("Rodas4P2", phistep::rodas4p2, -9);
  rows.controlled("Rodas5P", phistep::rodas5p, -10);
  rows.controlled("Radau", phistep::radau);
  rows.estimate_kappa(phistep::radau);
  return table;
}

/// The same as a term of the force, whose matrix is sparse. Needs <phistep/sparse.hpp>.
template <class Problem>
struct SparseTerm : phistep::ForceTerm {
  static constexpr phistep::Structure structure = phistep::Structure::sparse;
  void add(double t, const auto& y, auto& out) const {
    typename Problem::State rate(y.y.size());
    Problem::rate(t, y.y, rate);
    out.rate += rate;
  }
  void add_jacobian(double t, const auto& y, auto& sink) const {
    Problem::entries(t, y.y, [&sink](auto i, auto j, double x) { sink.rate(i, j, x); });
  }
};

}  // namespace work_precision

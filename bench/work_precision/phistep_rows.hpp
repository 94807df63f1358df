/// @file
/// phistep's rows.
#pragma once

#include <phistep/phistep.hpp>

#include <string>
#include <utility>
#include <vector>

#include "table.hpp"

namespace work_precision {

/// The state as one vector, r before v.
template <class S>
[[nodiscard]] Eigen::VectorXd stacked(const S& y) {
  if constexpr (phistep::EigenDense<S>) {
    return y;
  } else {
    Eigen::VectorXd x(2 * y.r.size());
    x << y.r.reshaped(), y.v.reshaped();
    return x;
  }
}

template <class S>
[[nodiscard]] Answer answer(const phistep::RunReport& report, const S& y) {
  const phistep::Statistics& work = report.statistics;
  return {report ? stacked(y) : Eigen::VectorXd{}, static_cast<std::int64_t>(work.steps),
          static_cast<std::int64_t>(work.force_calls), static_cast<std::int64_t>(work.jacobians),
          static_cast<std::int64_t>(work.factorizations)};
}

/// phistep's methods on one problem.
/// @tparam Make  (state, scheme) → stepper
template <class S, class Make>
class PhistepRows {
 public:
  PhistepRows(Table& table, const S& start, double end, Make make)
      : table_{table}, start_{start}, end_{end}, make_{std::move(make)} {}

  /// Equal steps, end/from … end/to, Newton to rounding.
  void fixed(const std::string& name, auto scheme, int from, int to) {
    table_.methods.push_back({name + ", fixed dt", "dt", steps(end_, from, to),
                              [make = make_, start = start_, end = end_, scheme](double dt) {
                                S y = start;
                                auto stepper = make(y, scheme);
                                const auto report = phistep::integrate(stepper, y, {0, end}, phistep::fixed(dt));
                                return answer(report, y);
                              }});
  }
  /// Steps chosen by the error, to the tolerance (rtol, a·rtol).
  void controlled(const std::string& name, auto scheme, double tightest) {
    table_.methods.push_back({name, "rtol", tolerances(-1, tightest),
                              [make = make_, start = start_, end = end_, a = table_.a, scheme](double rtol) {
                                S y = start;
                                auto stepper = make(y, scheme);
                                const auto report = phistep::integrate(
                                    stepper, y, {0, end}, phistep::tolerance{.rtol = rtol, .atol = a * rtol});
                                return answer(report, y);
                              }});
  }

 private:
  Table& table_;
  S start_;
  double end_;
  Make make_;
};

}  // namespace work_precision

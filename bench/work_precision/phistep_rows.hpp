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

/// Steps of Δt, Newton to rounding.
/// @param make  makes the stepper for a state
template <class S, class Make>
[[nodiscard]] Method fixed_steps(std::string name, const S& start, double end, std::vector<double> ladder, Make make) {
  return {std::move(name), "dt", std::move(ladder), [=](double dt) {
            S y = start;
            auto stepper = make(y);
            const auto report = phistep::integrate(stepper, y, {0, end}, phistep::fixed(dt));
            return answer(report, y);
          }};
}

}  // namespace work_precision

/// @file
/// phistep's rows.
#pragma once

#include <phistep/phistep.hpp>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "../stacked.hpp"
#include "table.hpp"

namespace work_precision {

using bench::stacked;

/// phistep's methods on one problem. A scheme more is a line more: `rows.controlled("TR-BDF2", phistep::tr_bdf2)`.
/// @tparam Make  (state, scheme, leg) → stepper
template <class S, class Make>
class PhistepRows {
 public:
  PhistepRows(Table& table, const S& start, Make make) : table_{table}, run_{start, std::move(make), {}} {
    for (const System::Leg& leg : table.system.legs) run_.ends.push_back(leg.end);
  }

  /// Equal steps, end/from … end/to, Newton to rounding.
  void fixed(const std::string& name, auto scheme, int from, int to) {
    table_.methods.push_back(
        {"phistep", name + ", fixed dt", "dt", steps(run_.ends.back(), from, to),
         [run = run_, scheme](double dt, Film* film) { return run(scheme, phistep::fixed(dt), film); }});
  }
  /// Steps chosen by the error, to the tolerance (rtol, a·rtol).
  void controlled(const std::string& name, auto scheme, double tightest = -13) {
    table_.methods.push_back({"phistep", name, "rtol", tolerances(-1, tightest),
                              [run = run_, scheme, a = table_.system.a](double rtol, Film* film) {
                                return run(scheme, phistep::tolerance{.rtol = rtol, .atol = a * rtol}, film);
                              }});
  }

  /// κ where it isn't known yet: by how much a relative error made at the start, at one of seven later times, or at one of
  /// six a hundred times earlier each, is magnified until the end, at worst of three random ones. A bound from below, found
  /// by `scheme` at a tight tolerance. (What E5 knows of y₂ − y₃ − y₄ at t = 100 is all that it ever knows: 1e10 there.)
  void estimate_kappa(auto scheme, double rtol = 1e-9) {
    if (table_.kappa > 0) return;
    constexpr int tries = 3;
    constexpr double by = 1e-5;
    const double a = table_.system.a, end = run_.ends.back();
    std::vector<double> times{0.0};
    for (int k = 6; k > 0; --k) times.push_back(end * std::pow(100.0, -k));
    for (int k = 1; k < 8; ++k) times.push_back(end * k / 8);
    const auto weight = [a](const auto& x) { return (x.array().abs() + a).eval(); };
    std::mt19937 random{1};
    double kappa = 1, t = 0;
    S y = run_.start;
    for (const double from : times) {
      if (from > t && !run_.go(scheme, y, t, from, a, rtol)) return;
      t = from;
      S right = y;
      if (!run_.go(scheme, right, from, end, a, rtol)) return;
      for (int i = 0; i < tries; ++i) {
        S moved = y;
        const auto shift = [&](auto& x) {
          for (Eigen::Index j = 0; j < x.size(); ++j)
            x.data()[j] += (random() % 2 ? by : -by) * (std::abs(x.data()[j]) + a);
        };
        if constexpr (phistep::EigenDense<S>) shift(moved);
        else shift(moved.r), shift(moved.v);
        if (!run_.go(scheme, moved, from, end, a, rtol)) return;
        kappa =
            std::max(kappa, ((stacked(moved) - stacked(right)).array().abs() / weight(stacked(right))).maxCoeff() / by);
      }
    }
    table_.kappa = kappa;
  }

 private:
  struct Run {
    S start;
    Make make;
    std::vector<double> ends;

    /// From one time to another.
    [[nodiscard]] bool go(auto scheme, S& y, double from, double to, double a, double rtol) const {
      for (std::size_t leg = 0; leg < ends.size(); ++leg) {
        if (from >= ends[leg]) continue;
        const double end = std::min(ends[leg], to);
        if (from >= end) break;
        auto stepper = make(y, scheme, leg);
        if (!phistep::integrate(stepper, y, phistep::TimeSpan<double>{from, end},
                                phistep::tolerance{.rtol = rtol, .atol = a * rtol}))
          return false;
        from = end;
      }
      return true;
    }
    [[nodiscard]] Answer operator()(auto scheme, const auto& control, Film* film) const {
      S y = start;
      Answer answer;
      double from = 0;
      for (std::size_t leg = 0; leg < ends.size(); ++leg) {
        auto stepper = make(y, scheme, leg);
        const phistep::TimeSpan<double> span{from, ends[leg]};
        phistep::RunReport report;
        if (film) {
          std::size_t k = 0;
          const auto take = [&](double t, const auto& now) {
            while (film->times[k] < t) ++k;
            film->put(k, stacked(now).data());
          };
          // Motions stop there, as explicit rivals do; the others look inside their steps.
          if constexpr (phistep::EigenDense<S>)
            report = phistep::integrate(stepper, y, span, control, phistep::sampled(film->times, take));
          else report = phistep::integrate(stepper, y, span, control, phistep::at_times(film->times, take));
        } else {
          report = phistep::integrate(stepper, y, span, control);
        }
        if (!report) return {};
        const phistep::Statistics& work = report.statistics;
        answer.steps += static_cast<std::int64_t>(work.steps);
        answer.force_calls += static_cast<std::int64_t>(work.force_calls);
        answer.jacobians += static_cast<std::int64_t>(work.jacobians);
        answer.factorizations += static_cast<std::int64_t>(work.factorizations);
        from = ends[leg];
      }
      answer.y = stacked(y);
      return answer;
    }
  };

  Table& table_;
  Run run_;
};

}  // namespace work_precision

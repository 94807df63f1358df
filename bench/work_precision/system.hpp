/// @file
/// A problem as libraries see it that call back through a pointer: y' = f(t, y) on bare arrays, y = (r, v) for motions.
/// Odeint's steppers, which are templates, get the problems' own types.
#pragma once

#include <Eigen/Core>

#include <algorithm>
#include <memory>
#include <utility>
#include <vector>

namespace work_precision {

/// What Newton's matrix looks like; `explicit_`: the problem isn't stiff, and nobody needs one.
enum class Shape { explicit_, dense, banded, sparse };

struct System {
  using Rate = int (*)(double t, const double* y, double* out, void* self);               ///< returns 0, as GSL wants
  using Entries = void (*)(double t, const double* y, double* values, const void* self);  ///< in the pattern's order

  /// Until `end` f is that of `self`: where it has a jump, everybody starts again.
  struct Leg {
    double end;
    std::shared_ptr<void> self;
  };

  Shape shape;
  Eigen::VectorXd start;
  double a;  ///< atol = a·rtol
  std::vector<Leg> legs;
  Rate rate;
  Entries entries = nullptr;
  bool is_driven = false;                      ///< f uses t
  std::vector<std::pair<int, int>> pattern{};  ///< (i, j) of the parts of ∂f/∂y: those at one place add up

  [[nodiscard]] int size() const { return static_cast<int>(start.size()); }
  [[nodiscard]] double end() const { return legs.back().end; }
  /// Who needs more steps has lost the solution, and would be at it for minutes.
  [[nodiscard]] long most_steps() const { return size() < 100 ? 200000 : 20000; }
  /// (below, above) the diagonal
  [[nodiscard]] std::pair<int, int> bandwidths() const {
    std::pair<int, int> width{0, 0};
    for (const auto& [i, j] : pattern) width = {std::max(width.first, i - j), std::max(width.second, j - i)};
    return width;
  }
};

/// Of problems with rate(t, y, out), jacobian(t, y, put) and start(); one for each leg.
template <class Problem>
[[nodiscard]] System system_of(Shape shape, double a, const std::vector<std::pair<double, Problem>>& legs) {
  const Problem& first = legs.front().second;
  System system{shape, first.start(), a, {}, [](double t, const double* y, double* out, void* self) {
                  static_cast<const Problem*>(self)->rate(t, y, out);
                  return 0;
                }};
  for (const auto& [end, problem] : legs) system.legs.push_back({end, std::make_shared<Problem>(problem)});
  if (shape == Shape::explicit_) return system;
  system.entries = [](double t, const double* y, double* values, const void* self) {
    static_cast<const Problem*>(self)->jacobian(t, y, [&values](auto, auto, double x) { *values++ = x; });
  };
  first.jacobian(0, system.start.data(), [&system](auto i, auto j, double) {
    system.pattern.emplace_back(static_cast<int>(i), static_cast<int>(j));
  });
  return system;
}
template <class Problem>
[[nodiscard]] System system_of(Shape shape, double a, double end, const Problem& problem) {
  return system_of(shape, a, std::vector<std::pair<double, Problem>>{{end, problem}});
}

}  // namespace work_precision

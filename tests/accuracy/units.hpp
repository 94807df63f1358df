#pragma once

// The same problem in other units: helpers and problems whose every number is scaled by a power of two.

#include <phistep/phistep.hpp>

#include <cmath>
#include <functional>
#include <sstream>
#include <string>
#include <vector>

#include "support/catch.hpp"
#include "support/shared_force.hpp"

namespace in_units {

using namespace phistep;
using Vec = Eigen::VectorXd;

/// Units of 2^length, 2^mass, 2^time.
struct Units {
  int length = 0, mass = 0, time = 0;
  /// x, whose dimension is length^l mass^m time^t, in these units.
  [[nodiscard]] double of(double x, int l, int m, int t) const {
    return std::ldexp(x, l * length + m * mass + t * time);
  }
};
/// What a run leaves, in the first units again.
struct Result {
  std::string outcome;
  Vec numbers;
  Statistics counts;
};
inline void check_same(const Result& a, const Result& b, const Units& u) {
  INFO("units of length 2^" << u.length << ", mass 2^" << u.mass << ", time 2^" << u.time);
  CHECK(b.outcome == a.outcome);
  std::ostringstream ours, theirs;
  ours << a.counts, theirs << b.counts;
  CHECK(theirs.str() == ours.str());
  CHECK(b.counts == a.counts);
  REQUIRE(b.numbers.size() == a.numbers.size());
  Eigen::Index differing = 0;
  for (Eigen::Index i = 0; i < a.numbers.size(); ++i) differing += a.numbers[i] == b.numbers[i] ? 0 : 1;
  CHECK(differing == 0);
}
/// run(units) in every system of units must be run(Units{}).
inline void check_all(const std::function<Result(const Units&)>& run, const std::vector<Units>& others,
                      int line = __builtin_LINE()) {
  INFO("checked in line " << line);
  const Result first = run(Units{});
  REQUIRE(first.numbers.allFinite());
  REQUIRE(first.numbers.norm() > 0);
  for (const Units& u : others) check_same(first, run(u), u);
}

/// A chain of five masses under hardening springs, drag and a drive: nonlinear, and far enough from linear that Newton
/// has something to do.
struct Chain {
  double k, cubic, c, drive, rate;
  explicit Chain(const Units& u)
      : k{u.of(40, 0, 1, -2)},
        cubic{u.of(25, -2, 1, -2)},
        c{u.of(0.3, 0, 1, -1)},
        drive{u.of(3, 1, 1, -2)},
        rate{u.of(1.7, 0, 0, -1)} {}
  void springs(const Vec& r, Vec& f) const {
    for (Eigen::Index i = 0; i <= r.size(); ++i) {
      const double d = (i < r.size() ? r[i] : 0) - (i > 0 ? r[i - 1] : 0), pull = k * d + cubic * d * d * d;
      if (i < r.size()) f[i] -= pull;
      if (i > 0) f[i - 1] += pull;
    }
  }
  Vec elastic(const Vec& r) const {
    Vec f = Vec::Zero(r.size());
    springs(r, f);
    return f;
  }
  Vec all(const Vec& r, const Vec& v, double t) const {
    Vec f = elastic(r) - c * v;
    f[0] += drive * std::sin(rate * t);
    return f;
  }
};
/// The same with its tangents.
struct ChainWithJacobian : Chain {
  using Chain::Chain;
  Vec operator()(const Vec& r, const Vec& v, double t) const { return all(r, v, t); }
  MotionJacobian<Eigen::MatrixXd> jacobian(const Vec& r, const Vec&, double) const {
    const Eigen::Index n = r.size();
    Eigen::MatrixXd K = Eigen::MatrixXd::Zero(n, n), C = -c * Eigen::MatrixXd::Identity(n, n);
    for (Eigen::Index i = 0; i <= n; ++i) {
      const double d = (i < n ? r[i] : 0) - (i > 0 ? r[i - 1] : 0), slope = k + 3 * cubic * d * d;
      if (i < n) K(i, i) -= slope;
      if (i > 0) K(i - 1, i - 1) -= slope;
      if (i > 0 && i < n) K(i, i - 1) += slope, K(i - 1, i) += slope;
    }
    return {K, C};
  }
};

struct Scene {
  Units u;
  Motion<Vec> y{Vec::Zero(5), Vec::Zero(5)};
  Vec masses{Vec::Zero(5)};
  explicit Scene(const Units& units) : u{units} {
    for (int i = 0; i < 5; ++i) {
      y.r[i] = u.of(0.3 + 0.1 * i * i, 1, 0, 0);
      y.v[i] = u.of(i - 1.7, 1, 0, -1);
      masses[i] = u.of(1 + 0.37 * i, 0, 1, 0);
    }
  }
  [[nodiscard]] Vec numbers() const {
    Vec all(2 * y.r.size());
    for (Eigen::Index i = 0; i < y.r.size(); ++i) {
      all[i] = std::ldexp(y.r.data()[i], -u.length);
      all[y.r.size() + i] = std::ldexp(y.v.data()[i], -u.length + u.time);
    }
    return all;
  }
};

/// n steps of dt.
template <class Stepper, class S>
Result march(Stepper& stepper, S& scene, double dt, int n) {
  const double h = scene.u.of(dt, 0, 0, 1);
  std::string outcome = "success";
  for (int k = 0; k < n; ++k)
    if (const auto done = stepper.step(scene.y, k * h, h); !done) {
      outcome = describe(done.outcome()) + std::to_string(k);
      break;
    }
  return {outcome, scene.numbers(), stepper.statistics()};
}
/// A hanging net of 4 × 4 particles.
struct Net {
  Units u;
  Motion<Eigen::Matrix3Xd> y{Eigen::Matrix3Xd::Zero(3, 16), Eigen::Matrix3Xd::Zero(3, 16)};
  Vec masses{Vec::Zero(16)};
  std::vector<Spring> springs;
  explicit Net(const Units& units) : u{units} {
    for (int i = 0; i < 16; ++i) {
      y.r.col(i) << u.of(1.1 * (i % 4), 1, 0, 0), u.of(0.9 * (i / 4), 1, 0, 0), u.of(0.05 * i * i - 0.4, 1, 0, 0);
      masses[i] = u.of(1 + 0.1 * i, 0, 1, 0);
      const auto join = [&](int j) { springs.push_back({i, j, u.of(900 + 20 * i, 0, 1, -2), u.of(1, 1, 0, 0)}); };
      if (i % 4 < 3) join(i + 1);
      if (i < 12) join(i + 4);
    }
  }
  [[nodiscard]] auto gravity() const { return Gravity{Eigen::Vector3d(0, 0, u.of(-9.81, 1, 0, -2))}; }
  [[nodiscard]] Vec numbers() const {
    Vec all(96);
    for (int i = 0; i < 48; ++i) {
      all[i] = std::ldexp(y.r.data()[i], -u.length);
      all[48 + i] = std::ldexp(y.v.data()[i], -u.length + u.time);
    }
    return all;
  }
};
/// Heat in a rod, or any first-order state: its own units are those of length here.
struct Rod {
  Units u;
  Vec y{Vec::Zero(12)};
  explicit Rod(const Units& units) : u{units} {
    for (int i = 0; i < 12; ++i) y[i] = u.of(i < 6 ? 1 : 0.1, 1, 0, 0);
  }
  [[nodiscard]] shared_force::OfState<Vec> force() const {
    return [D = u.of(30, 0, 1, -1), q = u.of(2, -1, 1, -1)](const Vec& x) -> Vec {
      Vec f(x.size());
      for (Eigen::Index i = 0; i < x.size(); ++i)
        f[i] = D * ((i > 0 ? x[i - 1] : 0) - 2 * x[i] + (i + 1 < x.size() ? x[i + 1] : 0)) - q * x[i] * x[i];
      return f;
    };
  }
  [[nodiscard]] double capacity() const { return u.of(1.3, 0, 1, 0); }
  [[nodiscard]] Vec numbers() const { return std::ldexp(1.0, -u.length) * y; }
};

}  // namespace in_units

#pragma once

// One code, six particles on springs, in the memory layouts that codes have. Each layout is a global "code" with a routine
// that reads positions (and velocities) and writes forces there.

#include <phistep/in_place.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <memory>
#include <vector>

namespace layouts {

/// What goes wrong in the routine, and when.
struct Fault {
  enum class Kind { none, nan, thrown } kind = Kind::none;
  int call = 0;  ///< which call, from 1
};
struct Thrown {};

/// The part that all share: the routine itself, on x(i, d), v(i, d), f(i, d).
template <class Self>
struct Code {
  int calls = 0;
  Fault fault{};
  double drag = 0;  ///< [force·time/length]

  void fill() {
    for (std::size_t i = 0; i < self().size(); ++i)
      for (std::size_t d = 0; d < 3; ++d) {
        const auto k = static_cast<double>(3 * i + d);
        self().x(i, d) = (d == 0 ? 1.1 * static_cast<double>(i) : 0.0) + 0.1 * std::sin(k);
        self().v(i, d) = 0.5 * std::cos(2 * k);
        self().f(i, d) = -k;  // anything
      }
  }
  void forces(double t = 0) {
    ++calls;
    const std::size_t n = self().size();
    for (std::size_t i = 0; i < n; ++i)
      for (std::size_t d = 0; d < 3; ++d) self().f(i, d) = -drag * self().v(i, d) + 0.2 * std::sin(3 * t);
    for (std::size_t i = 0; i + 1 < n; ++i)
      for (std::size_t d = 0; d < 3; ++d) {
        const double q = self().x(i + 1, d) - self().x(i, d) - (d == 0 ? 1 : 0), pull = 30 * q + 5 * q * q * q;
        self().f(i, d) += pull;
        self().f(i + 1, d) -= pull;
      }
    if (calls != fault.call) return;
    if (fault.kind == Fault::Kind::nan) self().f(n / 2, 1) = std::numeric_limits<double>::quiet_NaN();
    if (fault.kind == Fault::Kind::thrown) throw Thrown{};
  }
  /// Every number, to be compared: x, v, f.
  [[nodiscard]] std::vector<double> numbers() {
    std::vector<double> all;
    for (std::size_t i = 0; i < self().size(); ++i)
      for (std::size_t d = 0; d < 3; ++d) all.insert(all.end(), {self().x(i, d), self().v(i, d), self().f(i, d)});
    return all;
  }
  /// … without the forces.
  [[nodiscard]] std::vector<double> state() {
    std::vector<double> all;
    for (std::size_t i = 0; i < self().size(); ++i)
      for (std::size_t d = 0; d < 3; ++d) all.insert(all.end(), {self().x(i, d), self().v(i, d)});
    return all;
  }

 private:
  [[nodiscard]] Self& self() { return static_cast<Self&>(*this); }
};

/// An array of structs with members double[3].
struct Structs : Code<Structs> {
  struct Bead {
    double x[3], v[3], f[3], m;
    int id, flags;
  };
  std::vector<Bead> beads;
  explicit Structs(std::size_t n) : beads(n) { fill(); }
  [[nodiscard]] std::size_t size() const { return beads.size(); }
  double& x(std::size_t i, std::size_t d) { return beads[i].x[d]; }
  double& v(std::size_t i, std::size_t d) { return beads[i].v[d]; }
  double& f(std::size_t i, std::size_t d) { return beads[i].f[d]; }
  auto positions() { return phistep::places(beads, &Bead::x); }
  auto velocities() { return phistep::places(beads, &Bead::v); }
  auto rates() { return phistep::places(beads, &Bead::f); }
};

/// Raw arrays double (*)[3].
struct Rows : Code<Rows> {
  std::unique_ptr<double[][3]> x_, v_, f_;
  std::size_t n;
  explicit Rows(std::size_t count)
      : x_(new double[count][3]), v_(new double[count][3]), f_(new double[count][3]), n{count} {
    fill();
  }
  [[nodiscard]] std::size_t size() const { return n; }
  double& x(std::size_t i, std::size_t d) { return x_[i][d]; }
  double& v(std::size_t i, std::size_t d) { return v_[i][d]; }
  double& f(std::size_t i, std::size_t d) { return f_[i][d]; }
  auto positions() { return phistep::places(x_.get(), count()); }
  auto velocities() { return phistep::places(v_.get(), count()); }
  auto rates() { return phistep::places(f_.get(), count()); }
  [[nodiscard]] phistep::Index count() const { return static_cast<phistep::Index>(n); }
};

/// A vector for each component.
struct Components : Code<Components> {
  std::array<std::vector<double>, 3> x_, v_, f_;
  explicit Components(std::size_t n) {
    for (auto* all : {&x_, &v_, &f_})
      for (auto& component : *all) component.resize(n);
    fill();
  }
  [[nodiscard]] std::size_t size() const { return x_[0].size(); }
  double& x(std::size_t i, std::size_t d) { return x_[d][i]; }
  double& v(std::size_t i, std::size_t d) { return v_[d][i]; }
  double& f(std::size_t i, std::size_t d) { return f_[d][i]; }
  auto positions() { return phistep::places(x_[0], x_[1], x_[2]); }
  auto velocities() { return phistep::places(v_[0], v_[1], v_[2]); }
  auto rates() { return phistep::places(f_[0], f_[1], f_[2]); }
};

/// Vectors of a struct of the code's own, and one layout that differs from the others.
struct Vectors : Code<Vectors> {
  struct Vec3 {
    double x, y, z;
  };
  struct Moving {
    Vec3 v;
    int id;
  };
  std::vector<Vec3> x_;
  std::vector<Moving> v_;
  std::vector<double> f_;  ///< with a gap after each three
  explicit Vectors(std::size_t n) : x_(n), v_(n), f_(5 * n) { fill(); }
  [[nodiscard]] std::size_t size() const { return x_.size(); }
  double& x(std::size_t i, std::size_t d) { return (&x_[i].x)[d]; }
  double& v(std::size_t i, std::size_t d) { return (&v_[i].v.x)[d]; }
  double& f(std::size_t i, std::size_t d) { return f_[5 * i + d]; }
  auto positions() { return phistep::places(x_); }
  auto velocities() { return phistep::places(v_, &Moving::v); }
  auto rates() { return phistep::places<3>(f_.data(), static_cast<phistep::Index>(size()), 5); }
};

/// The same particles as a state of the library's own.
[[nodiscard]] inline phistep::Motion<Eigen::Matrix3Xd> owned(auto& code) {
  const auto n = static_cast<Eigen::Index>(code.size());
  phistep::Motion<Eigen::Matrix3Xd> y{Eigen::Matrix3Xd(3, n), Eigen::Matrix3Xd(3, n)};
  for (std::size_t i = 0; i < code.size(); ++i)
    for (std::size_t d = 0; d < 3; ++d) {
      y.r(static_cast<Eigen::Index>(d), static_cast<Eigen::Index>(i)) = code.x(i, d);
      y.v(static_cast<Eigen::Index>(d), static_cast<Eigen::Index>(i)) = code.v(i, d);
    }
  return y;
}
/// The routine as a force for that: f(r, v, t) → f.
template <class Code>
[[nodiscard]] auto copied_force(Code& scratch) {
  return [&scratch](const Eigen::Matrix3Xd& r, const Eigen::Matrix3Xd& v, double t) {
    Eigen::Matrix3Xd f(3, r.cols());
    for (Eigen::Index i = 0; i < r.size(); ++i) {
      const auto p = static_cast<std::size_t>(i / 3), d = static_cast<std::size_t>(i % 3);
      scratch.x(p, d) = r.data()[i], scratch.v(p, d) = v.data()[i];
    }
    scratch.forces(t);
    for (Eigen::Index i = 0; i < r.size(); ++i)
      f.data()[i] = scratch.f(static_cast<std::size_t>(i / 3), static_cast<std::size_t>(i % 3));
    return f;
  };
}
[[nodiscard]] inline std::vector<double> numbers_of(const phistep::Motion<Eigen::Matrix3Xd>& y) {
  std::vector<double> all;
  for (Eigen::Index i = 0; i < y.r.size(); ++i) all.insert(all.end(), {y.r.data()[i], y.v.data()[i]});
  return all;
}

}  // namespace layouts

// Motions, restarted anywhere: networks, splits, particles alone, forces with memory.
#include <phistep/sparse.hpp>

#include <memory>
#include <random>
#include <vector>

#include "contract/restart.hpp"
#include "contract/states.hpp"
#include "problems/argon.hpp"
#include "problems/forced.hpp"
#include "problems/spring_net.hpp"

using namespace phistep;
using problems::SpringNet;
using restart::check;
using restart::Steps;
using Vec = Eigen::VectorXd;
using Eigen::Matrix3d;
using Eigen::Matrix3Xd;
using Eigen::Vector3d;

namespace {

const Steps even{0.05}, uneven{0.05, false};
template <class Solver = void>
auto tolerant() {
  return newton<Solver>({.rtol = 1e-4, .atol = 1e-6});
}
template <class F, class... More>
auto steps(F f, More... more) {
  return [=](const auto& y) { return PhiStepper{y, f, more...}; };
}
auto masses() { return mass(SpringNet::masses()); }

Motion<Vec> six() {
  const auto block = [](const states::Six& x) { return Vec(Eigen::Map<const Vec>(x.data(), 6)); };
  return {block(states::positions), block(states::velocities)};
}
/// Pressed to 0.6 of its size, the net wants to buckle: its tangent is indefinite.
Motion<Vec> pressed() {
  auto y = SpringNet::start();
  y.r *= 0.6;
  return y;
}

/// A pull that moves with time and ignores the velocity: Verlet carries it, with the time that it belongs to.
struct Driven : ForceTerm {
  static constexpr bool uses_velocity = false, uses_time = true;
  void add(auto t, const auto& y, auto& out) const { out.force -= (4 + std::sin(3 * t)) * y.r; }
};
struct Pull : ForceTerm {
  static constexpr bool uses_velocity = false, uses_time = false;
  void add(auto /*t*/, const auto& y, auto& out) const { out.force -= 2 * y.r + y.r.cwiseProduct(y.r); }
};
struct Wind : ForceTerm {
  static constexpr bool uses_velocity = true, uses_time = true;
  void add(auto t, const auto& y, auto& out) const {
    out.force -= 0.1 * y.v;
    out.force.array() += 0.2 * std::cos(t);
  }
};

/// Its Jacobian, entry by entry, as a sparse matrix.
template <class Net>
struct ByEntries : Net {
  static constexpr Structure structure = Structure::sparse;
  static constexpr bool has_edges = false, is_symmetric = false;
  explicit ByEntries(Net net) : Net(std::move(net)) {}
};
template <class Net>
ByEntries(Net) -> ByEntries<Net>;

/// −k r − |r|² r − c v for each particle alone.
struct Well {
  Vector3d operator()(const Vector3d& r, const Vector3d& v) const { return -r - r.squaredNorm() * r - 0.2 * v; }
};
struct WellWithJacobian : Well {
  [[nodiscard]] MotionJacobian<Matrix3d> jacobian(const Vector3d& r, const Vector3d& /*v*/) const {
    const Matrix3d I = Matrix3d::Identity();
    return {-I - (r.squaredNorm() * I + 2 * r * r.transpose()), -0.2 * I};
  }
};
struct Shear {
  Vector3d operator()(const Vector3d& r) const { return {-2 * r[0] + r[1], -r[1], -3 * r[2]}; }
  [[nodiscard]] Matrix3d jacobian(const Vector3d&) const { return Matrix3d{{-2, 1, 0}, {0, -1, 0}, {0, 0, -3}}; }
};
Motion<Matrix3Xd> crowd() {
  std::mt19937 random(7);
  std::normal_distribution<double> normal;
  Motion<Matrix3Xd> y{Matrix3Xd(3, 5), Matrix3Xd(3, 5)};
  for (auto& x : y.r.reshaped()) x = normal(random);
  for (auto& x : y.v.reshaped()) x = normal(random);
  return y;
}

/// Pulls to anchors that follow once the stretch exceeds `slip`.
struct Slider : ForceTerm {
  struct Memory {
    Vec anchor;
    int commits = 0;
    std::vector<double> slips;
    void archive(auto& ar) { ar(anchor, commits, slips); }
  };
  static constexpr bool uses_velocity = false, uses_time = false;
  double k = 30, slip = 0.05;
  static void begin(double, double, const auto& y, Memory& m) {
    if (m.anchor.size() == 0) m.anchor = y.r;
  }
  void add(double, const auto& y, const Memory& m, auto& out) const { out.force -= k * (y.r - m.anchor); }
  void commit(double t, const auto& y, Memory& m) const {
    const Vec before = m.anchor;
    for (Eigen::Index i = 0; i < y.r.size(); ++i) m.anchor[i] = std::clamp(m.anchor[i], y.r[i] - slip, y.r[i] + slip);
    if (before != m.anchor) m.slips.push_back(t);
    ++m.commits;
  }
};
/// A kick drawn anew for each step.
struct Noise : ForceTerm {
  struct Memory {
    std::mt19937_64 random{5};
    double kick = 0;
    void archive(auto& ar) { ar(random, kick); }
  };
  static constexpr bool uses_velocity = false, uses_time = false;
  static void begin(double, double, const auto&, Memory& m) {
    m.kick = std::uniform_real_distribution<double>{-1, 1}(m.random);
  }
  static void add(double, const auto&, const Memory& m, auto& out) { out.force.array() += m.kick; }
  static void commit(double, const auto&, Memory&) {}
};

}  // namespace

TEST_CASE("every scheme of motion restarts to the same bits") {
  states::for_each_motion_scheme([](const char* name, auto scheme) {
    CAPTURE(name);
    check(uneven, six, steps(states::DampedPull{}, scheme));
    check(even, six, steps(Driven{}, scheme));
  });
}

TEST_CASE("Verlet's carried force knows its time") {
  const Statistics s = check(even, six, steps(Driven{}, velocity_verlet));
  CHECK(s.force_calls == 61);
  const auto argon = [] { return problems::Argon::start(); };
  const Statistics fixed = check({1e-5}, argon, steps(problems::Argon{}, velocity_verlet, mass(problems::Argon::mass)));
  CHECK(fixed.force_calls == 61);
  const auto start = [] { return problems::ForcedMotion<>::exact(0); };
  check(uneven, start, steps(problems::ForcedMotion<>{}, velocity_verlet));
  check(uneven, start, steps(problems::ForcedMotion<>{}, tr_bdf2, tolerant()));
  const auto longer = [] { return problems::ForcedMotion<long double>::exact(0); };
  check(uneven, longer, steps(problems::ForcedMotion<long double>{}, tr_bdf2, tolerant()));
}

TEST_CASE("spring networks solved by conjugate gradients restart to the same bits") {
  const auto start = [] { return SpringNet::start(); };
  const Statistics kept = check({0.001, false}, start, steps(SpringNet::elastic(), tr_bdf2, masses(), tolerant()));
  CHECK(kept.jacobians < kept.steps);
  CHECK(kept.analyses == 1);
  check(uneven, start, steps(SpringNet::damped(), backward_euler, masses()));
  const Statistics clamped =
      check({0.2, false, 40}, pressed, steps(SpringNet::elastic(), tr_bdf2, masses(), tolerant()));
  CHECK(clamped.fallbacks > 0);
  check(uneven, start, steps(SpringNet::elastic() + Driven{}, trapezoidal, masses(), tolerant()));
}

TEST_CASE("spring networks solved by sparse factors restart to the same bits") {
  const auto start = [] { return SpringNet::start(); };
  check(uneven, start, steps(ByEntries{SpringNet::damped()}, tr_bdf2, masses(), tolerant()));
  const auto by_entries = symmetric(ByEntries{SpringNet::elastic()});
  const Statistics s = check({0.4, false, 30}, pressed, steps(by_entries, backward_euler, masses()));
  CHECK(s.fallbacks > 0);
}

TEST_CASE("half kicks around an implicit step restart to the same bits") {
  const auto gravity = at(forward_euler, UniformForce{Eigen::Vector2d{0.1, -1}});
  const auto start = [] { return SpringNet::start(); };
  const Statistics constant = check(uneven, start, steps(SpringNet::elastic() + gravity, trapezoidal, masses()));
  CHECK(constant.kick_calls == 1);
  for (const Steps& s : {even, uneven}) {
    const Statistics pull = check(s, six, steps(Driven{} + at(forward_euler, Pull{}), tr_bdf2));
    CHECK(pull.kick_calls == 61);
    check(s, six, steps(Pull{} + at(forward_euler, Driven{}), phi(0.7)));
    check(s, six, steps(Pull{} + at(forward_euler, Wind{}), trapezoidal));
    check(s, six, steps(Pull{} + at(forward_euler, Driven{}), rannacher(3)));
  }
}

TEST_CASE("particles alone restart to the same bits") {
  check(uneven, crowd, steps(local<3>(Well{}), tr_bdf2));
  check(uneven, crowd, steps(local<3>(WellWithJacobian{}), phi(0.7), mass(2.0)));
  const Statistics affine_each = check(even, crowd, steps(affine(local<3>(Shear{})), trapezoidal));
  CHECK(affine_each.factorizations == 1);
  check(uneven, crowd, steps(affine(local<3>(Shear{})), trapezoidal));
}

TEST_CASE("forces with memory go on with their history") {
  for (const Steps& s : {even, uneven}) {
    check(s, six, steps(Slider{}, backward_euler));
    check(s, six, steps(Slider{}, velocity_verlet));
    check(s, six, steps(Slider{} + Pull{} + Noise{}, tr_bdf2, tolerant()));
    check(s, six, steps(Slider{} + at(forward_euler, Noise{}), trapezoidal));
  }
  const auto make = [](const auto& y) { return Halving{PhiStepper{y, Slider{} + Noise{}, trapezoidal}, 4}; };
  check(uneven, six, make);
}

TEST_CASE("states of the user's own") {
  const auto warm = [] { return states::Coupled{}.state; };
  check(uneven, warm, steps(states::WarmPull{}, tr_bdf2, tolerant()));
  check(uneven, warm, steps(states::WarmPull{}, phi(0.7)));
}

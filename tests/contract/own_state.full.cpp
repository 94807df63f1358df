// A struct of blocks as a state: a rigid body, its attitude R and its angular velocity w in its own axes,
//     R' = R [w]×,   I w' = (I w) × w,   I = diag(1, 2, 3).
// Turning about the middle axis it tumbles: w₂ changes its sign each 2 K(k)/p (Landau and Lifshitz, Mechanics, § 37).
#include <phistep/phistep.hpp>

#include <Eigen/Geometry>

#include <cmath>
#include <numbers>
#include <tuple>
#include <vector>

#include "support/catch.hpp"

namespace {
using Eigen::Matrix3d, Eigen::Vector3d;
const Vector3d inertia{1, 2, 3};

/// With drifts, and the name y for the first block: what works today.
struct NamedY {
  Matrix3d y;
  Vector3d w;
  static constexpr bool drifts = false;
  static auto blocks(auto& all) { return std::tie(all.y, all.w); }
  struct Rate {
    Matrix3d y;
    Vector3d w;
    static auto blocks(auto& all) { return std::tie(all.y, all.w); }
  };
};
/// With names of its own, and no word of drifts: nothing here drifts.
struct Body {
  Matrix3d R;
  Vector3d w;
  static auto blocks(auto& all) { return std::tie(all.R, all.w); }
  struct Rate {
    Matrix3d R;
    Vector3d w;
    static auto blocks(auto& all) { return std::tie(all.R, all.w); }
  };
};

template <class State>
struct Tumbling {
  void add(double, const auto& y, auto& out) const {
    const auto [R, w] = State::blocks(y);
    const auto [dR, dw] = State::Rate::blocks(out);
    Matrix3d cross;
    cross << 0, -w[2], w[1], w[2], 0, -w[0], -w[1], w[0], 0;
    dR += R * cross;
    const Vector3d L = inertia.cwiseProduct(w);
    dw += L.cross(Vector3d(w)).cwiseQuotient(inertia);
  }
};

/// What of a run to t = 100 can be told right from wrong.
struct Tumbled {
  bool is_success = false;
  double energy = 1, momentum = 1, attitude = 1;  ///< relative errors of ½ wᵀIw and R I w; ‖RᵀR − 1‖
  std::vector<double> turns = {};                 ///< when w₂ = 0
};
const Vector3d w0{0.01, 2, 0.01};

template <class State, class Scheme, class Control>
Tumbled tumble(Scheme scheme, Control control) {
  State y{Matrix3d::Identity(), w0};
  phistep::PhiStepper stepper{y, Tumbling<State>{}, scheme};
  auto turn = phistep::event([](const State& now) { return now.w[1]; });
  const auto report = phistep::integrate(stepper, y, {0.0, 100.0}, control, turn);
  const auto [R, w] = State::blocks(y);
  const Vector3d L0 = inertia.cwiseProduct(w0), L = inertia.cwiseProduct(w);
  return {bool{report}, std::abs(w.dot(L) / w0.dot(L0) - 1), (R * L - L0).norm() / L0.norm(),
          (R.transpose() * R - Matrix3d::Identity()).norm(), turn.times()};
}

/// 2 K(k)/p, the time between two zeros of w₂.
double half_period() {
  const Vector3d L = inertia.cwiseProduct(w0);
  const double a = w0.dot(L) * inertia[2] - L.squaredNorm(), c = L.squaredNorm() - w0.dot(L) * inertia[0];
  const double p = std::sqrt((inertia[2] - inertia[1]) * c / inertia.prod());
  const double square = (inertia[1] - inertia[0]) * a / ((inertia[2] - inertia[1]) * c);
  double one = 1, other = std::sqrt(1 - square);  // their arithmetic-geometric mean is π/(2 K)
  for (int k = 0; k < 10; ++k) {
    const double mean = (one + other) / 2;
    other = std::sqrt(one * other), one = mean;
  }
  return std::numbers::pi / (one * p);
}

bool is_right(const Tumbled& run, double tolerated, double tolerated_period) {
  UNSCOPED_INFO("energy " << run.energy << ", momentum " << run.momentum << ", attitude " << run.attitude << ", turns "
                          << run.turns.size());
  bool right = run.is_success && run.energy <= tolerated && run.momentum <= tolerated && run.attitude <= tolerated &&
               run.turns.size() == 9;
  for (std::size_t k = 1; right && k < run.turns.size(); ++k)
    right = std::abs((run.turns[k] - run.turns[k - 1]) / half_period() - 1) <= tolerated_period;
  UNSCOPED_INFO("half a period " << half_period());
  return right;
}
template <class State>
bool tumbles() {
  if constexpr (phistep::State<State>) {
    // The implicit midpoint rule keeps all that is quadratic, and these are.
    return is_right(tumble<State>(phistep::dop853, phistep::tolerance{.rtol = 1e-11, .atol = 1e-11}), 1e-8, 1e-5) &&
           is_right(tumble<State>(phistep::midpoint, phistep::fixed(0.01)), 1e-9, 1e-3);
  } else {
    return false;
  }
}
}  // namespace

TEST_CASE("a struct of blocks: a rigid body tumbles", "[contract]") { CHECK(tumbles<NamedY>()); }

TEST_CASE("a struct of blocks has names of its own") { CHECK(tumbles<Body>()); }

namespace {
/// A motion with names of its own.
struct Beads {
  Eigen::VectorXd x, u;
  static constexpr bool drifts = true;
  static auto blocks(auto& all) { return std::tie(all.x, all.u); }
  struct Rate {
    Eigen::VectorXd pull;
    static auto blocks(auto& all) { return std::tie(all.pull); }
  };
};
struct Springs {
  void add(double, const auto& y, auto& out) const { out.pull -= y.x; }
};
}  // namespace

TEST_CASE("a motion of a user's own blocks and names goes as Motion does") {
  const auto ends_alike = [](auto scheme, auto control) {
    Beads own{Eigen::Vector3d(1, 2, 3), Eigen::Vector3d(0, 1, 0)};
    phistep::Motion<Eigen::VectorXd> motion{own.x, own.u};
    phistep::PhiStepper of_own{own, Springs{}, scheme};
    phistep::PhiStepper of_motion{motion, [](const Eigen::VectorXd& r) -> Eigen::VectorXd { return -r; }, scheme};
    return phistep::integrate(of_own, own, {0, 5}, control) && phistep::integrate(of_motion, motion, {0, 5}, control) &&
           (own.x - motion.r).norm() + (own.u - motion.v).norm() <= 1e-9;
  };
  CHECK(ends_alike(phistep::velocity_verlet, phistep::fixed(0.01)));
  CHECK(ends_alike(phistep::midpoint, phistep::fixed(0.01)));
  CHECK(ends_alike(phistep::dop853, phistep::tolerance{.rtol = 1e-8}));
}

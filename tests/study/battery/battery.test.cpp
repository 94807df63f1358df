// The public batteries: what is right passes, and each thing broken is found by the line that is about it.
#include <phistep/battery.hpp>
#include <phistep/particles.hpp>
#include <phistep/phistep.hpp>

#include <string>
#include <tuple>
#include <vector>

#include "support/catch.hpp"

using namespace phistep;

namespace {
[[nodiscard]] std::string broken_lines(const BatteryReport& report) {
  std::string all;
  for (const BatteryReport::Line& line : report.lines)
    if (!line.holds) all += line.text + '\n';
  return all;
}
}  // namespace

#if PHISTEP_QUICK

namespace {
/// Verlet that names an order it hasn't.
template <int named>
struct Boastful : VelocityVerlet {
  [[nodiscard]] static constexpr int order() { return named; }
};
/// Verlet off by the number of steps it has done: a restart doesn't know.
struct Counting : VelocityVerlet {};
/// Verlet off by 1e-9 whatever the units.
struct Absolute : VelocityVerlet {};
/// Verlet whose states inside of steps are NaN.
struct Hollow : VelocityVerlet {};
}  // namespace
template <State S, int named>
class phistep::SchemeOn<Boastful<named>, S> : public SchemeOn<VelocityVerlet, S> {
 public:
  SchemeOn(Boastful<named>, const auto& y) : SchemeOn<VelocityVerlet, S>{velocity_verlet, y} {}
  [[nodiscard]] static int order() { return named; }
};
template <State S>
class phistep::SchemeOn<Counting, S> : public SchemeOn<VelocityVerlet, S> {
 public:
  SchemeOn(Counting, const auto& y) : SchemeOn<VelocityVerlet, S>{velocity_verlet, y} {}
  [[nodiscard]] Outcome step(auto& eq) {
    const Outcome outcome = SchemeOn<VelocityVerlet, S>::step(eq);
    position_of<S>(eq.next)[0] += 1e-6 * eq.dt * eq.dt * ++steps_;
    return outcome;
  }

 private:
  int steps_ = 0;
};
template <State S>
class phistep::SchemeOn<Absolute, S> : public SchemeOn<VelocityVerlet, S> {
 public:
  SchemeOn(Absolute, const auto& y) : SchemeOn<VelocityVerlet, S>{velocity_verlet, y} {}
  [[nodiscard]] Outcome step(auto& eq) {
    const Outcome outcome = SchemeOn<VelocityVerlet, S>::step(eq);
    position_of<S>(eq.next)[0] += 1e-9 * eq.dt * eq.dt * eq.dt;
    return outcome;
  }
};
template <State S>
class phistep::SchemeOn<Hollow, S> : public SchemeOn<VelocityVerlet, S> {
 public:
  static constexpr bool interpolates = true, is_sure_inside = true;
  SchemeOn(Hollow, const auto& y) : SchemeOn<VelocityVerlet, S>{velocity_verlet, y} {}
  [[nodiscard]] static bool know_inside(auto& /*rhs*/, auto /*dt*/, const auto& /*y0*/) { return true; }
  void interpolate(auto /*x*/, auto /*dt*/, const auto& /*y0*/, const auto& /*y1*/, auto& out) const {
    for_each_block([](auto, auto& block) { block.setConstant(NAN); }, Blocks<S>::all(out));
  }
};

TEST_CASE("check_scheme passes Verlet, and finds an order named wrongly, a memory, a number with a unit, NaN inside") {
  CHECK(check_scheme(velocity_verlet));
  CHECK_THAT(broken_lines(check_scheme(Boastful<3>{})), contains("observed order 2.00, named 3"));
  CHECK_THAT(broken_lines(check_scheme(Boastful<1>{})), contains("observed order 2.00, named 1"));
  CHECK_THAT(broken_lines(check_scheme(Counting{})), contains("taken back"));
  CHECK_THAT(broken_lines(check_scheme(Absolute{})), contains("units"));
  CHECK_THAT(broken_lines(check_scheme(Hollow{})), contains("inside of steps"));
}

namespace {
struct Rigid {
  Eigen::Matrix3d R;
  Eigen::Vector3d w;
  static auto blocks(auto& all) { return std::tie(all.R, all.w); }
  struct Rate {
    Eigen::Matrix3d R;
    Eigen::Vector3d w;
    static auto blocks(auto& all) { return std::tie(all.R, all.w); }
  };
};
/// Names its block twice.
struct Twice {
  Eigen::Matrix3d R;
  static auto blocks(auto& all) { return std::tie(all.R, all.R); }
  struct Rate {
    Eigen::Matrix3d R;
    static auto blocks(auto& all) { return std::tie(all.R, all.R); }
  };
};
}  // namespace

TEST_CASE("check_state passes a struct of blocks, and finds one that names a block twice") {
  CHECK(check_state(Rigid{Eigen::Matrix3d::Identity(), {1, 2, 3}}));
  CHECK(check_state(Motion<Eigen::VectorXf>{Eigen::VectorXf::Ones(3), Eigen::VectorXf::Ones(3)}));
  CHECK_THAT(broken_lines(check_state(Twice{Eigen::Matrix3d::Identity()})), contains("adds dt"));
  CHECK_THAT(broken_lines(check_state(Eigen::VectorXd())), contains("has a number"));
}

namespace {
struct Wrong : LennardJones {
  [[nodiscard]] auto energy(auto r2) const { return 1.001 * LennardJones::energy(r2); }
};
struct OtherLanes {
  [[nodiscard]] double operator()(double r2) const { return 1 / r2; }
  [[nodiscard]] auto operator()(auto r2) const { return 1.001 / r2; }
};
struct NoLanes {
  [[nodiscard]] double operator()(double r2) const { return 1 / r2; }
  [[nodiscard]] auto operator()(auto r2) const { return NAN / r2; }
};
struct NoEnergy : LennardJones {
  [[nodiscard]] auto energy(auto r2) const { return NAN * LennardJones::energy(r2); }
};
}  // namespace

TEST_CASE("check_pair_law passes the library's laws, and finds a wrong energy and a lane of its own") {
  CHECK(check_pair_law(LennardJones{}, 0.8, 2.5));
  CHECK(check_pair_law(Yukawa{1, 1}, 0.1, 3));
  CHECK(check_pair_law(ByType{std::vector<LennardJones>(4)}, 0.8, 2.5, 0, 1));
  CHECK(check_pair_law([](auto r2) { return 3 / (r2 * r2); }, 0.5, 2.5));
  CHECK_THAT(broken_lines(check_pair_law(Wrong{}, 0.8, 2.5)), contains("slope of the energy"));
  CHECK_THAT(broken_lines(check_pair_law(OtherLanes{}, 0.8, 2.5)), contains("packs"));
  CHECK_THAT(broken_lines(check_pair_law(NoLanes{}, 0.8, 2.5)), contains("packs"));
  CHECK_THAT(broken_lines(check_pair_law(NoEnergy{}, 0.8, 2.5)), contains("slope of the energy"));
  CHECK_THAT(broken_lines(check_pair_law([](auto r2) { return 1 / (r2 - r2); }, 0.8, 2.5)), contains("finite"));
}

#elif PHISTEP_FULL

TEST_CASE("check_scheme passes the schemes for any state") {
  CHECK(broken_lines(check_scheme(trapezoidal)).empty());
  CHECK(broken_lines(check_scheme(tr_bdf2)).empty());
  CHECK(broken_lines(check_scheme(tsit5)).empty());
  CHECK(broken_lines(check_scheme(rodas5p)).empty());
  CHECK(broken_lines(check_scheme(radau)).empty());
}
TEST_CASE("check_scheme passes the schemes of motion") {
  CHECK(broken_lines(check_scheme(symplectic_euler)).empty());
  CHECK(broken_lines(check_scheme(srkn6b)).empty());
  CHECK(broken_lines(check_scheme(srkn11b)).empty());
  CHECK(broken_lines(check_scheme(rkn86)).empty());
  CHECK(broken_lines(check_scheme(rkn1210)).empty());
  CHECK(broken_lines(check_scheme(hht(-0.1))).empty());
}

#elif PHISTEP_STRESS

TEST_CASE("check_scheme passes all the others") {
  CHECK(broken_lines(check_scheme(forward_euler)).empty());
  CHECK(broken_lines(check_scheme(backward_euler)).empty());
  CHECK(broken_lines(check_scheme(midpoint)).empty());
  CHECK(broken_lines(check_scheme(dop853)).empty());
  CHECK(broken_lines(check_scheme(rodas4)).empty());
  CHECK(broken_lines(check_scheme(composed(trapezoidal))).empty());
  CHECK(broken_lines(check_scheme(generalized_alpha(0.0))).empty());
  CHECK(broken_lines(check_scheme(generalized_alpha(0.8))).empty());
  CHECK(broken_lines(check_scheme(newmark(0.3025, 0.6))).empty());
  CHECK(broken_lines(check_scheme(bossak(-0.1))).empty());
  CHECK(broken_lines(check_scheme(rannacher)).empty());
  CHECK(broken_lines(check_scheme(rodas4p2)).empty());
}

#endif

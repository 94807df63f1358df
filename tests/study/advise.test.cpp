// What is advised, and how stiffness is found out.
#include <phistep/advise.hpp>
#include <phistep/sparse.hpp>

#include <cmath>
#include <sstream>
#include <string>

#include "support/catch.hpp"
#if PHISTEP_QUICK
#include "support/shared_force.hpp"
#endif
#if PHISTEP_STRESS
#include "problems/brusselator_1d.hpp"
#include "problems/kepler.hpp"
#include "problems/pollution.hpp"
#include "problems/robertson.hpp"
#include "problems/van_der_pol.hpp"
#endif

namespace advise_cases {

using namespace phistep;

/// A scene of n unknowns, without its stiffness.
inline AdvisedProblem scene(std::int64_t n, double rtol, Structure structure = Structure::dense) {
  AdvisedProblem s;
  s.unknowns = n;
  s.rtol = rtol;
  s.structure = structure;
  s.has_jacobian = true;
  return s;
}
inline Stiffness stiffness(bool is_stiff) {
  Stiffness s;
  s.known = true;
  s.is_stiff = is_stiff;
  s.covered = 1;
  s.steps = 100;
  s.rate = s.dt = 1;
  return s;
}
inline std::string choice(const AdvisedProblem& s, bool is_stiff) { return decide(s, stiffness(is_stiff)).scheme; }

/// r'' = −ω² r − 2ζω v
struct Oscillator {
  double omega, zeta;
  using Vec = Eigen::Vector2d;
  Vec operator()(const Vec& r, const Vec& v) const { return -omega * omega * r - 2 * zeta * omega * v; }
};

/// The fastest rate of an oscillation and of a decay, in any units, as a stepper of the scheme has the slopes.
inline void check_rates(auto scheme) {
  using Plain = Motion<Eigen::Vector2d>;
  for (const double unit : {1.0, 1e-9, 1e9}) {
    Plain y{Eigen::Vector2d(unit, 0), Eigen::Vector2d(0, 300 * unit)};
    Plain weight = y;
    ErrorNorm<Plain> norm;
    REQUIRE(norm.begin(tolerance{.rtol = 1e-2}, y));
    norm.weigh(y, weight);
    for (const double zeta : {0.0, 50.0}) {
      PhiStepper stepper{y, Oscillator{300, zeta}, scheme};
      SpectralRadius<Plain> radius{y};
      const double rho = radius([&](double t, const Plain& x, Plain& out) { return stepper.slope(t, x, out); }, 0.0, y,
                                weight, 1e-2, 8);
      // |λ| = ω undamped, ζω + √(ζ²−1) ω damped; differences of √u.
      const double exact = zeta == 0 ? 300 : 300 * (zeta + std::sqrt(zeta * zeta - 1));
      CHECK(rho == Approx(exact).epsilon(1e-3));
      CHECK(radius.turn() == Approx(zeta == 0 ? -1 : 1).epsilon(1e-3));
    }
  }
}

}  // namespace advise_cases

using namespace advise_cases;

#if PHISTEP_QUICK

namespace {

auto advise_on(const shared_force::OfState<Eigen::Vector2d>& force) {
  return advise(Eigen::Vector2d(1, 1), force, {0.0, 1.0});
}

}  // namespace

TEST_CASE("the rate is found where it is: in a decay, an oscillation, after a transient, in any units") {
  check_rates(velocity_verlet);
}

TEST_CASE("real problems get what wins on their diagrams") {
  const auto decays = [](double rate) {
    return advise_on([rate](const Eigen::Vector2d& y) -> Eigen::Vector2d { return {-y[0], -rate * (y[1] - y[0])}; });
  };
  const auto stiff = decays(1e6), slow = decays(2);
  CHECK(stiff.stiffness.known);
  CHECK(stiff.stiffness.is_stiff);
  CHECK(stiff.stiffness.rate == Approx(1e6).epsilon(0.1));
  CHECK(stiff.stiffness.steps < 30);
  CHECK((stiff.scheme == "rodas4p2" || stiff.scheme == "radau" || stiff.scheme == "rodas5p"));
  CHECK(slow.stiffness.known);
  CHECK_FALSE(slow.stiffness.is_stiff);
  CHECK(slow.scheme == "dop853");
}

TEST_CASE("the rules, one by one") {
  Stiffness at_once = stiffness(true);
  CHECK(decide(scene(3, 1e-6), at_once).message().find("|lambda| = 1 limits explicit steps to dt = 1 ") !=
        std::string::npos);
  at_once.steps = 0;  // its dt is that of the first step that the error allows
  CHECK(decide(scene(3, 1e-6), at_once).message().find("|lambda| = 1, where the error allows dt = 1 ") !=
        std::string::npos);
  // A problem of the diagrams each, with the digits at which its best scheme changes.
  CHECK(choice(scene(3, 1e-3), true) == "rodas4p2");
  CHECK(choice(scene(3, 1e-4), true) == "rodas5p");
  CHECK(choice(scene(3, 1e-5), true) == "radau");
  AdvisedProblem pollution = scene(20, 1e-2);
  pollution.has_sparse_lu = true;
  CHECK(choice(pollution, true) == "rodas4p2");
  pollution.rtol = 1e-9;
  CHECK(choice(pollution, true) == "rodas5p");
  pollution.rtol = 1e-11;
  CHECK(choice(pollution, true) == "radau");
  CHECK(choice(scene(20, 1e-6), true) == "rodas5p");
  CHECK(choice(scene(20, 1e-7), true) == "radau");
  AdvisedProblem modulator = scene(15, 1e-2);
  modulator.is_driven = true;
  CHECK(choice(modulator, true) == "rodas4p2");
  modulator.rtol = 1e-3;
  CHECK(choice(modulator, true) == "radau");
  AdvisedProblem beam = scene(80, 1e-2);
  beam.has_jacobian = false;
  CHECK(choice(beam, true) == "rodas4p2");
  beam.rtol = 1e-5;
  CHECK(choice(beam, true) == "rodas5p");
  beam.rtol = 1e-6;
  CHECK(choice(beam, true) == "radau");
  CHECK(choice(scene(1000, 1e-2, Structure::banded), true) == "rodas4p2");
  CHECK(choice(scene(1000, 1e-5, Structure::banded), true) == "rodas5p");
  CHECK(choice(scene(1000, 1e-6, Structure::banded), true) == "radau");
  CHECK(choice(scene(96, 1e-2, Structure::sparse), true) == "radau");
  CHECK(choice(scene(1000, 1e-3, Structure::sparse), true) == "rodas5p");
  CHECK(choice(scene(1000, 1e-4, Structure::sparse), true) == "radau");
  AdvisedProblem heat = scene(4096, 1e-7, Structure::sparse);
  heat.is_affine = true;
  CHECK(choice(heat, true) == "rodas5p");
  heat.rtol = 1e-8;
  CHECK(choice(heat, true) == "radau");
  CHECK(choice(scene(1000, 1e-3, Structure::network), true) == "tr_bdf2");
  AdvisedProblem blind = scene(5000, 1e-6);
  blind.has_jacobian = false;
  CHECK(choice(blind, true) == "tr_bdf2");
  CHECK_FALSE(decide(blind, stiffness(true)).warnings.empty());

  AdvisedProblem motion = scene(6, 1e-6);
  motion.is_motion = true;
  CHECK(choice(motion, false) == "rkn86");
  CHECK(choice(motion, true) == "radau");
  motion.rtol = 1e-10;
  CHECK(choice(motion, false) == "rkn1210");
  motion.uses_velocity = true;
  CHECK(choice(motion, false) == "dop853");
  motion.rtol = 5e-4;
  CHECK(choice(motion, false) == "dop853");
  motion.rtol = 1e-3;
  CHECK(choice(motion, false) == "dop853");
  motion.uses_velocity = false, motion.rtol = 1e-3, motion.unknowns = 30000;
  CHECK(choice(motion, false) == "velocity_verlet");
  motion.has_history = true;
  CHECK(choice(motion, false) == "velocity_verlet");
  CHECK(decide(motion, stiffness(false)).control == "phistep::fixed(dt)");

  Stiffness odd = stiffness(true);
  odd.doubts = " More tries failed (200) than steps were done (100).";
  CHECK_THAT(decide(scene(3, 1e-6), odd).message(), contains("but the run looked at was odd: More tries failed"));

  AdvisedProblem much = scene(3, 1e-16);
  CHECK_THAT(decide(much, stiffness(true)).message(), contains("below what a number of 15 digits can hold"));
}

TEST_CASE("a force that throws or is not finite is no reason to throw") {
  const auto thrown = advise_on([](const Eigen::Vector2d&) -> Eigen::Vector2d { throw std::runtime_error("no"); });
  CHECK_THAT(thrown.message(), contains("could not be found out"));
  const auto advice = advise_on([](const Eigen::Vector2d&) -> Eigen::Vector2d { return {NAN, NAN}; });
  CHECK_FALSE(advice.stiffness.known);
  std::ostringstream text;
  text << advice;
  CHECK(text.str() == advice.message());
}

#elif PHISTEP_STRESS
// advise, on real problems.

namespace {

struct WithPattern : problems::Pollution {
  static constexpr auto jacobian_pattern =
      pattern_of<20>([](const auto& y, auto&& put) { problems::Pollution::entries(y, put); });
};
/// Twelve unknowns that follow the time, stiffly.
struct Driven {
  using State = Eigen::Matrix<double, 12, 1>;
  State operator()(const State& y, double t) const { return (std::cos(t) - y.array()).matrix() * 1e4; }
};

}  // namespace

TEST_CASE("the rate is found where it is: in a decay, an oscillation, after a transient, in any units") {
  check_rates(tr_bdf2);
  // Robertson's reaction: 0.04 at the start, thousands after a millisecond.
  using problems::Robertson;
  const auto found = advise(Robertson::start(), Robertson{}, {0.0, Robertson::end}, {.rtol = 1e-6, .atol = 1e-12});
  CHECK(found.stiffness.is_stiff);
  CHECK(found.stiffness.rate > 2000);
  CHECK(found.stiffness.rate < 4000);
  CHECK(found.stiffness.steps < 40);
}

TEST_CASE("a long run is not followed to its end: 200 steps, and so it is said") {
  const problems::Kepler kepler;
  const auto advice = advise(kepler.start(), kepler, {0.0, 6000.0}, tolerance{.rtol = 1e-6});
  CHECK(advice.stiffness.steps <= 200);
  CHECK(advice.stiffness.covered < 0.1);
  CHECK_FALSE(advice.stiffness.is_stiff);
  CHECK_THAT(advice.message(), contains("rkn86") && contains("% of the span"));
}

TEST_CASE("real problems get what wins on their diagrams") {
  const auto stiff = [](double rtol) {
    return advise(problems::Robertson::start(), problems::Robertson{}, {0.0, 40.0},
                  tolerance{.rtol = rtol, .atol = 1e-6 * rtol})
        .scheme;
  };
  CHECK(stiff(1e-2) == "rodas4p2");
  CHECK(stiff(1e-9) == "radau");
  using B = problems::Brusselator1D;
  CHECK(advise(B::start(), B{}, {0.0, 1.0}, tolerance{.rtol = 1e-5}).scheme == "rodas5p");
  CHECK(advise(B::start(), B{}, {0.0, 1.0}, tolerance{.rtol = 1e-6}).scheme == "radau");
  using P = problems::Pollution;
  const auto digits = tolerance{.rtol = 1e-8, .atol = 1e-12};
  CHECK(advise(P::start(), WithPattern{}, {0.0, P::end}, digits).scheme == "rodas5p");
  CHECK(advise(P::start(), P{}, {0.0, P::end}, digits).scheme == "radau");
  const Driven::State rest = Driven::State::Zero();
  CHECK(advise(rest, Driven{}, {0.0, 1.0}, tolerance{.rtol = 1e-3, .atol = 1e-3}).scheme == "radau");
  using V = problems::VanDerPol;
  CHECK(advise(V::start(), V{}, {0.0, V::end}, tolerance{.rtol = 1e-6}).scheme == "dop853");
}

TEST_CASE("a force that throws or is not finite is no reason to throw") {
  const Eigen::Vector2d y{1, 1};
  const auto thrower = [](const Eigen::Vector2d&) -> Eigen::Vector2d { throw std::runtime_error("no"); };
  CHECK_THAT(advise(y, thrower, {0.0, 1.0}).message(), contains("could not be found out"));
  const auto nan = [](const Eigen::Vector2d&) -> Eigen::Vector2d { return {NAN, NAN}; };
  const auto advice = advise(y, nan, {0.0, 1.0});
  CHECK_FALSE(advice.stiffness.known);
  std::ostringstream text;
  text << advice;
  CHECK(text.str() == advice.message());
}

#endif

// advise, on real problems. The quick half is advise.test.cpp.
#include "problems/brusselator_1d.hpp"
#include "problems/kepler.hpp"
#include "problems/pollution.hpp"
#include "problems/robertson.hpp"
#include "problems/van_der_pol.hpp"
#include "study/advise_cases.hpp"

using namespace advise_cases;

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

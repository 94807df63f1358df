// The facts of the schemes, as docs/reference/schemes.md has them. (That they are true: the full tier.)
#include <phistep/phistep.hpp>

#include <cmath>
#include <complex>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>

#include "support/catch.hpp"

namespace scheme_facts_cases {

using namespace phistep;

/// f(scheme, as users write it)
void for_each_scheme(auto&& f) {
  f(forward_euler, "forward_euler");
  f(trapezoidal, "trapezoidal");
  f(midpoint, "midpoint");
  f(backward_euler, "backward_euler");
  f(phi(0.7), "phi(0.7)");
  f(symplectic_euler, "symplectic_euler");
  f(symplectic_euler_adjoint, "symplectic_euler_adjoint");
  f(phi(0.6, 0.4), "phi(0.6, 0.4)");
  f(velocity_verlet, "velocity_verlet");
  f(srkn6b, "srkn6b");
  f(srkn11b, "srkn11b");
  f(composed(velocity_verlet), "composed(velocity_verlet)");
  f(rkn86, "rkn86");
  f(rkn1210, "rkn1210");
  f(tsit5, "tsit5");
  f(dop853, "dop853");
  f(tr_bdf2, "tr_bdf2");
  f(rannacher, "rannacher");
  f(generalized_alpha(0.8), "generalized_alpha(0.8)");
  f(newmark(0.3025, 0.6), "newmark(0.3025, 0.6)");
  f(hht(-0.1), "hht(-0.1)");
  f(bossak(-0.1), "bossak(-0.1)");
  f(rodas4, "rodas4");
  f(rodas4p2, "rodas4p2");
  f(rodas5p, "rodas5p");
  f(radau, "radau");
}

}  // namespace scheme_facts_cases

using namespace scheme_facts_cases;

#if PHISTEP_QUICK

namespace {

using Vec = Eigen::VectorXd;
static_assert(!std::is_default_constructible_v<SchemeFacts> && !std::is_default_constructible_v<ExplicitMotion> &&
                  !std::is_default_constructible_v<AStable>,
              "a fact that is left out doesn't compile");

template <class Scheme>
std::string line(const Scheme& scheme, const std::string& name) {
  constexpr SchemeFacts facts = Scheme::facts;
  using S = std::conditional_t<facts.motion_only, Motion<Vec>, Vec>;
  using On = SchemeOn<Scheme, S>;
  const auto yes = [](bool x) { return x ? std::string("yes") : std::string("-"); };
  S y;
  const int order = On(scheme, y).order();
  return "| `" + name + "` | " + std::to_string(order) + " | " + (facts.motion_only ? "motion" : "any") + " | " +
         (facts.is_explicit ? "explicit" : "implicit") + " | " +
         (facts.is_l_stable   ? "L"
          : facts.is_a_stable ? "A"
                              : "-") +
         " | " + yes(facts.is_symplectic) + " | " + yes(On::traces) + " | " + yes(On::interpolates) + " |\n";
}

}  // namespace

TEST_CASE("docs/reference/schemes.md has the schemes' facts") {
  std::string table =
      "| scheme | order | states | where the force ignores v | stable for all decay | symplectic | estimates its error "
      "| "
      "interpolant of its own |\n|---|---|---|---|---|---|---|---|\n";
  for_each_scheme([&table](const auto& scheme, const char* name) { table += line(scheme, name); });
  std::ifstream in(std::filesystem::path(PHISTEP_SOURCE_DIR) / "docs/reference/schemes.md");
  REQUIRE(in);
  const std::string text{std::istreambuf_iterator<char>(in), {}};
  INFO("it should have\n" << table);
  CHECK(text.find(table) != std::string::npos);
}

#elif PHISTEP_FULL
// The facts of the schemes, each asked of the steps themselves.

namespace {

using One = Eigen::Matrix<double, 1, 1>;
using Complex = std::complex<double>;

/// The factor R(z) of one step of y' = zy, as a rotation and stretching of the plane; after Rannacher's start.
template <class Scheme>
Complex factor(const Scheme& scheme, Complex z) {
  Eigen::Matrix2d A;
  A << z.real(), -z.imag(), z.imag(), z.real();
  Eigen::Vector2d y{1, 0};
  PhiStepper stepper{y, linear(A), scheme};
  REQUIRE(stepper.step(y, 0, 1));
  y << 1, 0;
  REQUIRE(stepper.step(y, 1, 1));
  return {y[0], y[1]};
}

/// The area by which one step of a pendulum maps a small square, divided by the square's: differences of order 4.
template <class Scheme>
double area(const Scheme& scheme) {
  const auto pendulum = [](const One& r) -> One { return One{-std::sin(r[0])}; };
  constexpr double d = 1e-3;
  Eigen::Matrix2d tangent = Eigen::Matrix2d::Zero();
  for (int j = 0; j < 2; ++j)
    for (const auto& [side, weight] : {std::pair{-2, 1}, {-1, -8}, {1, 8}, {2, -1}}) {
      Motion<One> y{One{1.1 + (j == 0 ? side * d : 0)}, One{0.4 + (j == 1 ? side * d : 0)}};
      PhiStepper stepper{y, pendulum, scheme};
      REQUIRE(stepper.step(y, 0, 1.5));
      tangent.col(j) += weight / (12 * d) * Eigen::Vector2d(y.r[0], y.v[0]);
    }
  return tangent.determinant();
}

}  // namespace

TEST_CASE("facts: who is explicit factorizes nothing, who isn't does") {
  for_each_scheme([](const auto& scheme, const char* name) {
    CAPTURE(name);
    Motion<One> y{One{1.0}, One{0.0}};
    PhiStepper stepper{y, [](const One& r) -> One { return One{-std::sin(r[0])}; }, scheme};
    REQUIRE(stepper.step(y, 0, 0.1));
    CHECK((stepper.statistics().factorizations == 0) == scheme.facts.is_explicit);
  });
}

TEST_CASE("facts: A-stable schemes let nothing grow that decays or oscillates, L-stable ones leave nothing of it") {
  for_each_scheme([](const auto& scheme, const char* name) {
    using Scheme = std::remove_cvref_t<decltype(scheme)>;
    CAPTURE(name);
    if constexpr (!Scheme::facts.motion_only) {
      double most = 0;
      for (const double size : {0.1, 0.7, 2.0, 5.0, 20.0, 300.0, 1e5})
        for (const double angle : {0.5, 0.55, 0.6, 0.75, 1.0})
          most = std::max(most, std::abs(factor(scheme, std::polar(size, angle * 3.14159265358979323846))));
      const double at_infinity = std::abs(factor(scheme, -1e8));
      CAPTURE(most, at_infinity);
      // phi(0.7) is A-stable by its value, which the type doesn't know.
      CHECK((most <= 1 + 1e-9) == (scheme.facts.is_a_stable || std::string_view(name) == "phi(0.7)"));
      CHECK((at_infinity <= 1e-6) == scheme.facts.is_l_stable);
    }
  });
}

TEST_CASE("facts: symplectic schemes keep the area of a pendulum's phase plane, others don't") {
  for_each_scheme([](const auto& scheme, const char* name) {
    CAPTURE(name);
    const double off = std::abs(area(scheme) - 1);
    CAPTURE(off);
    if (scheme.facts.is_symplectic) CHECK(off <= 1e-10);
    else CHECK(off >= 1e-9);
  });
}

#endif

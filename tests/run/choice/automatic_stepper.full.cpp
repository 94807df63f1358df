// Automatic steppers of motions, nets, singular masses and views of the caller's numbers; the others: automatic_stepper.test.
#include "problems/drum.hpp"
#include "run/choice/automatic_cases.hpp"

using namespace automatic_cases;

TEST_CASE("motion: the pair that ignores v, to the bit; stiff bonds: an implicit scheme") {
  const tolerance wanted{.rtol = 1e-6};
  const auto damped = [](const Vec& r, const Vec& v) -> Vec { return Vec{-1e6 * r[0] - 1e5 * v[0], -r[1]}; };
  Motion z{Vec{1, 1}, Vec{0, 0}};
  const auto report = integrate(z, damped, {0.0, 5.0}, wanted);
  REQUIRE(report);
  CHECK(report.schemes.count() == 2);
  CHECK(z.r[1] == Approx(std::cos(5.0)).epsilon(1e-5));
}

TEST_CASE("a net of stiff springs and dashpots: TR-BDF2 on conjugate gradients, to the tolerance") {
  using problems::Drum;
  Drum::State y = Drum::start();
  const auto report = integrate(y, Drum::force(), mass(Drum::masses()), {0.0, Drum::end}, {.rtol = 1e-4, .atol = 1e-4});
  REQUIRE(report);
  REQUIRE(report.schemes.count() == 2);
  CHECK(report.schemes.list()[1].scheme == SuitableScheme::tr_bdf_2);
  CHECK(report.schemes.list()[1].rate > 4e4);  // 1.6e5, seen from below
  CHECK(report.statistics.linear_iterations > 100);
  CHECK(report.statistics.steps < 1000);  // explicit ones: 40,000
  const Eigen::VectorXd exact = Drum::exact();
  const auto samples = Drum::samples();
  const Eigen::Index n = y.r.size();
  for (std::size_t k = 0; k < samples.size(); ++k) {
    const double is = samples[k] < n ? y.r[samples[k]] : y.v[samples[k] - n];
    CHECK(std::abs(is - exact[static_cast<Eigen::Index>(k)]) < 1e-2);
  }
}

TEST_CASE("a singular M: implicit from the start, and for good") {
  Eigen::Vector3d y = Robertson::start(), exact = Robertson::exact();
  const auto algebraic = [](const Eigen::Vector3d& x) -> Eigen::Vector3d {
    const Eigen::Vector3d rate = Robertson{}(x);
    return {rate[0], rate[1], x.sum() - 1};
  };
  const auto report =
      integrate(y, algebraic, capacity(Eigen::Vector3d(1, 1, 0)), {0.0, 40.0}, tolerance{.rtol = 1e-6, .atol = 1e-12});
  REQUIRE(report);
  CHECK((y - exact).cwiseQuotient(exact).cwiseAbs().maxCoeff() < 1e-5);
  REQUIRE(report.schemes.count() == 1);
  CHECK(report.schemes.list()[0].cause == SchemeCause::algebraic);
}

TEST_CASE("backward, a view of the caller's numbers, a second run, no run at all") {
  double numbers[2] = {std::exp(-1.0), std::exp(-2.0)};
  Eigen::Map<Vec> view(numbers);
  REQUIRE(integrate(view, slow, {1.0, 0.0}, {.rtol = 1e-8}));
  CHECK(numbers[0] == Approx(1).epsilon(1e-7));
  CHECK(numbers[1] == Approx(1).epsilon(1e-7));
}

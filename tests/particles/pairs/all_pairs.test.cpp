#include <phistep/particles/bodies/particles.hpp>
#include <phistep/particles/pairs/all_pairs.hpp>
#include <phistep/phistep.hpp>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <functional>
#include <limits>
#include <random>
#include <stdexcept>

#include "support/catch.hpp"

#ifdef _OPENMP
#include <omp.h>
#endif

using namespace phistep;

namespace all_pairs_cases {

template <class Scalar, int dim>
Particles<Scalar, dim> cloud(Index n, unsigned seed = 5) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<Scalar> u(-1, 1);
  Particles<Scalar, dim> y{Eigen::Matrix<Scalar, dim, Eigen::Dynamic>::NullaryExpr(dim, n, [&] { return u(random); })};
  y.set_mass(Eigen::VectorXd::NullaryExpr(n, [&] { return 1.5 + static_cast<double>(u(random)); }));
  y.set_charge(Eigen::VectorXd::NullaryExpr(n, [&] { return static_cast<double>(u(random)); }));
  return y;
}
template <class S, class F>
auto force_on(F& force, const S& y) {
  auto out = make_rate<S>(y);
  const auto masses = S::masses(y);
  add_force(force, ScalarOf<S>{0}, Blocks<S>::view(y, masses), NoMemory{}, out);
  return out.force;
}
template <class S, class F>
auto energy_of(F& force, const S& y) {
  const auto masses = S::masses(y);
  return force.energy(0, Blocks<S>::view(y, masses));
}
using Law = std::function<long double(long double)>;

/// Σ_j w_i w_j f(r²) d in long double, and the sum of the terms' sizes, of which rounding is a part.
template <class S>
void check_against_sum(const S& y, const auto& force, const Law& law, const Eigen::VectorXd& w, double terms = 40) {
  using Scalar = ScalarOf<S>;
  constexpr int dim = S::dimensions;
  double worst = 0;
  for (Index i = 0; i < y.size(); ++i) {
    if (y.body().is_still(i)) continue;
    Eigen::Matrix<long double, dim, 1> sum = Eigen::Matrix<long double, dim, 1>::Zero();
    long double size = 0;
    for (Index j = 0; j < y.size(); ++j) {
      if (j == i) continue;
      const Eigen::Matrix<long double, dim, 1> d =
          y.r.col(i).template cast<long double>() - y.r.col(j).template cast<long double>();
      const Eigen::Matrix<long double, dim, 1> f = static_cast<long double>(w[i]) * w[j] * law(d.squaredNorm()) * d;
      sum += f;
      size += f.norm();
    }
    const auto off = (force.col(i).template cast<long double>() - sum).norm();
    worst = std::max(worst, static_cast<double>(off / (size * std::numeric_limits<Scalar>::epsilon())));
  }
  CHECK(worst <= terms);
}
template <class Matrix>
bool same_bits(const Matrix& a, const Matrix& b) {
  return std::memcmp(a.data(), b.data(), sizeof(typename Matrix::Scalar) * static_cast<std::size_t>(a.size())) == 0;
}

inline const auto gravity_law = [](long double r2) { return -2.0L / ((r2 + 0.01L) * std::sqrt(r2 + 0.01L)); };

// Each term is off by some eps (differences ½, square 2, law 4, products 2), and so is the sum of them by sizes; sums of n
// terms in long lanes add n/(4 · lanes) more at worst, and some √n in fact.
template <class S>
void check_sums() {
  using Scalar = ScalarOf<S>;
  // Around lanes, groups of four and teams of 256, whose number is odd and even; the pairwise loop of few.
  for (const Index n : {1, 2, 6, 7, 8, 9, 11, 16, 17, 33, 100, 256, 257, 520, 1025}) {
    CAPTURE(n);
    const auto y = cloud<Scalar, S::dimensions>(n);
    AllPairs gravity{SoftenedGravity{2.0, 0.1}};
    const auto f = force_on(gravity, y);
    check_against_sum(y, f, gravity_law, y.mass().template cast<double>());
    // Newton's third law to rounding: of the sum of all sizes.
    CHECK(f.rowwise().sum().norm() <= 20 * std::numeric_limits<Scalar>::epsilon() * f.norm() * static_cast<Scalar>(n));
  }
}

}  // namespace all_pairs_cases

using namespace all_pairs_cases;

#if PHISTEP_QUICK

TEMPLATE_TEST_CASE("the force is the sum over all pairs", "", (Particles<double, 3>), (Particles<float, 3>)) {
  check_sums<TestType>();
}

TEST_CASE("Coulomb, user laws and their weights") {
  const auto y = cloud<double, 3>(70);
  AllPairs coulomb{Coulomb{3.0}};
  check_against_sum(
      y, force_on(coulomb, y), [](long double r2) { return 3 / (r2 * std::sqrt(r2)); }, y.charge());
}

TEST_CASE("it adds; particles held still act but get no force, and cost no pairs among themselves") {
  auto y = cloud<double, 3>(40);
  AllPairs gravity{SoftenedGravity{2.0, 0.1}};
  const Eigen::Matrix3Xd free = force_on(gravity, y);
  std::vector<std::uint8_t> still(40, 0);
  for (const std::size_t i : {0u, 3u, 4u, 17u, 39u}) still[i] = 1;
  y.set_still(still);
  auto out = make_rate<Particles<double, 3>>(y);
  out.force.setConstant(100);
  const auto masses = Particles<double, 3>::masses(y);
  add_force(gravity, 0.0, Blocks<Particles<double, 3>>::view(y, masses), NoMemory{}, out);
  for (Index i = 0; i < 40; ++i)
    CHECK((out.force.col(i).array() - 100 - (y.body().is_still(i) ? 0 : 1) * free.col(i).array()).abs().maxCoeff() <=
          1e-11);
  // Only pairs with somebody that moves have an energy here; as Σ over all pairs minus Σ over still ones.
  double sum = 0;
  for (Index i = 0; i < 40; ++i)
    for (Index j = 0; j < i; ++j)
      if (!y.body().is_still(i) || !y.body().is_still(j))
        sum -= 2 * y.mass()[i] * y.mass()[j] / std::sqrt((y.r.col(i) - y.r.col(j)).squaredNorm() + 0.01);
  CHECK(energy_of(gravity, y) == Approx(sum).epsilon(1e-13));
  y.set_still(std::vector<std::uint8_t>(40, 1));
  CHECK((force_on(gravity, y).norm() == 0 && energy_of(gravity, y) == 0));
  CHECK(check_jacobian(gravity, cloud<double, 3>(7).set_still({0, 1, 0, 0, 0, 0, 1})));
}

TEST_CASE("tangents: by differentiation of the law, like differences") {
  CHECK(check_jacobian(AllPairs{SoftenedGravity{2.0, 0.3}}, cloud<double, 3>(9)));
}

TEST_CASE("the force is minus the energy's gradient") {
  for (const Index n : {3, 30}) {
    const auto y = cloud<double, 3>(n);
    const auto check = [&](auto force) {
      const Eigen::Matrix3Xd f = force_on(force, y);
      for (Index k = 0; k < 9; ++k) {
        auto up = y, down = y;
        up.r.data()[k] += 1e-5, down.r.data()[k] -= 1e-5;
        // Central differences: h² V'''/6 with V''' ≲ 1e4 w²/ε⁴ …, rounding 1e-16 |V|/h ≈ 1e-8.
        CHECK(f.data()[k] ==
              Approx(-(energy_of(force, up) - energy_of(force, down)) / 2e-5).epsilon(1e-5).margin(1e-5));
      }
    };
    check(AllPairs{SoftenedGravity{2.0, 0.2}});
    check(AllPairs{Coulomb{3.0, 0.2}});
  }
}

TEST_CASE("scaling length and mass by powers of two changes no bit") {
  const auto y = cloud<double, 3>(300);
  AllPairs gravity{SoftenedGravity{1.0, 0.125}};
  const Eigen::Matrix3Xd f = force_on(gravity, y);
  const double V = energy_of(gravity, y);
  for (const int k : {-60, 7, 40}) {
    const double length = std::ldexp(1.0, k), mass = std::ldexp(1.0, 2 - k);
    auto z = y;
    z.r *= length;
    z.set_mass((mass * y.mass()).eval());
    AllPairs scaled{SoftenedGravity{1.0, 0.125 * length}};
    CHECK(same_bits((force_on(scaled, z) / (mass * mass) * length * length).eval(), f));
    CHECK(energy_of(scaled, z) / (mass * mass) * length == V);
  }
}

TEST_CASE("a second call, a copy and any number of threads give the same bits") {
  const auto y = cloud<double, 3>(1500);
  AllPairs gravity{SoftenedGravity{2.0, 0.1}};
  const Eigen::Matrix3Xd f = force_on(gravity, y);
  auto copy = gravity;
  CHECK((same_bits(force_on(gravity, y), f) && same_bits(force_on(copy, y), f)));
#ifdef _OPENMP
  const double V = energy_of(gravity, y);
  for (const int threads : {1, 2, 3}) {
    omp_set_num_threads(threads);
    CHECK((same_bits(force_on(gravity, y), f) && energy_of(gravity, y) == V));
  }
#endif
}

TEST_CASE("two at one place: named where the law has no limit, no force where it has") {
  for (const Index n : {4, 50}) {
    auto y = cloud<double, 3>(n);
    y.r.col(3) = y.r.col(1);
    AllPairs softened{SoftenedGravity{1, 0.1}}, points{SoftenedGravity{1, 0}};
    CHECK(force_on(softened, y).allFinite());
    const Eigen::Matrix3Xd f = force_on(points, y);
    for (Index i = 0; i < n; ++i) CHECK(f.col(i).allFinite() == (i != 1 && i != 3));
    PhiStepper stepper{y, points, velocity_verlet};
    const auto report = stepper.step(y, 0, 0.1);
    CHECK(!report);
    CHECK_THAT(report.message(), contains("1"));
  }
}

TEST_CASE("a particle at no finite place is named, whoever else there is") {
  AllPairs points{SoftenedGravity{1, 0}};
  for (const Index n : {4, 50})
    for (const double nowhere : {std::nan(""), HUGE_VAL})
      for (const Index first_or_later : {0, 2}) {
        auto y = cloud<double, 3>(n);
        y.r(1, first_or_later) = nowhere;
        const Eigen::Matrix3Xd f = force_on(points, y);
        for (Index i = 0; i < n; ++i) CHECK(f.col(i).allFinite() == (i != first_or_later));
        CHECK(std::isnan(energy_of(points, y)));
      }
}

TEST_CASE("what can't be summed is refused") {
  auto y = cloud<double, 3>(10);
  AllPairs gravity{SoftenedGravity{1, 0.1}};
  AllPairs charges{Coulomb{1}};
  y.set_charge(Eigen::VectorXd(0));
  CHECK_THROWS_AS(force_on(charges, y), std::invalid_argument);
  y.set_box(Box<double, 3>::periodic(-Eigen::Vector3d::Ones(), Eigen::Vector3d::Ones()));
  CHECK_THROWS_AS(force_on(gravity, y), std::invalid_argument);
  CHECK_THROWS_AS((AllPairs{SoftenedGravity{1, -0.1}}), std::invalid_argument);
  CHECK_THROWS_AS((AllPairs{SoftenedGravity{std::nan(""), 0.1}}), std::invalid_argument);
  CHECK_THROWS_AS((AllPairs{Coulomb{HUGE_VAL}}), std::invalid_argument);
  const Particles<double, 3> nobody;
  CHECK(force_on(gravity, nobody).size() == 0);
  CHECK(energy_of(gravity, nobody) == 0);
}

TEST_CASE("two bodies on a circle: back after a period") {
  // m = 1 and 3 at distance 2, G = 5: ω² = G (m₁ + m₂)/d³.
  Eigen::Matrix3Xd r = Eigen::Matrix3Xd::Zero(3, 2), v = r;
  const double omega = std::sqrt(5 * 4.0 / 8);
  r.row(0) << -1.5, 0.5;
  v.row(1) << -1.5 * omega, 0.5 * omega;
  Particles<double, 3> y{r, v};
  y.set_mass(Eigen::Vector2d(1, 3));
  PhiStepper stepper{y, AllPairs{SoftenedGravity{5, 0}}, velocity_verlet};
  const int n = 2000;
  const double dt = 2 * std::acos(-1.0) / omega / n;
  for (int k = 0; k < n; ++k) REQUIRE(stepper.step(y, k * dt, dt));
  // Verlet's circle of this radius turns by θ a step, 2 − 2 cos θ = (ωΔt)², and has the speed ωr (1 − θ²/8): ours starts too
  // fast, on an ellipse of a period longer by 3/8 θ², less the θ²/24 by which Verlet's angles run ahead. Lag: 2π θ²/3.
  const double theta = omega * dt;
  CHECK((y.r - r).norm() == Approx(r.norm() * 2 * std::acos(-1.0) * theta * theta / 3).epsilon(0.01));
}

#elif PHISTEP_FULL

TEMPLATE_TEST_CASE("the force is the sum over all pairs", "", (Particles<double, 3>), (Particles<float, 3>),
                   (Particles<double, 2>)) {
  check_sums<TestType>();
}

TEST_CASE("Coulomb, user laws and their weights") {
  const auto y = cloud<double, 3>(70);
  const auto law = [](auto r2) { return exp(-r2) - 0.5 * rsqrt(r2); };
  const auto exact = [](long double r2) { return std::exp(-r2) - 0.5L / std::sqrt(r2); };
  AllPairs unweighted{law};
  auto by_mass = all_pairs<PairWeight::mass>(law);
  check_against_sum(y, force_on(unweighted, y), exact, Eigen::VectorXd::Ones(70).eval(), 80);
  check_against_sum(y, force_on(by_mass, y), exact, y.mass(), 80);
  const auto few = cloud<double, 3>(5);
  check_against_sum(few, force_on(by_mass, few), exact, few.mass(), 80);
}

TEST_CASE("motions: masses a component, one for all, or none") {
  const auto y = cloud<double, 3>(20);
  const Motion<Eigen::Matrix3Xd> motion{y.r, y.v};
  AllPairs gravity{SoftenedGravity{2.0, 0.1}};
  const auto with = [&](const auto& mass) {
    auto out = make_rate<Motion<Eigen::Matrix3Xd>>(motion);
    add_force(gravity, 0.0, Blocks<Motion<Eigen::Matrix3Xd>>::view(motion, std::tuple{mass}), NoMemory{}, out);
    return out.force;
  };
  CHECK(same_bits(with(DiagonalMass<double>{y.mass()}.bind<double>(y.r)), force_on(gravity, y)));
  const Eigen::Matrix3Xd unit = with(UnitMass{});
  CHECK((with(ScalarMass<double>{3.0}) - 9 * unit).norm() <= 1e-13 * unit.norm());
}

TEST_CASE("tangents: by differentiation of the law, like differences") {
  CHECK(check_jacobian(AllPairs{[](auto r2) { return exp(-r2) + pow<-2>(r2 + 0.5); }}, cloud<double, 2>(9)));
}

#endif

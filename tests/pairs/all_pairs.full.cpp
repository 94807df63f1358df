// all_pairs: the full product and what is dear to compile. The quick half is all_pairs.test.cpp.
#include "pairs/all_pairs_cases.hpp"

using namespace all_pairs_cases;

// Each term is off by some eps (differences ½, square 2, law 4, products 2), and so is the sum of them by sizes; sums of n
// terms in long lanes add n/(4 · lanes) more at worst, and some √n in fact.
TEMPLATE_TEST_CASE("the force is the sum over all pairs", "", (Particles<double, 3>), (Particles<float, 3>),
                   (Particles<double, 2>)) {
  using Scalar = ScalarOf<TestType>;
  // Around lanes, groups of four and teams of 256, whose number is odd and even; the pairwise loop of few.
  for (const Index n : {1, 2, 6, 7, 8, 9, 11, 16, 17, 33, 100, 256, 257, 520, 1025}) {
    CAPTURE(n);
    const auto y = cloud<Scalar, TestType::dimensions>(n);
    AllPairs gravity{SoftenedGravity{2.0, 0.1}};
    const auto f = force_on(gravity, y);
    check_against_sum(y, f, gravity_law, y.mass().template cast<double>());
    // Newton's third law to rounding: of the sum of all sizes.
    CHECK(f.rowwise().sum().norm() <= 20 * std::numeric_limits<Scalar>::epsilon() * f.norm() * static_cast<Scalar>(n));
  }
}

TEST_CASE("Coulomb, user laws and their weights") {
  const auto y = cloud<double, 3>(70);
  AllPairs coulomb{Coulomb{3.0}};
  check_against_sum(
      y, force_on(coulomb, y), [](long double r2) { return 3 / (r2 * std::sqrt(r2)); }, y.charge());
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
  CHECK(check_jacobian(AllPairs{SoftenedGravity{2.0, 0.3}}, cloud<double, 3>(9)));
  CHECK(check_jacobian(AllPairs{[](auto r2) { return exp(-r2) + pow<-2>(r2 + 0.5); }}, cloud<double, 2>(9)));
}

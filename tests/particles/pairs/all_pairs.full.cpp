// all_pairs: the full product and what is dear to compile. The quick half is all_pairs.test.cpp.
#include "particles/pairs/all_pairs_cases.hpp"

using namespace all_pairs_cases;

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

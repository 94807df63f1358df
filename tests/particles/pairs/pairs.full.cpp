// pairs: the full product and what is dear to compile. The quick half is pairs.test.cpp.
#include "particles/pairs/pairs_cases.hpp"

using namespace pairs_cases;

TEST_CASE("pair forces are those of a sum over all pairs") {
  const LennardJones law{0.7, 1.1};
  for (const auto& periodic :
       {std::array{false, false, false}, std::array{true, true, true}, std::array{true, false, true}}) {
    check_forces(shaken<double, 3>(7, 1.25, 1, periodic), law, 2.5);
    check_forces(shaken<double, 2>(13, 1.25, 2, periodic), law, 2.5);
    check_forces(shaken<float, 3>(7, 1.25, 3, periodic), law, 2.5);
    check_forces(shaken<float, 2>(13, 1.25, 4, periodic), law, 2.5);
  }
}

TEST_CASE("a law of the user's own is as good") {
  const auto own = [](auto r2) {
    const auto y = reciprocal(r2), y3 = y * y * y;
    return y * y3 * (12 * 4.0 * y3 - 6 * 4.0);
  };
  check_own(own);
  const auto y = shaken<double, 3>(6, 1.2, 5, {true, true, true});
  check_forces(
      y, [](auto r2) { return 1 / (r2 * r2); }, 2.0);
  check_forces(
      y, [](auto) { return 2.0; }, 2.0);  // springs of length 0
}

TEST_CASE("forces are minus the slope of the energy, tangents that of the forces") {
  check_slopes(LennardJones{0.5, 0.9}, 2.1);
  check_slopes(LennardJones{0.5, 0.9}.shifted(2.1), 2.1);
  check_slopes(Yukawa{2.0, 0.8}, 2.1);
  check_slopes(ScreenedCharges{2.0, 0.8}, 2.1);
  check_slopes(NearField{1.0, 2.0, 0.5, 4.0}, 2.1);
  check_slopes(NearField{1.0, 1.0, 0.5, 3.5}, 2.1);
  check_slopes(SoftSphere{3.0, 2.1}, 2.1);
  check_slopes(lorentz_berthelot({{1.0, 0.8}, {0.3, 1.0}}), 2.1);
}

TEST_CASE("velocity Verlet asks once a step, and allocates nothing between lists") { check_quiet(referred_to); }

TEST_CASE("an unchecked list misses pairs, and they can be counted") {
  CHECK(missed({}, referred_to) == 0);
  CHECK(missed(ListPolicy::unchecked_every(20), referred_to) > 0);
}

TEST_CASE("who asks for an energy elsewhere does not change the run") {
  CHECK(end(false, referred_to) == end(true, referred_to));
}

TEST_CASE("implicit steps see the list as their sparsity") {
  auto y = hot(3);
  y.v *= 0.1;
  Pairs force{SoftSphere{50.0, 1.6}, 1.6};
  PhiStepper stepper{y, std::ref(force), trapezoidal};
  const auto view = [&] { return view_of(y); };
  const Pairs measure{SoftSphere{50.0, 1.6}, 1.6};
  const double before = 0.5 * y.v.squaredNorm() + measure.energy(0.0, view());
  for (int n = 0; n < 20; ++n) {
    const auto report = stepper.step(y, 0.005 * n, 0.005);
    CAPTURE(report.message());
    REQUIRE(report);
  }
  const double after = 0.5 * y.v.squaredNorm() + measure.energy(0.0, view());
  CHECK(after == Approx(before).epsilon(1e-3));  // (ωΔt)²/12, ω² ≈ 1500: 0.3 % of what is exchanged
  CHECK(stepper.statistics().analyses <= 1 + static_cast<std::int64_t>(force.rebuilds()));
}

TEST_CASE("positions in one flat vector") {
  const auto y = shaken<double, 3>(4, 1.2, 11, {});
  Motion<Eigen::VectorXd> flat{Eigen::Map<const Eigen::VectorXd>(y.r.data(), y.r.size()),
                               Eigen::VectorXd::Zero(y.r.size())};
  Particles<double, 3> z = y;
  PhiStepper a{flat, pairs<3>(LennardJones{}, 2.5), velocity_verlet};
  PhiStepper b{z, Pairs{LennardJones{}, 2.5}, velocity_verlet};
  for (int n = 0; n < 10; ++n) {
    REQUIRE(a.step(flat, 0.001 * n, 0.001));
    REQUIRE(b.step(z, 0.001 * n, 0.001));
  }
  CHECK(flat.r == Eigen::Map<const Eigen::VectorXd>(z.r.data(), z.r.size()));
}

TEST_CASE("a law that throws in a thread of many: the exception passes, the atoms stay, the next step goes on") {
  check_throws(Pairs{throwing, 1.8});
  check_throws(AllPairs{throwing});
}

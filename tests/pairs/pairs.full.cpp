// pairs: the full product and what is dear to compile. The quick half is pairs.test.cpp.
#include "pairs/pairs_cases.hpp"

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
  const auto y = shaken<double, 3>(6, 1.2, 5, {true, true, true});
  Out<double, 3> a{Eigen::Matrix3Xd::Zero(3, y.size())}, b = a;
  NeighborMemory memory;
  Pairs{own, 2.0}.add(0.0, view_of(y), memory, a);
  Pairs{LennardJones{}, 2.0}.add(0.0, view_of(y), NeighborMemory{}, b);
  CHECK(a.force == b.force);
  check_forces(
      y, [](auto r2) { return 1 / (r2 * r2); }, 2.0);
  check_forces(
      y, [](auto) { return 2.0; }, 2.0);  // springs of length 0
}

TEST_CASE("forces are minus the slope of the energy, tangents that of the forces") {
  const auto check = [](const auto& law, double cutoff) {
    auto y = shaken<double, 3>(4, 1.15, 7, {true, true, false});
    y.set_charge(Eigen::VectorXd(Eigen::VectorXd::LinSpaced(y.size(), -1, 1)));
    Eigen::VectorXi type(y.size());
    for (Index i = 0; i < y.size(); ++i) type[i] = static_cast<int>(i % 2);
    y.set_type(type);
    // Nobody crosses the cutoff, where laws jump, by h = 1e-5: the test's own condition.
    const Pairs force{law, cutoff};
    const auto psi = [&] {
      Out<double, 3> out{Eigen::Matrix3Xd::Zero(3, y.size())};
      force.add(0.0, view_of(y), NeighborMemory{}, out);
      return out.force;
    };
    Dense dense{Eigen::MatrixXd::Zero(y.r.size(), y.r.size())};
    force.add_jacobian(0.0, view_of(y), NeighborMemory{}, dense);
    const Eigen::Matrix3Xd at = psi();
    const double size = at.cwiseAbs().maxCoeff(), stiffness = dense.K.cwiseAbs().maxCoeff();
    CHECK(dense.K.isApprox(dense.K.transpose(), 1e-12));
    constexpr double h = 1e-5;
    for (const Index k : {0, 7, 50, 100}) {
      const double x = y.r.data()[k];
      y.r.data()[k] = x + h;
      const double up = force.energy(0.0, view_of(y));
      const Eigen::Matrix3Xd above = psi();
      y.r.data()[k] = x - h;
      const double down = force.energy(0.0, view_of(y));
      const Eigen::Matrix3Xd below = psi();
      y.r.data()[k] = x;
      // Central differences: h² F''/6 with F'' ≈ 200 F/r² for r^−13, r ≥ 0.7: 1e-8; rounding ε V/h with V ≈ 100 F: 2e-9.
      CHECK(std::abs((down - up) / (2 * h) - at.data()[k]) < 3e-8 * (size + stiffness));
      const Eigen::Matrix3Xd slope = (above - below) / (2 * h);
      const Eigen::Map<const Eigen::VectorXd> column(slope.data(), slope.size());
      CHECK((column - dense.K.col(k)).cwiseAbs().maxCoeff() < 3e-7 * stiffness);
    }
  };
  check(LennardJones{0.5, 0.9}, 2.1);
  check(LennardJones{0.5, 0.9}.shifted(2.1), 2.1);
  check(Yukawa{2.0, 0.8}, 2.1);
  check(ScreenedCharges{2.0, 0.8}, 2.1);
  check(NearField{1.0, 2.0, 0.5, 4.0}, 2.1);
  check(NearField{1.0, 1.0, 0.5, 3.5}, 2.1);
  check(SoftSphere{3.0, 2.1}, 2.1);
  check(lorentz_berthelot({{1.0, 0.8}, {0.3, 1.0}}), 2.1);
}

TEST_CASE("velocity Verlet asks once a step, and allocates nothing between lists") {
  auto y = hot(1);
  Pairs force{LennardJones{}, 2.5, {.skin = 0.3}};
  PhiStepper stepper{y, std::ref(force), velocity_verlet};
  REQUIRE(stepper.step(y, 0, 0.004));
  std::int64_t quiet = 0;
  for (int n = 1; n < 200; ++n) {
    const std::uint64_t before = force.rebuilds();
    heap::count = 0;
    heap::counting = true;
    const bool good = static_cast<bool>(stepper.step(y, 0.004 * n, 0.004));
    heap::counting = false;
    REQUIRE(good);
    if (force.rebuilds() != before) continue;
    ++quiet;
    CHECK(heap::count == 0);
  }
  CHECK(stepper.statistics().force_calls == 201);
  CHECK(quiet > 150);
  CHECK(force.rebuilds() == 200u - static_cast<std::uint64_t>(quiet));
}

TEST_CASE("an unchecked list misses pairs, and they can be counted") {
  const auto missed = [](ListPolicy policy) {
    auto y = hot(8);
    Pairs force{LennardJones{}, 2.5, {.skin = 0.1, .policy = policy}};
    const Pairs all{LennardJones{}, 2.5};
    PhiStepper stepper{y, std::ref(force), velocity_verlet};
    std::uint64_t sum = 0;
    for (int n = 0; n < 40; ++n) {
      REQUIRE(stepper.step(y, 0.004 * n, 0.004));
      sum += all.pairs_inside(view_of(y)) - force.pairs_inside(view_of(y), stepper.memory());
    }
    return sum;
  };
  CHECK(missed({}) == 0);
  CHECK(missed(ListPolicy::unchecked_every(20)) > 0);
}

TEST_CASE("who asks for an energy elsewhere does not change the run") {
  const auto run = [](bool asks) {
    auto y = hot(9);
    Pairs force{LennardJones{}, 2.5};
    PhiStepper stepper{y, std::ref(force), velocity_verlet};
    for (int n = 0; n < 40; ++n) {
      REQUIRE(stepper.step(y, 0.004 * n, 0.004));
      auto elsewhere = y;
      elsewhere.r.col(n).array() += 3;
      if (asks) CHECK(std::isfinite(force.energy(0.0, view_of(elsewhere), stepper.memory())));
    }
    return y.r;
  };
  CHECK(run(false) == run(true));
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
  Eigen::Matrix3Xd r(3, 4096);
  for (Eigen::Index k = 0; k < r.cols(); ++k)
    r.col(k) << 1.1 * static_cast<double>(k % 16), 1.1 * static_cast<double>(k / 16 % 16),
        1.1 * static_cast<double>(k / 256);
  static std::atomic<long> calls{0};
  constexpr long fatal = 2000;
  const auto law = [](auto r2) {
    if (++calls == fatal) throw std::runtime_error("no such distance");
    return decltype(r2){1} / (r2 * r2);
  };
  const auto check = [&](auto force) {
    Particles<double, 3> atoms{r}, twin{r};
    PhiStepper stepper{atoms, force, velocity_verlet}, other{twin, force, velocity_verlet};
    calls = 0;
    CHECK_THROWS_WITH(stepper.step(atoms, 0, 1e-3), "no such distance");
    CHECK((atoms.r == r && atoms.v.isZero(0)));
    REQUIRE(stepper.step(atoms, 0, 1e-3));
    REQUIRE(other.step(twin, 0, 1e-3));
    CHECK((atoms.r == twin.r && atoms.v == twin.v));
  };
  check(Pairs{law, 1.8});
  check(AllPairs{law});
}

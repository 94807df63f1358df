// One thread or two: the same bits, through neighbour lists made anew. Implicit, and over long runs: threads.full.cpp.
#include "acceptance/threads_cases.hpp"

TEST_CASE("Lennard-Jones by velocity Verlet, 300 steps") {
  // 1331 rows are three chunks: two threads share them.
  check(fluid(11), 300, 0.004, by([](const Atoms& y) {
          return PhiStepper{y, Pairs{LennardJones{}, 2.2, {.skin = 0.4}}, velocity_verlet};
        }));
}

TEST_CASE("gravity among all") {
  Atoms stars = fluid(9);
  stars.set_box(Box<double, 3>::open()).set_mass(1e-3);
  check(stars, 40, 0.01, by([](const Atoms& y) {
          return PhiStepper{y, AllPairs{SoftenedGravity{1.0, 0.1}}, velocity_verlet};
        }));
}

TEST_CASE("the energy of all pairs has the same bits with one thread, two and three") {
  Atoms stars = fluid(11);  // several teams of 256
  stars.set_box(Box<double, 3>::open()).set_mass(1e-3);
  const auto energy = [&stars](int threads) {
    omp_set_num_threads(threads);
    const AllPairs gravity{SoftenedGravity{1.0, 0.1}};
    const auto masses = Atoms::masses(stars);
    return gravity.energy(0, Blocks<Atoms>::view(stars, masses));
  };
  const double one = energy(1);
  CHECK(one < 0);
  CHECK(energy(2) == one);
  CHECK(energy(3) == one);
}

TEST_CASE("grains on a floor: contacts, friction and walls of enough of them that threads share each pass") {
  using Grains = Particles<double, 3, Spin>;
  constexpr int side = 17;  // 4913 grains
  Eigen::Matrix3Xd r(3, side * side * side), v(3, r.cols());
  for (Eigen::Index k = 0; k < r.cols(); ++k) {
    const auto at = [k](double x) { return 0.04 * std::sin(x * static_cast<double>(k)); };
    r.col(k) << 0.5 + static_cast<double>(k % side) + at(1), 0.5 + static_cast<double>(k / side % side) + at(2),
        0.48 + 0.98 * static_cast<double>(k / side / side) + at(3);
    v.col(k) << 20 * at(4), 20 * at(5), 20 * at(6);
  }
  const GranHooke law{
      .stiffness = 1e4, .tangential_stiffness = 3e3, .damping = 10, .tangential_damping = 5, .friction = 0.5};
  const auto end = [&](int threads) {
    omp_set_num_threads(threads);
    Grains grains{r, v};
    grains.set_radius(0.5).set_mass(1.0);
    Contact contact{law, 0.02};
    Walls floor{law, Plane<3>{.point = {0, 0, 0}, .normal = {0, 0, 1}}};
    PhiStepper stepper{grains, Gravity{Eigen::Vector3d{0.2, 0, -1}} + term(std::ref(contact)) + term(std::ref(floor)),
                       symplectic_euler};
    for (int n = 0; n < 40; ++n) REQUIRE(stepper.step(grains, 5e-4 * n, 5e-4));
    CHECK(contact.statistics().touching > 2000);
    CHECK(contact.statistics().rebuilds > 1);
    CHECK(floor.touching() > 100);
    return grains;
  };
  const Grains one = end(1);
  for (const int threads : {2, 3, 7}) {
    const Grains more = end(threads);
    CAPTURE(threads);
    CHECK(more.r == one.r);
    CHECK(more.v == one.v);
    CHECK(more.omega == one.omega);
  }
}

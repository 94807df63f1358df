// Contacts: what a collision, a throw, a slope and a roll must come to.
#include "particles/contacts/contact_cases.hpp"
#if PHISTEP_QUICK
#include <phistep/particles/bodies/particle_sums.hpp>
#include <phistep/preflight.hpp>
#endif

using namespace contact_cases;

#if PHISTEP_QUICK

TEST_CASE("damping ratios invert their formulas") {
  for (const double e : {1e-3, 0.05, 0.135, std::exp(-2.0), 0.2, 0.5, 0.9, 0.999, 1.0}) {
    CAPTURE(e);
    const double pulls = damping_ratio(e, true), beta = damping_ratio(e, false);
    CHECK(std::exp(-M_PI * pulls / std::sqrt(1 - pulls * pulls)) == Approx(e).epsilon(1e-12));
    const double root = std::sqrt(std::abs(1 - beta * beta));
    // At β = 1 the formula is 0/0; 2 + O(root²) stands for it within 1e-4 of there.
    const double loss = beta < 1   ? beta * std::atan2(2 * beta * root, 2 * beta * beta - 1) / root
                        : beta > 1 ? 2 * beta * std::log(beta + root) / root
                                   : 2;
    CHECK(std::exp(-loss) == Approx(e).epsilon(1e-7));
  }
}

TEST_CASE("elastic spheres return as much of their speed as was asked for") {
  // Two of mass 1 and radius ½: ẍ = (1/m*) F(overlap, parting) with 1/m* = 2, 1/R* = 4, by Verlet with the last velocity;
  // the dashpot begins with t^(1/4), so that 1e5 steps a contact leave (1e-5)^(5/4).
  for (const double e : {0.3, 0.9}) {
    const Hertz law{.modulus = 1e7, .restitution = e, .attracts = true};
    const auto numbers = law.numbers();
    const double dt = 3.2 * std::pow(0.25 / 0.25e14, 0.2) / 1e5;
    double overlap = 0, parting = -1;
    while (overlap >= 0) {
      parting += dt * 2 * Hertz::response(numbers, overlap, parting, 2.0, 4.0).normal;
      overlap -= dt * parting;
    }
    CAPTURE(e);
    CHECK(parting == Approx(e).epsilon(1e-3));
  }
}

TEST_CASE("contacts keep momentum and angular momentum") {
  check_momentum(rough);
  check_momentum(Hooke{.stiffness = 1e3, .restitution = 0.7, .friction = 0.4, .rolling_friction = 0.1});
}

TEST_CASE("undamped contacts that stick give back their energy") {
  // Two spheres meet off-centre; the tangential spring takes and gives back. Before and after there are no forces, and
  // symplectic Euler is leapfrog with its first velocity half a step off. What the tangential spring holds when the two
  // part is lost: 2e-6 here, whatever Δt.
  const auto change = [](double dt) {
    Matrix r(3, 2);
    r << -0.501, 0.501, 0, 0.1, 0, 0;
    auto y = bodies(r);
    y.v.row(0) << 1, -1;
    PhiStepper stepper{y, Contact{Hooke{.stiffness = 1e4, .friction = 1e9, .tangential_damping = 0}}, symplectic_euler};
    const auto kinetic = [&] { return (y.v.squaredNorm() + 0.1 * y.omega.squaredNorm()) / 2; };
    const double before = kinetic();
    for (int n = 0; n * dt < 0.05; ++n) REQUIRE(stepper.step(y, n * dt, dt));
    CHECK(stepper.force().statistics().touching == 0);
    CHECK(y.omega.norm() > 0.1);
    return std::abs(kinetic() - before) / before;
  };
  CHECK(change(1e-4) < 1e-4);
  CHECK(change(1e-5) < 5e-6);
}

TEST_CASE("history survives that pairs are found anew") {
  // A skin that every step uses up, against one that never is.
  const auto run = [](double skin, std::int64_t& rebuilds) {
    Grains y = jumble(5, 12, 1.2);
    PhiStepper stepper{y, Contact{rough, skin}, symplectic_euler};
    for (int n = 0; n < 300; ++n) REQUIRE(stepper.step(y, n * 1e-3, 1e-3));
    rebuilds = stepper.force().statistics().rebuilds;
    return y;
  };
  std::int64_t many = 0, one = 0;
  const Grains a = run(1e-6, many), b = run(100, one);
  CHECK(one == 1);
  CHECK(many >= 290);
  // Each order of the bodies sums in an order of its own; the scene is chaotic, but not in 300 steps.
  CHECK((a.r - b.r).norm() < 1e-9);
  CHECK((a.omega - b.omega).norm() < 1e-8);
}

TEST_CASE("springs of rolling keep their sense where a pair's bodies change places") {
  // A grain lies on the flank of a held one, kept from rolling; both drift through a period, which changes their order.
  const double radius = 0.01, angle = 0.1, stiffness = 1e5;
  const double apart = 2 * radius - 0.01 * 9.81 * std::cos(angle) / stiffness;
  Grains y{Matrix{{0.05, 0.05 + apart * std::sin(angle)}, {0, 0}, {0.05, 0.05 + apart * std::cos(angle)}}};
  y.set_mass(0.01).set_radius(radius).set_still({1, 0});
  y.v.row(2).setConstant(1);
  Box<double, 3> box;
  box.is_periodic[2] = true, box.upper[2] = 0.1;
  y.set_box(box);
  const Hooke law{.stiffness = stiffness, .restitution = 0.3, .friction = 0.8, .rolling_friction = 0.22};
  PhiStepper stepper{y, Gravity{Eigen::Vector3d{0, 0, -9.81}} + Contact{law}, symplectic_euler};
  double fastest = 0;
  const auto look = [&](double t, const Grains& now) {
    if (t > 0.05) fastest = std::max(fastest, std::abs(now.omega(1, 1)));
  };
  REQUIRE(integrate(stepper, y, {0.0, 0.3}, fixed(1e-5), look));
  CHECK(fastest < 0.01);
  CHECK(std::atan2(y.r(0, 1) - y.r(0, 0), y.r(2, 1) - y.r(2, 0)) == Approx(angle).epsilon(0.01));
}

TEST_CASE("history survives that other bodies are taken away, or come") {
  // Two bodies pressed together slide; one that is far away goes, and another comes.
  const auto run = [](bool others) {
    Matrix r(3, 2);
    r << 0, 0.99, 0, 0.1, 0, 0;
    auto y = bodies(r);
    if (others) {
      Matrix far(3, 1);
      far << 9, 9, 9;
      Grains front = bodies(far);
      front.add(y);
      y = front;
    }
    const Index first = others ? 1 : 0;
    y.v(1, first) = 0.1;
    PhiStepper stepper{y, Contact{rough}, symplectic_euler};
    const auto steps = [&](int from, int to) {
      for (int n = from; n < to; ++n) REQUIRE(stepper.step(y, n * 1e-3, 1e-3));
    };
    steps(0, 8);
    if (others) y.erase(0);
    steps(8, 14);
    if (others) {
      Matrix far(3, 1);
      far << -9, 9, 9;
      y.add(bodies(far));
    }
    steps(14, 20);
    return std::pair{Matrix(y.r.leftCols(2)), Matrix(y.omega.leftCols(2))};
  };
  const auto a = run(false), b = run(true);
  CHECK(a.second.norm() > 1e-3);
  CHECK((a.first == b.first && a.second == b.second));
}

TEST_CASE("a checkpoint holds the history") {
  Grains y = jumble(7, 12, 1.1);
  const auto make = [](Grains& of) { return PhiStepper{of, Contact{rough, 0.02}, symplectic_euler}; };
  auto stepper = make(y);
  for (int n = 0; n < 60; ++n) REQUIRE(stepper.step(y, n * 1e-3, 1e-3));
  std::stringstream file;
  save_checkpoint(file, y, stepper);
  for (int n = 60; n < 150; ++n) REQUIRE(stepper.step(y, n * 1e-3, 1e-3));

  Grains z = jumble(7, 12, 1.1);
  auto again = make(z);
  load_checkpoint(file, z, again);
  for (int n = 60; n < 150; ++n) REQUIRE(again.step(z, n * 1e-3, 1e-3));
  CHECK((y.r == z.r && y.v == z.v && y.omega == z.omega));
}

TEST_CASE("steps that fail or are taken back leave no trace") {
  check_no_trace(Contact{rough, 0.02},
                 [](auto& stepper, Grains& y, double t) { REQUIRE_FALSE(stepper.step(y, t, HUGE_VAL)); });
}

TEST_CASE("one pass over the contacts a step where the scheme has one evaluation") {
  Grains y = jumble(9, 6, 0.8);
  PhiStepper stepper{y, Contact{rough}, symplectic_euler};
  for (int n = 0; n < 10; ++n) REQUIRE(stepper.step(y, n * 1e-3, 1e-3));
  CHECK(stepper.force().statistics().evaluations == 10);
}

TEST_CASE("contacts are counted exactly") {
  // A cubic lattice of n³ balls, each touching its neighbours along the axes; the next ones are beyond the skin.
  const int n = 5;
  Matrix r(3, n * n * n);
  for (int i = 0; i < n * n * n; ++i) r.col(i) << i % n, i / n % n, i / n / n;
  auto y = bodies(Matrix(0.99 * r));
  PhiStepper stepper{y, Contact{rough, 0.1}, symplectic_euler};
  REQUIRE(stepper.step(y, 0, 1e-6));
  CHECK(stepper.force().statistics().pairs == 3 * n * n * (n - 1));
  CHECK(stepper.force().statistics().touching == 3 * n * n * (n - 1));
  // Periodic, every ball has six; a pair of two that are held still is not computed.
  y.set_box(Box<double, 3>::periodic(Eigen::Vector3d::Zero(), Eigen::Vector3d::Constant(0.99 * n)));
  REQUIRE(stepper.step(y, 1e-6, 1e-6));
  CHECK(stepper.force().statistics().touching == 3 * n * n * n);
  const double energy = potential_energy(stepper, y), whole_pressure = pressure(stepper, y);
  std::vector<std::uint8_t> still(static_cast<std::size_t>(n * n * n), 0);
  for (int i = 0; i < n * n; ++i) still[static_cast<std::size_t>(i)] = 1;  // a layer: 2n² pairs in it
  y.set_still(still);
  REQUIRE(stepper.step(y, 2e-6, 1e-6));
  CHECK(stepper.force().statistics().touching == 3 * n * n * n - 2 * n * n);
  // Nor has it energy, or a part in the pressure.
  const double share = 1 - 2. / (3 * n);
  CHECK_THAT(potential_energy(stepper, y), Catch::Matchers::WithinRel(share * energy, 1e-6));
  CHECK_THAT(pressure(stepper, y), Catch::Matchers::WithinRel(share * whole_pressure, 1e-6));
}

TEST_CASE("units change no bit") {
  // Length by 4, mass by 2, time by 8.
  const auto run = [](double length, double mass, double time) {
    Grains y = jumble(13, 10, 1.2);
    const double stiffness = mass / (time * time);
    y.r *= length, y.v *= length / time, y.omega /= time;
    y.set_mass((mass * y.mass()).eval()).set_radius((length * y.radius()).eval());
    Hooke law{.stiffness = 1e3 * stiffness, .restitution = 0.7, .friction = 0.4, .rolling_friction = 0.1};
    PhiStepper stepper{y, Contact{law}, symplectic_euler};
    for (int n = 0; n < 100; ++n) REQUIRE(stepper.step(y, n * 1e-3 * time, 1e-3 * time));
    y.r /= length, y.v *= time / length, y.omega *= time;
    return y;
  };
  const Grains a = run(1, 1, 1), b = run(4, 2, 8);
  CHECK((a.r == b.r && a.v == b.v && a.omega == b.omega));
}

TEST_CASE("what can't work is said, with the body's number") {
  const Matrix r = three();
  Particles<double, 3> bare{r};
  for (const double bad : {0.0, -1.0, std::nan(""), HUGE_VAL}) {
    CHECK_THROWS_WITH(bare.set_radius(Eigen::Vector3d(1, bad, 1)), contains("particle 1"));
    CHECK_THROWS_WITH(bare.set_mass(Eigen::Vector3d(1, 1, bad)), contains("particle 2"));
    CHECK_THROWS_WITH(Contact{Hooke{.stiffness = bad}}, contains("stiffness"));
    CHECK_THROWS_WITH(Contact{Hertz{.modulus = bad}}, contains("modulus"));
  }
  for (const double bad : {0.0, -0.1, 1.0001, std::nan("")})
    CHECK_THROWS_WITH(Contact(Hooke{.stiffness = 1, .restitution = bad}), contains("restitution"));
  CHECK_THROWS_WITH(Contact(Hooke{.stiffness = 1, .friction = -1}), contains("friction"));
  CHECK_THROWS_WITH(Contact(rough, -1), contains("skin"));
  auto lost = bodies(r);
  lost.r(1, 2) = std::nan("");
  const StepReport report = one_step(lost, Contact{rough});
  CHECK_FALSE(report);
  Grains none{Matrix(3, 0)};
  none.set_radius(1.0);
  CHECK_NOTHROW(one_step(none, Contact{rough}));
}

TEST_CASE("the shortest impact is known to preflight") {
  Matrix r(3, 2);
  r << 0, 2, 0, 0, 0, 0;
  auto y = bodies<Smooth>(r);
  y.v.row(0) << 0.5, -0.5;
  const auto masses = Smooth::masses(y);
  // What preflight asks of a scene's force.
  const auto time = [&](const auto& force) {
    double shortest = 0;
    PreflightReport report;
    ask_of_impacts(force, Smooth::view(y, masses), shortest, report);
    return shortest;
  };
  CHECK(time(Contact{Hooke{.stiffness = 1e5}}) == Approx(M_PI * std::sqrt(0.5 / 1e5)));
  // 2.943 δ/v: 2.87 (m*²/(R* E*² v))^(1/5) [K. L. Johnson, Contact Mechanics, (11.24)], printed to three digits
  CHECK(time(Contact{Hertz{.modulus = 1e7}}) == Approx(2.87 * std::pow(0.25 / (0.25 * 1e14), 0.2)).epsilon(2e-3));
  // The stiffest of a sum's terms, whichever stands first; 0 where none knows its time.
  const Contact soft{Hooke{.stiffness = 1e3}}, hard{Hooke{.stiffness = 1e5}};
  const Gravity weight{Eigen::Vector3d(0, 0, -10)};
  CHECK(time(weight + soft + hard) == time(hard));
  CHECK(time(hard + weight + soft) == time(hard));
  CHECK(time(weight) == 0);
}

TEST_CASE("two grains in one place are told, as atoms are: there is no direction for their force") {
  const auto check = [](auto law, auto scheme, auto y) {
    y.r.col(2) = y.r.col(1);
    const auto before = y;
    PhiStepper stepper{y, Contact{law} + Gravity{Eigen::Vector3d{0, 0, -9.81}}, scheme};
    const StepReport report = stepper.step(y, 0, 1e-4);
    CHECK(report.outcome() == Outcome::non_finite_force);
    CHECK_THAT(report.message(), contains("particle 1") && contains("term 0"));
    CHECK(y.r == before.r);
    CHECK(y.v == before.v);
  };
  const Matrix r = (Matrix(3, 3) << 0, 5, 9, 0, 0, 0, 0, 0, 0).finished();
  check(rough, symplectic_euler, bodies(r));
  check(Hertz{.modulus = 1e6}, symplectic_euler, bodies(r));
  check(Hertz{.modulus = 1e6}, trapezoidal, bodies<Smooth>(r));
  check(Hooke{.stiffness = 1e3, .restitution = 0.7, .friction = 0.4, .rolling_friction = 0.1}, symplectic_euler,
        bodies(r));
}

#elif PHISTEP_FULL

TEST_CASE("a damped spring's collision lasts as long and returns as much as the formula says") {
  // m* = ½, k = 1e5, c = 20; the figures have 9 and 7 digits. At 600 and 1200 steps a contact the errors of e are 1.4e-5 and
  // 3.4e-6; extrapolated, they are of the order of their product with (ωΔt)² = 3e-5.
  SECTION("to the end of the overlap") {
    const Hooke law{.stiffness = 1e5, .restitution = 0.868804629, .attracts = true};
    CHECK(law.numbers().damping * std::sqrt(0.5 * 1e5) == Approx(20).epsilon(1e-8));
    const Collision found = extrapolated(law, 1, 7.031850e-3 / 600);
    CHECK(found.restitution == Approx(0.868804629).epsilon(1e-8));
    CHECK(found.duration == Approx(7.031850e-3).epsilon(1e-7));
    const double exact = 0.868804629, e1 = collide(law, 1, 7.031850e-3 / 300).restitution - exact,
                 e2 = collide(law, 1, 7.031850e-3 / 600).restitution - exact;
    CHECK(std::log2(e1 / e2) == Approx(2).margin(0.05));
  }
  SECTION("to the end of the repulsion") {
    const Hooke law{.stiffness = 1e5, .restitution = 0.872291467};
    CHECK(law.numbers().damping * std::sqrt(0.5 * 1e5) == Approx(20).epsilon(1e-7));
    const Collision found = extrapolated(law, 1, 7.031850e-3 / 600);
    CHECK(found.restitution == Approx(0.872291467).epsilon(1e-8));
    CHECK(found.duration == Approx(6.831583e-3).epsilon(1e-6));
  }
}

TEST_CASE("the restitution of elastic spheres does not depend on the speed of impact") {
  // The dashpot begins with δ^(1/4), that is t^(1/4), so that one step of Verlet is wrong by Δt^(5/4) v^(…): this is the
  // order, and extrapolated with it the errors of 1e-4 at 250 steps a contact become 1e-6.
  const double order = std::pow(2.0, 1.25);
  for (const double e : {0.9, 0.5})
    for (const double speed : {0.01, 10.0}) {
      const Hertz law{.modulus = 1e7, .restitution = e};
      // t = 3.2 (m*²/(R* E*² v))^(1/5)
      const double duration = 3.2 * std::pow(0.25 / (0.25 * 1e14 * speed), 0.2);
      const double e1 = collide(law, speed, duration / 250).restitution - e,
                   e2 = collide(law, speed, duration / 500).restitution - e;
      CAPTURE(e, speed);
      CHECK(std::log2(e1 / e2) == Approx(1.25).margin(0.05));
      CHECK(std::abs(order * e2 - e1) / (order - 1) < 1e-5 * e);
    }
  // Pulling at its end it is as singular there, wherever in its step: (1/500)^(5/4) = 4e-4.
  const Hertz law{.modulus = 1e7, .restitution = 0.5, .attracts = true};
  CHECK(collide(law, 1, 3.2 * std::pow(0.25 / 0.25e14, 0.2) / 500).restitution == Approx(0.5).epsilon(4e-4));
}

TEST_CASE("energy of the springs: what the bodies lost") {
  const Hertz law{.modulus = 1e5, .shear_modulus = 8e4, .friction = 1e9, .tangential_damping = 0};
  Matrix r(3, 2);
  r << -0.5, 0.5, 0, 0, 0, 0;
  auto y = bodies(r);
  y.v.row(0) << 0.1, -0.1;
  const double dt = 4e-5;
  PhiStepper stepper{y, Contact{law}, velocity_verlet};
  const auto total = [&] {
    const auto masses = Grains::masses(y);
    return y.v.squaredNorm() / 2 + stepper.force_to_look_at().energy(0.0, Grains::view(y, masses), stepper.memory());
  };
  const double start = total();
  double least = y.v.squaredNorm();
  for (int n = 0; n < 1200; ++n) {
    REQUIRE(stepper.step(y, n * dt, dt));
    least = std::min(least, y.v.squaredNorm());
    REQUIRE(total() == Approx(start).epsilon(1e-5));  // Verlet: (ωΔt)² with ω about 300
  }
  CHECK(least < 0.5 * 0.02);
}

TEST_CASE("steps that fail or are taken back leave no trace") {
  bool fails = false;
  const auto trouble = [&fails](const Matrix& r, const Matrix&, double) -> Matrix {
    return Matrix::Constant(3, r.cols(), fails ? std::nan("") : 0.0);
  };
  check_no_trace(Contact{rough, 0.02} + term(trouble), [&fails](auto& stepper, Grains& y, double t) {
    fails = true;
    REQUIRE_FALSE(stepper.step(y, t, 1e-3));
    fails = false;
  });
}

TEST_CASE("tangents of resting bodies equal differences") {
  // Without slip and speed nothing is left out. The tangential spring is one in v here: what it adds in a step's time is
  // k_t τ v.
  Matrix r(3, 3);
  r << 0, 0.98, 0.5, 0, 0.1, 0.9, 0, 0.05, 0.1;
  auto y = bodies<Smooth>(r);
  const auto check = [&](auto law) {
    const Contact contact{law, 0.3};
    const auto masses = Smooth::masses(y);
    const double tau = 1e-3;
    auto memory = typename decltype(contact)::Memory{};
    contact.begin(0.0, tau, Smooth::view(y, masses), memory);
    const auto force = [&](const Smooth& at) {
      auto psi = make_rate<Smooth>(at);
      contact.add(tau, Smooth::view(at, masses), memory, psi);
      return Eigen::VectorXd(psi.force.reshaped());
    };
    struct Dense {
      Eigen::MatrixXd K = Eigen::MatrixXd::Zero(9, 9), C = K;
      void position(Index i, Index j, double x) { K(i, j) += x; }
      void velocity(Index i, Index j, double x) { C(i, j) += x; }
    } sink;
    contact.add_jacobian(tau, Smooth::view(y, masses), memory, sink);
    const double h = 1e-6;
    for (Index j = 0; j < 9; ++j) {
      Smooth a = y, b = y;
      a.r.data()[j] -= h, b.r.data()[j] += h;
      const Eigen::VectorXd k = (force(b) - force(a)) / (2 * h);
      CHECK((k - sink.K.col(j)).norm() < 1e-4 * sink.K.norm());
      a = y, b = y;
      a.v.data()[j] -= h, b.v.data()[j] += h;
      const Eigen::VectorXd c = (force(b) - force(a)) / (2 * h);
      CHECK((c - sink.C.col(j)).norm() < 1e-4 * sink.C.norm());
    }
    CHECK(sink.K.norm() > 100);
    CHECK(sink.C.norm() > 1);
  };
  check(Hooke{.stiffness = 1e3, .restitution = 0.7, .friction = 10});
  check(Hertz{.modulus = 1e4, .shear_modulus = 7e3, .restitution = 0.7, .friction = 10});
}

#endif

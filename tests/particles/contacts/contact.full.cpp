// contact: the full product and what is dear to compile. The quick half is contact.test.cpp.
#include "particles/contacts/contact_cases.hpp"

using namespace contact_cases;

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

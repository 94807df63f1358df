// preflight, the full list of scenes. The quick half is preflight.test.cpp.
#include "study/preflight_cases.hpp"

using namespace preflight_cases;

TEST_CASE("stable at preflight's dt, not at 1.5 times it: motion, Verlet") {
  {
    const auto y = chain_state(400);
    const auto report = check_scene("chain, velocity_verlet",
                                    PhiStepper{y, spring_network<1>(chain(400, 300)), velocity_verlet, mass(2.0)}, y);
    // ω = 2√(k/m) for an endless chain.
    CHECK(report.stable_dt == Approx(0.999 * 2 / (2 * std::sqrt(150.0))).epsilon(1e-6));
  }
  {
    Mat2 r(2, 225);
    for (int i = 0; i < 225; ++i) r.col(i) << i % 15, i / 15;
    const auto y = at_rest(r);
    check_scene("square lattice, velocity_verlet",
                PhiStepper{y, spring_network<2>(net(r, 1e4, 1.1)), velocity_verlet, mass(0.3)}, y);
    check_scene("square lattice with diagonals, velocity_verlet",
                PhiStepper{y, spring_network<2>(net(r, 1e4, 1.5)), velocity_verlet, mass(0.3)}, y);
  }
  {
    const Mat2 r = triangles(15);
    const auto y = at_rest(r);
    const auto report = check_scene("triangular lattice, velocity_verlet",
                                    PhiStepper{y, spring_network<2>(net(r, 50, 1.1)), velocity_verlet, mass(2.0)}, y);
    CHECK(report.whole.frequency <= std::sqrt(6 * 25.0) * (1 + 1e-9));
  }
  {
    Mat3 r(3, 216);
    Vec m(216);
    std::mt19937 random(3);
    std::uniform_real_distribution<double> exponent(-1, 1);
    for (int i = 0; i < 216; ++i) r.col(i) << i % 6, i / 6 % 6, i / 36;
    for (double& one : m) one = std::pow(10.0, exponent(random));
    const auto y = at_rest(r);
    check_scene("3-D lattice, masses 0.1 … 10, velocity_verlet",
                PhiStepper{y, spring_network<3>(net(r, 700, 1.5)), velocity_verlet, mass(m)}, y);
  }
  for (const unsigned seed : {11u, 12u, 13u}) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> place(0, 12), exponent(-1, 1);
    Mat2 r(2, 150);
    Vec m(150);
    for (int i = 0; i < 150; ++i) r.col(i) << place(random), place(random);
    for (double& one : m) one = std::pow(10.0, exponent(random));
    auto springs = net(r, 1, 1.7);
    for (Spring& s : springs) s.stiffness = std::pow(10.0, 2 * exponent(random));
    const auto y = at_rest(r);
    check_scene(("random net, seed " + std::to_string(seed) + ", velocity_verlet").c_str(),
                PhiStepper{y, spring_network<2>(springs), velocity_verlet, mass(m)}, y);
  }
}

TEST_CASE("stable at preflight's dt, not at 1.5 times it: first order") {
  {
    const Vec u = Vec::Zero(500);
    const auto report = check_scene("heat in 1-D, forward_euler",
                                    PhiStepper{u, problems::Heat<Eigen::SparseMatrix<double>>(500), forward_euler}, u);
    const double dx = 1.0 / 501;
    CHECK(report.stable_dt == Approx(0.999 * dx * dx / 2).epsilon(1e-6));
    CHECK(report.monotone_dt == Approx(dx * dx / 2).epsilon(1e-9));   // ρcΔx²/(2dk(1−φ))
    CHECK(report.unringing_dt == Approx(dx * dx / 4).epsilon(1e-6));  // 4dk in place of 2dk
  }
  {
    const Vec u = Vec::Zero(400);
    const auto report = check_scene("heat in 2-D, phi(0.25)", PhiStepper{u, linear(laplacian_2d(20)), phi(0.25)}, u);
    CHECK(report.stable_dt == Approx(0.999 * 2 / (0.5 * 8)).epsilon(0.02));  // a finite grid's ρ is a little below 8
  }
  {
    // u_t = −u_x + 0.01 u_xx, upwind: nonsymmetric, discs left of 0.
    std::vector<Eigen::Triplet<double>> entries;
    const double flow = 250, diffusion = 0.01 * 250 * 250;
    for (int i = 0; i < 250; ++i) {
      entries.emplace_back(i, i, -flow - 2 * diffusion);
      if (i > 0) entries.emplace_back(i, i - 1, flow + diffusion);
      if (i < 249) entries.emplace_back(i, i + 1, diffusion);
    }
    Eigen::SparseMatrix<double> A(250, 250);
    A.setFromTriplets(entries.begin(), entries.end());
    const Vec u = Vec::Zero(250);
    check_scene("advection and diffusion, forward_euler", PhiStepper{u, linear(A), forward_euler}, u);
  }
  {
    // Brusselator at rest, a = 1, b = 1.5: eigenvalues −¼ ± i√(15/16), limit 2·¼/1.
    const Eigen::Vector2d y{1, 1.5};
    const auto f = [](const Eigen::Vector2d& u) -> Eigen::Vector2d {
      return {1 + u[0] * u[0] * u[1] - 2.5 * u[0], 1.5 * u[0] - u[0] * u[0] * u[1]};
    };
    const auto report = check_scene("Brusselator, forward_euler", PhiStepper{y, f, forward_euler}, y);
    CHECK(report.stable_dt == Approx(0.999 * 0.5).epsilon(1e-6));
  }
  {
    const Vec u = Vec::Zero(40);
    const Eigen::MatrixXd M = Eigen::MatrixXd(laplacian_2d(1).coeff(0, 0) * -0.25 * Eigen::MatrixXd::Identity(40, 40)) +
                              0.25 * (Eigen::MatrixXd(Eigen::MatrixXd::Identity(40, 40)).rowwise().reverse());
    Eigen::MatrixXd A = Eigen::MatrixXd::Zero(40, 40);
    for (int i = 0; i < 40; ++i) {
      A(i, i) = -2;
      if (i > 0) A(i, i - 1) = A(i - 1, i) = 1;
    }
    check_scene("heat with a full capacity matrix, forward_euler", PhiStepper{u, linear(A), forward_euler, capacity(M)},
                u);
  }
}

// The whole library in one program, to be compiled by every compiler and run on every machine: no test framework, nothing but
// <phistep/all.hpp>. Each answer is printed with all its bits and checked against what is known of it, to a tolerance that
// other roundings keep. Nothing here is random, and no sine or cosine is taken: those are the C library's.
//
//     answers                   prints and checks; 0 where all answers are right
//     answers --save FILE       also leaves a checkpoint in the middle of a run …
//     answers --load FILE       … and goes on from one, perhaps another machine's: tells whether it may, and ends with the same bits
#include <phistep/all.hpp>

#include <cmath>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <sstream>
#include <string>

#include "compatibility/answer.hpp"
#include "problems/hires.hpp"
#include "problems/kepler.hpp"
#include "problems/robertson.hpp"

using namespace phistep;
using namespace answers;
using Eigen::Vector3d;
using problems::Hires;
using problems::Kepler;
using problems::Robertson;

namespace {

template <class V>
double apart(const V& y, const V& exact, const V& scale) {
  return ((y - exact).array() / scale.array()).abs().maxCoeff();
}

/// Fixed, first order: Rosenbrock and Radau under a tolerance.
void reactions() {
  Vector3d y = Robertson::start();
  PhiStepper stepper{y, Robertson{}, rodas4};
  const Statistics counts = good(integrate(stepper, y, {0, Robertson::end}, tolerance{.rtol = 1e-6, .atol = 1e-12}));
  answer("Robertson, rodas4: error / rtol", apart(y, Robertson::exact(), Robertson::scale()) / 1e-6, 0, 10);
  answer("Robertson, rodas4: y1", y[0], Robertson::exact()[0], 1e-5);
  answer("Robertson, rodas4: steps", static_cast<double>(counts.steps), 85, 80);

  Hires::State z = Hires::start();
  PhiStepper high{z, Hires{}, radau};
  good(integrate(high, z, {0, Hires::end}, tolerance{.rtol = 1e-9, .atol = 1e-13}));
  const Hires::State exact = Hires::exact();
  answer("Hires, radau: error / rtol", apart(z, exact, exact) / 1e-9, 0, 100);
  answer("Hires, radau: y6", z[5], exact[5], 1e-9);
}

/// Motion without friction: Verlet, a Nyström pair that stops at events, a symplectic one.
void orbits() {
  const Kepler kepler{0.6};
  auto y = kepler.start();
  PhiStepper pair{y, kepler, rkn86};
  // Farthest, nearest, farthest: half a period apart.
  auto turns = event([](const Kepler::State& now) { return now.r.dot(now.v); });
  good(integrate(pair, y, {0.1, 0.1 + 2 * Kepler::period}, tolerance{.rtol = 1e-10, .atol = 1e-10}, turns));
  answer("Kepler, rkn86: turns", static_cast<double>(turns.times().size()), 3, 0);
  answer("Kepler, rkn86: the last turn", turns.times().empty() ? 0.0 : turns.times().back(), 0.1 + 1.5 * Kepler::period,
         1e-8);
  answer("Kepler, rkn86: x", y.r[0], 0.4, 1e-8);

  y = kepler.start();
  PhiStepper symplectic{y, kepler, srkn11b};
  good(integrate(symplectic, y, {0, 10 * Kepler::period}, fixed(Kepler::period / 200)));
  answer("Kepler, srkn11b: angular momentum", Kepler::angular_momentum(y), 0.8, 1e-13);
  answer("Kepler, srkn11b: y", y.r[1], 0, 1e-4);

  y = kepler.start();
  PhiStepper verlet{y, kepler, velocity_verlet};
  good(integrate(verlet, y, {0, Kepler::period}, fixed(Kepler::period / 2000)));
  answer("Kepler, velocity_verlet: x", y.r[0], 0.4, 1e-3);
}

/// Argon, periodic: pair lists against the plain double loop, energy, momentum.
void atoms() {
  constexpr Index side = 10, n = side * side * side;
  const double spacing = 1.2, length = spacing * side, cutoff = 2.2, dt = 0.004;
  Eigen::Matrix3Xd r(3, n), v(3, n);
  for (Index k = 0; k < n; ++k) {
    r.col(k) << static_cast<double>(k % side), static_cast<double>(k / side % side),
        static_cast<double>(k / (side * side));
    r.col(k) *= spacing;
    // Numbers that look thrown, and are the same everywhere.
    for (Index a = 0; a < 3; ++a) {
      r(a, k) += static_cast<double>((7 * k + 11 * a + 3) % 23 - 11) / 256;
      v(a, k) = static_cast<double>((13 * k + 5 * a) % 31 - 15) / 8;
    }
  }
  Particles<double, 3> y{r, v};
  y.set_box(Box<double, 3>::periodic(Vector3d::Zero(), Vector3d::Constant(length)));
  const LennardJones law = LennardJones{}.shifted(cutoff);
  Eigen::Matrix3Xd f = Eigen::Matrix3Xd::Zero(3, n);
  double energy = v.squaredNorm() / 2;
  for (Index i = 0; i < n; ++i)
    for (Index j = i + 1; j < n; ++j) {
      double d[3], square = 0;
      for (Index a = 0; a < 3; ++a) {
        d[a] = r(a, i) - r(a, j);
        d[a] -= length * std::round(d[a] / length);
        square += d[a] * d[a];
      }
      if (square >= cutoff * cutoff) continue;
      const double g = law(square);
      energy += law.energy(square);
      for (Index a = 0; a < 3; ++a) f(a, i) += g * d[a], f(a, j) -= g * d[a];
    }
  const Eigen::Matrix3Xd one = r + dt * (v + dt / 2 * f);
  PhiStepper stepper{y, Pairs{law, cutoff}, velocity_verlet};
  EnergyLedger ledger{stepper};
  const Vector3d before = momentum(y);
  good(integrate(stepper, y, {0, dt}, fixed(dt)));
  answer("argon: one step, by the double loop", (y.r - one).cwiseAbs().maxCoeff(), 0, 1e-13);
  good(integrate(stepper, y, {dt, 26 * dt}, fixed(dt), ledger));
  answer("argon: energy after 25 steps", ledger.energy() / energy, 1, 1e-3);
  answer("argon: momentum", (momentum(y) - before).cwiseAbs().maxCoeff(), 0, 1e-10);
  answer("argon: x of the last atom", y.r(0, n - 1), one(0, n - 1), 0.5);
  double digest = 0;
  for (Index k = 0; k < n; ++k) digest += static_cast<double>(k % 7 + 1) * (y.r.col(k).sum() + y.v.col(k).sum());
  answer("argon: all in one number", digest, digest, 0);
}

/// A grain against a wall: the restitution that was asked for, and friction that makes it roll.
void grains() {
  using Grains = Particles<double, 3, Spin>;
  Grains y{Eigen::Matrix3Xd{Vector3d{0, 0, 0.6}}, Eigen::Matrix3Xd{Vector3d{0.5, 0, -1}}};
  y.set_radius(0.5).set_mass(2.0);
  const Hooke law{.stiffness = 1e5, .restitution = 0.7, .friction = 0.3};
  PhiStepper stepper{y, Contact{law} + Walls<Hooke>{law, Plane<3>{Vector3d::Zero(), Vector3d::UnitZ()}},
                     symplectic_euler};
  good(integrate(stepper, y, {0, 0.3}, fixed(1e-5)));
  answer("grain: restitution", y.v(2, 0), 0.7, 2e-3);
  // The contact's own point loses tangential speed; m v_x R + I ω_y about it stays, I = 2/5 m R², but for the overlap.
  answer("grain: angular momentum about the contact", y.v(0, 0) + 0.4 * 0.5 * y.omega(1, 0), 0.5, 5e-3);
  answer("grain: x", y.r(0, 0), 0.12, 0.04);
}

/// Half a run, a checkpoint, the other half by a fresh program; and the same from a file.
void checkpoints(const std::string& save, const std::string& load) {
  using State = Kepler::State;
  const Kepler kepler{0.3};
  const tolerance eight{.rtol = 1e-8, .atol = 1e-8};
  const auto run = [&](auto&& meanwhile) {
    State y = kepler.start();
    PhiStepper stepper{y, kepler, tr_bdf2};
    Run all{stepper, y, {0, 3}, eight};
    meanwhile(all);
    good(all.finish());
    return y;
  };
  std::stringstream file(std::ios::in | std::ios::out | std::ios::binary);
  const State unbroken = run([&](auto& all) {
    for (int n = 0; n < 20; ++n) static_cast<void>(all.advance());
    save_checkpoint(file, all);
    if (!save.empty()) save_checkpoint(std::filesystem::path(save), all);
  });
  const State resumed = run([&](auto& all) { load_checkpoint(file, all); });
  answer("checkpoint: the bits of the run that saved", unbroken.r == resumed.r && unbroken.v == resumed.v);
  answer("checkpoint: x", unbroken.r[0], kepler.exact(3).r[0], 1e-6);
  if (load.empty()) return;
  try {
    const State other = run([&](auto& all) {
      if (!load_checkpoint(std::filesystem::path(load), all)) throw CheckpointError("there is no " + load);
    });
    std::fprintf(stderr, "loaded: %s\n",
                 other.r == unbroken.r && other.v == unbroken.v ? "the same bits" : "other bits");
  } catch (const CheckpointError& error) {
    std::fprintf(stderr, "refused: %s\n", error.what());
  }
}

/// What writes text.
void text() {
  Particles<double, 3> y{Eigen::Matrix<double, 3, 2>{{1.0 / 3, 1}, {0.1, 2}, {1e-300, -3}}};
  std::ostringstream frame;
  extended_xyz(frame, {.species = {"Ar"}, .exact = true})(0.7, y);
  answer("xyz: a frame", frame.str() ==
                             "2\npbc=\"F F F\" Properties=species:S:1:pos:R:3:velo:R:3:id:I:1 Time=0.7\n"
                             "Ar 0.3333333333333333 0.1 1e-300 0 0 0 0\nAr 1 2 -3 0 0 0 1\n");
}

/// What a NaN must never do: pass.
void failures() {
  Vector3d y{1, 0, 0};
  const Vector3d before = y;
  PhiStepper stepper{y, [](const Vector3d& x) -> Vector3d { return x / (x[1] * x[2]); }, trapezoidal};
  const auto report = stepper.step(y, 0.0, 0.1);
  answer("failure: a NaN is found", report.outcome() == Outcome::non_finite_force);
  answer("failure: the state is as it was", std::memcmp(&y, &before, sizeof y) == 0);
}

void packs() {
  using P = Pack<double, native_width<double>>;
  const P x = P::make([](int l) { return 0.3 + l; });
  answer("packs: exp", exp(x)[0], 1.3498588075760032, 1e-15);
  answer("packs: rsqrt", rsqrt(x)[0], 1.8257418583505538, 1e-15);
  answer("packs: 1/x^3", reciprocal(pow<3>(x))[0], 37.037037037037045, 1e-13);
}

}  // namespace

int main(int argc, char** argv) {
  std::string save, load;
  for (int i = 1; i + 1 < argc; i += 2) (std::string(argv[i]) == "--save" ? save : load) = argv[i + 1];
  reactions();
  orbits();
  atoms();
  grains();
  checkpoints(save, load);
  text();
  failures();
  packs();
  return result();
}

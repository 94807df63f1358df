// A run that is interrupted, and taken up again to the last bit.
//
// Blocks in a row on a belt, tied to their neighbours and to a frame by springs: dry friction drags each along until it
// slips. Friction is a spring to an anchor on the belt that gives way, so the force remembers where it holds; and each slip
// hangs on all before it, so that a run with the least difference soon slips elsewhere.
//
// The program writes a checkpoint now and then, and is cut off in the middle without a warning. Started again, it finds
// the file and goes on. It ends where a run without the break ends that wrote its checkpoints likewise, in every bit:
// positions, velocities, anchors, counts, though the steps' lengths were chosen by their error. Taken up from positions
// and velocities alone it ends elsewhere.
//
// Run: resume [--short] [--out DIR]
#include <phistep/io.hpp>
#include <phistep/phistep.hpp>

#include <cmath>
#include <cstdio>
#include <filesystem>

#include "command_line.hpp"

using Vec = Eigen::VectorXd;
using Row = phistep::Motion<Vec>;

const phistep::tolerance accuracy{.rtol = 1e-3, .max_step = 0.02};
constexpr Eigen::Index blocks = 12;
constexpr double speed = 0.1, frame = 20, coupling = 60, grip = 400, hold = 4;  // [m/s] [N/m] [N/m] [N/m] [N]

/// Dry friction: pulls to an anchor that rides on the belt, with `hold` at most.
struct Friction : phistep::ForceTerm {
  static constexpr const char* name = "friction";
  struct Memory {
    Vec anchor;      // [m]
    long slips = 0;  // steps in which one or more gave way
    void archive(auto& ar) { ar("anchor", anchor, "slips", slips); }
  };
  static constexpr bool uses_velocity = false, uses_time = false;

  static void begin(double /*t*/, double dt, const auto& y, Memory& m) {
    if (m.anchor.size() == 0) m.anchor = y.r;
    m.anchor.array() += speed * dt;
  }
  static void add(double /*t*/, const auto& y, const Memory& m, auto& out) {
    out.force += (grip * (m.anchor - y.r)).cwiseMax(-hold).cwiseMin(hold);
  }
  static void commit(double /*t*/, const auto& y, Memory& m) {
    const Vec reach = (m.anchor - y.r).cwiseMax(-hold / grip).cwiseMin(hold / grip);
    m.slips += (y.r + reach - m.anchor).cwiseAbs().maxCoeff() > 1e-9;
    m.anchor = y.r + reach;
  }
};
Vec springs(const Vec& r) {
  Vec force = -frame * r;
  for (Eigen::Index i = 0; i + 1 < blocks; ++i) {
    const double pull = coupling * (r[i + 1] - r[i]);
    force[i] += pull;
    force[i + 1] -= pull;
  }
  return force;
}

struct End {
  double t;
  Row y;
  Friction::Memory friction;
  phistep::Statistics statistics;
};
/// The program. It goes on from the checkpoint if there is one, and is gone at `cut_off`.
End program(const std::filesystem::path& checkpoint, double t1, double cut_off = INFINITY) {
  Row y{Vec::LinSpaced(blocks, 0, 9).array().sin() / 100, Vec::Zero(blocks)};
  phistep::PhiStepper stepper{y, phistep::term(springs) + Friction{}, phistep::tr_bdf2};
  phistep::Run run{stepper, y, {0, t1}, accuracy};
  if (phistep::load_checkpoint(checkpoint, run)) std::printf("  goes on from t = %.6f s\n", run.time());
  double written = run.time();
  while (run.time() < cut_off && run.advance())
    if (run.time() - written > t1 / 20) phistep::save_checkpoint(checkpoint, run), written = run.time();
  return {run.time(), y, std::get<1>(stepper.memory()), stepper.statistics()};
}

int main(int argc, char** argv) {
  const CommandLine options(argc, argv);
  const double t1 = options.is_short ? 10 : 100;  // [s]
  const auto file = options.out / "resume.checkpoint", other = options.out / "resume_unbroken.checkpoint";
  for (const auto& old : {file, other}) std::filesystem::remove(old);
  const End unbroken = program(other, t1);
  std::printf("Without a break: t = %g s, %ld steps with slips\n", unbroken.t, unbroken.friction.slips);
  const End cut = program(file, t1, 0.63 * t1);
  std::printf("Cut off at t = %.6f s, and started again:\n", cut.t);
  const End resumed = program(file, t1);
  const auto& [t, y, friction, statistics] = resumed;
  const bool same = t == unbroken.t && y.r == unbroken.y.r && y.v == unbroken.y.v &&
                    friction.anchor == unbroken.friction.anchor && friction.slips == unbroken.friction.slips &&
                    statistics == unbroken.statistics;
  std::printf("  ends with %s bits and counts\n", same ? "the same" : "OTHER");
  Row bare = cut.y;
  phistep::PhiStepper stepper{bare, phistep::term(springs) + Friction{}, phistep::tr_bdf2};
  const auto report = phistep::integrate(stepper, bare, {cut.t, t1}, accuracy);
  const double apart = (bare.r - unbroken.y.r).cwiseAbs().maxCoeff();
  std::printf("From positions and velocities alone, at the same time: ends %.1e m elsewhere\n", apart);
  return same && report && apart > 1e-3 ? 0 : 1;
}

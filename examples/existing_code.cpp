// An existing code, embedded: a cloth of beads and springs in an array of structs, with its own force routine and its own
// loops, as it was (`before`) and with phistep (`after`).
//
// Both are one file, existing_codes/mass_spring.hpp: the lines under #ifdef WITH_PHISTEP are all that is new, the loops
// under #else are what they replace. The same scheme gives the same bits; any other is another word. The other two codes
// of that folder, molecular dynamics with double (*x)[3] and heat with a double*, are embedded in the same way.
//
// Run: existing_code [--short] [--out DIR]
#include <phistep/krylov.hpp>

#include "command_line.hpp"
#include "existing_codes/before_and_after.hpp"

int main(int argc, char** argv) {
  const CommandLine options(argc, argv);
  const double t1 = options.is_short ? 0.1 : 0.5, dt = 1e-3;
  const int beads = 225, steps = static_cast<int>(std::lround(t1 / dt));
  const auto off = [](const auto& cloth, const auto& right) {
    const auto &a = cloth.beads[0].x, &b = right.beads[0].x;
    return 1000 * std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);
  };

  after::Cloth right(beads);
  const double energy = right.energy();
  right.run_verlet(50 * steps, dt / 50);
  std::printf("A cloth of %d beads, pinned at two corners, after a fall of %g s:\n", beads, t1);
  std::printf("%-42s %9s %13s %14s %12s\n", "", "dt [ms]", "energy [mJ]", "corner [mm]", "force calls");
  const auto show = [&](const char* name, double step, const auto& cloth) {
    std::printf("%-42s %9g %+13.4f %14.4f %12ld\n", name, 1000 * step, 1000 * (cloth.energy() - energy),
                off(cloth, right), cloth.force_calls);
  };

  before::Cloth euler(beads), verlet(beads);
  euler.run_euler(steps, dt);
  show("by hand, semi-implicit Euler", dt, euler);
  after::Cloth embedded_euler(beads), embedded_verlet(beads);
  embedded_euler.run_euler(steps, dt);
  show("phistep::symplectic_euler", dt, embedded_euler);
  verlet.run_verlet(steps, dt);
  show("by hand, velocity Verlet", dt, verlet);
  embedded_verlet.run_verlet(steps, dt);
  show("phistep::velocity_verlet", dt, embedded_verlet);

  // Any other scheme in the same place.
  const auto by = [&](const char* name, double step, auto scheme, auto... solver) {
    after::Cloth cloth(beads);
    const auto forces = [&](auto& y) { return y.force_of_r([&] { cloth.compute_forces(); }); };
    cloth.run_by(static_cast<int>(std::lround(t1 / step)), step, scheme, forces, solver...);
    show(name, step, cloth);
  };
  by("phistep::srkn6b, of order 4", 2 * dt, phistep::srkn6b);
  by("phistep::midpoint, fixed_point()", dt, phistep::midpoint, phistep::fixed_point());
  const auto krylov = phistep::newton<phistep::MatrixFree<>>({.rtol = 1e-4});
  by("phistep::backward_euler, Krylov iterations", 10 * dt, phistep::backward_euler, krylov);

  std::printf("energy: what was gained; corner: how far the free corner is from where steps of dt/50 lead.\n");
  const double apart = std::fmax(off(euler, embedded_euler), off(verlet, embedded_verlet));
  std::printf("By hand and embedded differ by %.1e mm: the same methods, the same memory.\n", apart);
  return apart < 1e-6 ? 0 : 1;
}

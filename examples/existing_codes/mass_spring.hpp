/// @file
/// A cloth of beads and springs as many codes have it: an array of structs, forces gathered spring by spring into the
/// structs, two loops by hand (semi-implicit Euler, velocity Verlet).
///
/// Without WITH_PHISTEP this is the code as it was. With it, the lines below #ifdef WITH_PHISTEP replace the loops: the
/// difference is what an existing code has to change. Included once for each, in a namespace of its own (CODE); the
/// probe alone is not part of such a code: tests put their faults there.
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <functional>
#include <stdexcept>
#include <string>
#include <vector>
#ifdef WITH_PHISTEP
#include <phistep/in_place.hpp>
#endif

namespace CODE {

enum BeadFlags : int { BEAD_PINNED = 1, BEAD_HEM = 2 };

struct Bead {
  double x[3];   // position [m]
  double v[3];   // velocity [m/s]
  double f[3];   // force [N]
  double m;      // mass [kg]
  double inv_m;  // 1/m
  int id;        // row * side + column
  int flags;     // BeadFlags
};

enum SpringKind : int { STRUCTURAL, SHEAR, BEND };

struct Spring {
  int a, b;     // the beads at its ends
  double rest;  // rest length [m]
  double k;     // stiffness [N/m]
  SpringKind kind;
};

struct ClothParameters {
  double spacing = 0.02;                  // [m]
  double bead_mass = 1e-3;                // [kg]
  double hem_mass = 1.5e-3;               // [kg], beads along the border
  double k_structural = 50.0;             // [N/m]
  double k_shear = 20.0;                  // [N/m]
  double k_bend = 5.0;                    // [N/m]
  double spring_damping = 0.0;            // [N s/m], along the spring
  double air_drag = 0.0;                  // [N s/m], per bead
  double gravity[3] = {0.0, 0.0, -9.81};  // [m/s^2]
};

class Cloth {
 public:
  explicit Cloth(int n, const ClothParameters& parameters = ClothParameters()) : p(parameters) { init(n); }

  std::vector<Bead> beads;
  std::vector<Spring> springs;
  ClothParameters p;
  int side = 0;
  double time = 0.0;
  long force_calls = 0;
  std::function<void()> probe;  // from outside: called at the end of compute_forces

  // ---- set-up ------------------------------------------------------------------------------------------------------

  // A square sheet of about n beads in the x-y plane, two corners pinned, slightly rippled so that it doesn't fall flat.
  void init(int n) {
    side = static_cast<int>(std::lround(std::sqrt(static_cast<double>(n))));
    if (side < 2) throw std::invalid_argument("Cloth: at least 4 beads");
    beads.assign(static_cast<size_t>(side) * static_cast<size_t>(side), Bead());
    springs.clear();
    for (int row = 0; row < side; ++row) {
      for (int col = 0; col < side; ++col) {
        Bead& b = bead(row, col);
        b.id = row * side + col;
        b.x[0] = col * p.spacing;
        b.x[1] = row * p.spacing;
        b.x[2] = 0.1 * p.spacing * std::sin(0.7 * col + 0.3 * row);
        b.v[0] = b.v[1] = b.v[2] = 0.0;
        b.f[0] = b.f[1] = b.f[2] = 0.0;
        b.flags = 0;
        const bool border = row == 0 || col == 0 || row == side - 1 || col == side - 1;
        if (border) b.flags |= BEAD_HEM;
        b.m = border ? p.hem_mass : p.bead_mass;
        b.inv_m = 1.0 / b.m;
      }
    }
    pin(side - 1, 0);
    pin(side - 1, side - 1);
    for (int row = 0; row < side; ++row) {
      for (int col = 0; col < side; ++col) {
        connect(row, col, row, col + 1, STRUCTURAL);
        connect(row, col, row + 1, col, STRUCTURAL);
        connect(row, col, row + 1, col + 1, SHEAR);
        connect(row, col, row + 1, col - 1, SHEAR);
        connect(row, col, row, col + 2, BEND);
        connect(row, col, row + 2, col, BEND);
      }
    }
    time = 0.0;
    force_calls = 0;
  }

  Bead& bead(int row, int col) { return beads[static_cast<size_t>(row * side + col)]; }

  // A pinned bead starts at rest and feels no force, so that no integrator moves it.
  void pin(int row, int col) { bead(row, col).flags |= BEAD_PINNED; }

  void connect(int row_a, int col_a, int row_b, int col_b, SpringKind kind) {
    if (row_b < 0 || row_b >= side || col_b < 0 || col_b >= side) return;
    Spring s;
    s.a = row_a * side + col_a;
    s.b = row_b * side + col_b;
    s.kind = kind;
    s.k = kind == STRUCTURAL ? p.k_structural : kind == SHEAR ? p.k_shear : p.k_bend;
    s.rest = p.spacing * std::hypot(row_b - row_a, col_b - col_a);
    springs.push_back(s);
  }

  // ---- forces ------------------------------------------------------------------------------------------------------

  // Reads x of all beads, writes f of all beads.
  void compute_forces() {
    ++force_calls;
    clear_forces();
    add_gravity();
    add_springs();
    release_pins();
    if (probe) probe();
  }

  // Reads x and v.
  void compute_all_forces() {
    compute_forces();
    if (p.spring_damping > 0.0) add_spring_damping();
    if (p.air_drag > 0.0) add_air_drag();
    if (p.spring_damping > 0.0) release_pins();
  }

  void clear_forces() {
    for (Bead& b : beads) b.f[0] = b.f[1] = b.f[2] = 0.0;
  }

  void add_gravity() {
    for (Bead& b : beads) {
      b.f[0] += b.m * p.gravity[0];
      b.f[1] += b.m * p.gravity[1];
      b.f[2] += b.m * p.gravity[2];
    }
  }

  void add_springs() {
    for (const Spring& s : springs) {
      Bead& a = beads[static_cast<size_t>(s.a)];
      Bead& b = beads[static_cast<size_t>(s.b)];
      const double dx = b.x[0] - a.x[0], dy = b.x[1] - a.x[1], dz = b.x[2] - a.x[2];
      const double length = std::sqrt(dx * dx + dy * dy + dz * dz);
      const double pull = s.k * (length - s.rest) / length;
      a.f[0] += pull * dx, a.f[1] += pull * dy, a.f[2] += pull * dz;
      b.f[0] -= pull * dx, b.f[1] -= pull * dy, b.f[2] -= pull * dz;
    }
  }

  // Dashpots along the springs.
  void add_spring_damping() {
    for (const Spring& s : springs) {
      if (s.kind == BEND) continue;
      Bead& a = beads[static_cast<size_t>(s.a)];
      Bead& b = beads[static_cast<size_t>(s.b)];
      double d[3], length2 = 0.0, rate = 0.0;
      for (int k = 0; k < 3; ++k) {
        d[k] = b.x[k] - a.x[k];
        length2 += d[k] * d[k];
        rate += d[k] * (b.v[k] - a.v[k]);
      }
      const double c = p.spring_damping * rate / length2;
      for (int k = 0; k < 3; ++k) {
        a.f[k] += c * d[k];
        b.f[k] -= c * d[k];
      }
    }
  }

  void add_air_drag() {
    for (Bead& b : beads)
      for (int k = 0; k < 3; ++k) b.f[k] -= p.air_drag * b.v[k];
  }

  void release_pins() {
    for (Bead& b : beads)
      if (b.flags & BEAD_PINNED) b.f[0] = b.f[1] = b.f[2] = 0.0;
  }

  // ---- time stepping -----------------------------------------------------------------------------------------------

#ifdef WITH_PHISTEP
  void run_by(int steps, double dt, auto scheme, auto force_of, auto... solver) {
    using namespace phistep;
    MotionInPlace state{places(beads, &Bead::x), places(beads, &Bead::v), places(beads, &Bead::f)};
    PhiStepper stepper{state, force_of(state), scheme, mass(places(beads, &Bead::m)), solver...};
    if (const auto done = integrate(stepper, state, {0, steps * dt}, fixed(dt)); !done) stop(done.message());
  }
#endif

  // Semi-implicit Euler: v first, then x with the new v.
  void run_euler(int steps, double dt) {
#ifdef WITH_PHISTEP
    run_by(steps, dt, phistep::symplectic_euler, [&](auto& y) { return y.force_of_rv([&] { compute_all_forces(); }); });
#else
    for (int step = 0; step < steps; ++step) {
      compute_all_forces();
      for (Bead& b : beads) {
        for (int k = 0; k < 3; ++k) b.v[k] += dt * b.inv_m * b.f[k];
        for (int k = 0; k < 3; ++k) b.x[k] += dt * b.v[k];
      }
    }
#endif
    time += steps * dt;
  }

  // Velocity Verlet: no damping, since its forces are those of the positions alone.
  void run_verlet(int steps, double dt) {
#ifdef WITH_PHISTEP
    run_by(steps, dt, phistep::velocity_verlet, [&](auto& y) { return y.force_of_r([&] { compute_forces(); }); });
#else
    compute_forces();
    for (int step = 0; step < steps; ++step) {
      for (Bead& b : beads) {
        for (int k = 0; k < 3; ++k) b.v[k] += 0.5 * dt * b.inv_m * b.f[k];
        for (int k = 0; k < 3; ++k) b.x[k] += dt * b.v[k];
      }
      compute_forces();
      for (Bead& b : beads)
        for (int k = 0; k < 3; ++k) b.v[k] += 0.5 * dt * b.inv_m * b.f[k];
    }
#endif
    time += steps * dt;
  }

  static void stop(const std::string& what) { throw std::runtime_error("cloth: " + what); }

  // ---- output ------------------------------------------------------------------------------------------------------

  double kinetic_energy() const {
    double e = 0.0;
    for (const Bead& b : beads) e += 0.5 * b.m * (b.v[0] * b.v[0] + b.v[1] * b.v[1] + b.v[2] * b.v[2]);
    return e;
  }

  double potential_energy() const {
    double e = 0.0;
    for (const Bead& b : beads)
      for (int k = 0; k < 3; ++k) e -= b.m * p.gravity[k] * b.x[k];
    for (const Spring& s : springs) {
      const Bead& a = beads[static_cast<size_t>(s.a)];
      const Bead& b = beads[static_cast<size_t>(s.b)];
      const double stretch = std::hypot(b.x[0] - a.x[0], b.x[1] - a.x[1], b.x[2] - a.x[2]) - s.rest;
      e += 0.5 * s.k * stretch * stretch;
    }
    return e;
  }

  double energy() const { return kinetic_energy() + potential_energy(); }

  // One bead a line: id x y z vx vy vz
  bool write_beads(const std::string& path) const {
    std::FILE* file = std::fopen(path.c_str(), "w");
    if (!file) return false;
    std::fprintf(file, "# t = %.17g\n", time);
    for (const Bead& b : beads)
      std::fprintf(file, "%d %.9g %.9g %.9g %.9g %.9g %.9g\n", b.id, b.x[0], b.x[1], b.x[2], b.v[0], b.v[1], b.v[2]);
    return std::fclose(file) == 0;
  }
};

}  // namespace CODE

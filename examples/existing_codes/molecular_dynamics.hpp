/// @file
/// Molecular dynamics as many codes have it: raw arrays double (*x)[3], a Lennard-Jones force with a cell list of its
/// own, velocity Verlet by hand, reduced units.
///
/// Without WITH_PHISTEP this is the code as it was. With it, the lines below #ifdef WITH_PHISTEP replace the loop: the
/// difference is what an existing code has to change. Included once for each, in a namespace of its own (CODE); the
/// probe alone is not part of such a code: tests put their faults there.
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <stdexcept>
#include <string>
#ifdef WITH_PHISTEP
#include <phistep/in_place.hpp>
#endif

namespace CODE {

class MolecularDynamics {
 public:
  // ---- parameters, reduced units -----------------------------------------------------------------------------------
  double density = 0.8442;
  double temperature0 = 1.44;
  double cutoff = 2.5;
  double mass = 1.0;
  int thermo_every = 0;  // steps between lines of output, 0: none
  std::FILE* thermo_file = stdout;

  // ---- the system --------------------------------------------------------------------------------------------------
  int natoms = 0;
  double box = 0.0;  // side of the periodic cube
  double (*x)[3] = nullptr;
  double (*v)[3] = nullptr;
  double (*f)[3] = nullptr;
  double potential = 0.0;  // of the last call of compute_forces
  double virial = 0.0;
  long force_calls = 0;
  long step_number = 0;
  std::function<void()> probe;  // from outside: called at the end of compute_forces

  explicit MolecularDynamics(int n) {
    allocate(n);
    set_lattice();
    set_velocities(87287);
    set_cells();
  }
  MolecularDynamics(const MolecularDynamics&) = delete;
  MolecularDynamics& operator=(const MolecularDynamics&) = delete;
  ~MolecularDynamics() {
    std::free(x);
    std::free(v);
    std::free(f);
    std::free(next);
    std::free(head);
  }

  // ---- time stepping -----------------------------------------------------------------------------------------------

  void run(int steps, double dt) {
#ifdef WITH_PHISTEP
    phistep::MotionInPlace state{phistep::places(x, natoms), phistep::places(v, natoms), phistep::places(f, natoms)};
    phistep::PhiStepper stepper{state, state.force_of_r([&] { compute_forces(); }), phistep::velocity_verlet,
                                phistep::mass(mass)};
#else
    compute_forces();
#endif
    for (int step = 0; step < steps; ++step) {
#ifdef WITH_PHISTEP
      if (const auto report = stepper.step(state, step * dt, dt); !report) stop(report.message());
#else
      const double kick = 0.5 * dt / mass;
      for (int i = 0; i < natoms; ++i) {
        for (int k = 0; k < 3; ++k) {
          v[i][k] += kick * f[i][k];
          x[i][k] += dt * v[i][k];
        }
      }
      compute_forces();
      for (int i = 0; i < natoms; ++i)
        for (int k = 0; k < 3; ++k) v[i][k] += kick * f[i][k];
#endif
      ++step_number;
      if (thermo_every > 0 && step_number % thermo_every == 0) print_thermo();
    }
  }

  // ---- forces ------------------------------------------------------------------------------------------------------

  // Reads x, writes f, potential and virial. x is never wrapped here: atoms that left the box are looked at through
  // the minimum image.
  void compute_forces() {
    ++force_calls;
    potential = 0.0;
    virial = 0.0;
    for (int i = 0; i < natoms; ++i) f[i][0] = f[i][1] = f[i][2] = 0.0;
    if (cells >= 3) {
      sort_into_cells();
      forces_by_cells();
    } else {
      for (int i = 0; i < natoms; ++i)
        for (int j = i + 1; j < natoms; ++j) add_pair(i, j);
    }
    if (probe) probe();
  }

  double temperature() const { return 2.0 * kinetic_energy() / (3.0 * (natoms - 1)); }

  double pressure() const {
    const double volume = box * box * box;
    return (natoms * temperature() + virial / 3.0) / volume;
  }

  double kinetic_energy() const {
    double sum = 0.0;
    for (int i = 0; i < natoms; ++i) sum += v[i][0] * v[i][0] + v[i][1] * v[i][1] + v[i][2] * v[i][2];
    return 0.5 * mass * sum;
  }

  double energy() const { return kinetic_energy() + potential; }

  void print_thermo() const {
    std::fprintf(thermo_file, "%8ld %12.6f %14.8f %14.8f %12.6f\n", step_number, temperature(), potential / natoms,
                 energy() / natoms, pressure());
  }

  // xyz, wrapped into the box for the eye only.
  bool write_xyz(const std::string& path) const {
    std::FILE* file = std::fopen(path.c_str(), "w");
    if (!file) return false;
    std::fprintf(file, "%d\nstep %ld, box %.9g\n", natoms, step_number, box);
    for (int i = 0; i < natoms; ++i)
      std::fprintf(file, "Ar %.9g %.9g %.9g\n", wrapped(x[i][0]), wrapped(x[i][1]), wrapped(x[i][2]));
    return std::fclose(file) == 0;
  }

 private:
  // ---- cell list ---------------------------------------------------------------------------------------------------
  int cells = 0;  // along one side
  int* head = nullptr;
  int* next = nullptr;

  static void stop(const std::string& what) { throw std::runtime_error("molecular dynamics: " + what); }

  static void* grab(std::size_t count, std::size_t size) {
    void* p = std::calloc(count, size);
    if (!p) throw std::bad_alloc();
    return p;
  }

  void allocate(int n) {
    natoms = n;
    const std::size_t count = static_cast<std::size_t>(n);
    x = static_cast<double(*)[3]>(grab(count, sizeof *x));
    v = static_cast<double(*)[3]>(grab(count, sizeof *v));
    f = static_cast<double(*)[3]>(grab(count, sizeof *f));
    next = static_cast<int*>(grab(count, sizeof *next));
    box = std::cbrt(n / density);
  }

  // A simple cubic lattice, each atom a little off its site.
  void set_lattice() {
    int side = 1;
    while (side * side * side < natoms) ++side;
    const double a = box / side;
    std::uint32_t seed = 12345;
    for (int i = 0; i < natoms; ++i) {
      x[i][0] = (i % side + 0.1 * random(seed)) * a;
      x[i][1] = (i / side % side + 0.1 * random(seed)) * a;
      x[i][2] = (i / side / side + 0.1 * random(seed)) * a;
    }
  }

  // Random velocities without a drift of the whole, scaled to the temperature.
  void set_velocities(std::uint32_t seed) {
    double drift[3] = {0.0, 0.0, 0.0};
    for (int i = 0; i < natoms; ++i) {
      for (int k = 0; k < 3; ++k) {
        v[i][k] = random(seed) - 0.5;
        drift[k] += v[i][k] / natoms;
      }
    }
    for (int i = 0; i < natoms; ++i)
      for (int k = 0; k < 3; ++k) v[i][k] -= drift[k];
    const double scale = std::sqrt(temperature0 / temperature());
    for (int i = 0; i < natoms; ++i)
      for (int k = 0; k < 3; ++k) v[i][k] *= scale;
  }

  static double random(std::uint32_t& seed) {
    seed = 1664525u * seed + 1013904223u;
    return seed / 4294967296.0;
  }

  void set_cells() {
    cells = static_cast<int>(box / cutoff);
    if (cells < 3) return;
    head = static_cast<int*>(
        grab(static_cast<std::size_t>(cells) * static_cast<std::size_t>(cells * cells), sizeof *head));
  }

  double wrapped(double s) const { return s - box * std::floor(s / box); }

  int cell_of(double s) const {
    const int c = static_cast<int>(wrapped(s) / box * cells);
    return c < cells ? c : cells - 1;
  }

  void sort_into_cells() {
    const int count = cells * cells * cells;
    for (int c = 0; c < count; ++c) head[c] = -1;
    for (int i = natoms - 1; i >= 0; --i) {
      const int c = (cell_of(x[i][2]) * cells + cell_of(x[i][1])) * cells + cell_of(x[i][0]);
      next[i] = head[c];
      head[c] = i;
    }
  }

  // Each pair of cells once: the cell itself and 13 of its 26 neighbours.
  void forces_by_cells() {
    for (int cz = 0; cz < cells; ++cz)
      for (int cy = 0; cy < cells; ++cy)
        for (int cx = 0; cx < cells; ++cx) {
          const int here = (cz * cells + cy) * cells + cx;
          for (int i = head[here]; i >= 0; i = next[i])
            for (int j = next[i]; j >= 0; j = next[j]) add_pair(i, j);
          for (int n = 14; n < 27; ++n) {
            const int nx = (cx + n % 3 - 1 + cells) % cells;
            const int ny = (cy + n / 3 % 3 - 1 + cells) % cells;
            const int nz = (cz + n / 9 - 1 + cells) % cells;
            const int there = (nz * cells + ny) * cells + nx;
            for (int i = head[here]; i >= 0; i = next[i])
              for (int j = head[there]; j >= 0; j = next[j]) add_pair(i, j);
          }
        }
  }

  double minimum_image(double d) const { return d - box * std::nearbyint(d / box); }

  // 4 (r^-12 - r^-6), cut and shifted so that it is 0 at the cutoff.
  void add_pair(int i, int j) {
    const double dx = minimum_image(x[i][0] - x[j][0]);
    const double dy = minimum_image(x[i][1] - x[j][1]);
    const double dz = minimum_image(x[i][2] - x[j][2]);
    const double r2 = dx * dx + dy * dy + dz * dz;
    if (r2 >= cutoff * cutoff) return;
    const double s2 = 1.0 / r2, s6 = s2 * s2 * s2;
    const double c2 = 1.0 / (cutoff * cutoff), c6 = c2 * c2 * c2;
    const double push = 48.0 * s6 * (s6 - 0.5) * s2;
    f[i][0] += push * dx, f[i][1] += push * dy, f[i][2] += push * dz;
    f[j][0] -= push * dx, f[j][1] -= push * dy, f[j][2] -= push * dz;
    potential += 4.0 * s6 * (s6 - 1.0) - 4.0 * c6 * (c6 - 1.0);
    virial += push * r2;
  }
};

}  // namespace CODE

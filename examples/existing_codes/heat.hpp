/// @file
/// Heat in a plate as many codes have it: a raw double* of temperatures on a grid, conductivity from cell to cell,
/// a source, two walls of given temperature and two insulated ones, forward Euler by hand.
///
/// Without WITH_PHISTEP this is the code as it was. With it, the lines below #ifdef WITH_PHISTEP replace the loop: the
/// difference is what an existing code has to change. Included once for each, in a namespace of its own (CODE); the
/// probe alone is not part of such a code: tests put their faults there.
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <functional>
#include <new>
#include <stdexcept>
#include <string>
#ifdef WITH_PHISTEP
#include <phistep/in_place.hpp>
#endif

namespace CODE {

// rho c du/dt = d/dx (k du/dx) + d/dy (k du/dy) + q on the unit square. West wall: u = u_west, east wall: u = u_east,
// south and north walls: insulated. Unknowns are the temperatures in the middle of nx times ny cells.
class HeatPlate {
 public:
  int nx = 0, ny = 0, ncells = 0;
  double hx = 0.0, hy = 0.0;  // sides of a cell [m]
  double rho_c = 2.0;         // heat capacity [J/(m^3 K)]
  double u_west = 1.0;        // [K], above a reference
  double u_east = 0.0;
  double time = 0.0;               // [s]
  double* u = nullptr;             // temperature [K]
  double* dudt = nullptr;          // its rate [K/s]
  double* conductivity = nullptr;  // [W/(m K)]
  double* source = nullptr;        // [W/m^3]
  int report_every = 0;            // steps between lines of output, 0: none
  long step_number = 0;
  long force_calls = 0;         // calls of compute_rates
  std::function<void()> probe;  // from outside: called at the end of compute_rates

  explicit HeatPlate(int n) {
    allocate(n);
    set_conductivity();
    set_source();
    set_start();
  }
  HeatPlate(const HeatPlate&) = delete;
  HeatPlate& operator=(const HeatPlate&) = delete;
  ~HeatPlate() {
    delete[] u;
    delete[] dudt;
    delete[] conductivity;
    delete[] source;
    delete[] flux_x;
    delete[] flux_y;
  }

  // ---- time stepping -----------------------------------------------------------------------------------------------

  // Forward Euler.
  void run(int steps, double dt) {
    if (dt > largest_stable_step())
      std::fprintf(stderr, "heat: dt = %g is beyond the stable %g\n", dt, largest_stable_step());
    const double start = time;
#ifdef WITH_PHISTEP
    phistep::VectorInPlace state{phistep::places(u, ncells), phistep::places(dudt, ncells)};
    phistep::PhiStepper stepper{state, state.force([&] { compute_rates(); }), phistep::forward_euler};
    const auto watch = [&](double t, const auto&) {
      if (t > 0.0) after_step(start + t);
    };
    const auto done = phistep::integrate(stepper, state, {0.0, steps * dt}, phistep::fixed(dt), watch);
    if (!done) throw std::runtime_error(done.message());
#else
    for (int step = 0; step < steps; ++step) {
      compute_rates();
      for (int c = 0; c < ncells; ++c) u[c] += dt * dudt[c];
      after_step(start + (step + 1) * dt);
    }
#endif
  }

  void after_step(double t) {
    time = t;
    ++step_number;
    if (report_every > 0 && step_number % report_every == 0) report();
  }

  // Of forward Euler, from Gershgorin's circles.
  double largest_stable_step() const {
    double most = 0.0;
    for (int c = 0; c < ncells; ++c) most = std::fmax(most, conductivity[c]);
    return rho_c / (2.0 * most * (1.0 / (hx * hx) + 1.0 / (hy * hy)));
  }

  // ---- right-hand side ---------------------------------------------------------------------------------------------

  // Reads u, writes dudt: fluxes through the faces of the cells, then their balance.
  void compute_rates() {
    ++force_calls;
    compute_fluxes_x();
    compute_fluxes_y();
    balance();
    if (probe) probe();
  }

  // flux_x[j * (nx + 1) + i]: through the west face of cell (i, j), positive to the east.
  void compute_fluxes_x() {
    for (int j = 0; j < ny; ++j) {
      const double* row = u + row_start(j);
      const double* k = conductivity + row_start(j);
      double* flux = flux_x + static_cast<std::ptrdiff_t>(j) * (nx + 1);
      flux[0] = -k[0] * (row[0] - u_west) / (0.5 * hx);
      for (int i = 1; i < nx; ++i) flux[i] = -harmonic_mean(k[i - 1], k[i]) * (row[i] - row[i - 1]) / hx;
      flux[nx] = -k[nx - 1] * (u_east - row[nx - 1]) / (0.5 * hx);
    }
  }

  // flux_y[j * nx + i]: through the south face of cell (i, j), positive to the north; none through the walls.
  void compute_fluxes_y() {
    for (int i = 0; i < nx; ++i) flux_y[i] = flux_y[row_start(ny) + i] = 0.0;
    for (int j = 1; j < ny; ++j) {
      const double* here = u + row_start(j);
      const double* below = u + row_start(j - 1);
      const double* k_here = conductivity + row_start(j);
      const double* k_below = conductivity + row_start(j - 1);
      double* flux = flux_y + row_start(j);
      for (int i = 0; i < nx; ++i) flux[i] = -harmonic_mean(k_below[i], k_here[i]) * (here[i] - below[i]) / hy;
    }
  }

  void balance() {
    const double per_x = 1.0 / (hx * rho_c), per_y = 1.0 / (hy * rho_c), per_volume = 1.0 / rho_c;
    for (int j = 0; j < ny; ++j) {
      const double* fx = flux_x + static_cast<std::ptrdiff_t>(j) * (nx + 1);
      const double* south = flux_y + row_start(j);
      const double* north = flux_y + row_start(j + 1);
      const double* q = source + row_start(j);
      double* rate = dudt + row_start(j);
      for (int i = 0; i < nx; ++i)
        rate[i] = (fx[i] - fx[i + 1]) * per_x + (south[i] - north[i]) * per_y + q[i] * per_volume;
    }
  }

  // ---- output ------------------------------------------------------------------------------------------------------

  // Heat in the plate above the reference. [J per m of thickness]
  double heat() const {
    double sum = 0.0;
    for (int c = 0; c < ncells; ++c) sum += u[c];
    return rho_c * hx * hy * sum;
  }

  double hottest() const {
    double most = u[0];
    for (int c = 1; c < ncells; ++c) most = std::fmax(most, u[c]);
    return most;
  }

  // Heat that flows in through both walls and comes from the source, at the last call of compute_rates. [W per m]
  double heat_supply() const {
    double sum = 0.0;
    for (int j = 0; j < ny; ++j) {
      const double* flux = flux_x + static_cast<std::ptrdiff_t>(j) * (nx + 1);
      sum += hy * (flux[0] - flux[nx]);
    }
    for (int c = 0; c < ncells; ++c) sum += hx * hy * source[c];
    return sum;
  }

  // Far from the steady state this is large. [K/s]
  double largest_rate() const {
    double most = 0.0;
    for (int c = 0; c < ncells; ++c) most = std::fmax(most, std::fabs(dudt[c]));
    return most;
  }

  double at(int i, int j) const { return u[row_start(j) + i]; }

  void report() const { std::printf("t = %10.6f s: heat %12.8f J/m, hottest %10.6f K\n", time, heat(), hottest()); }

  // A portable grey map, 0 K black, the hottest cell white.
  bool write_picture(const std::string& path) const {
    std::FILE* file = std::fopen(path.c_str(), "w");
    if (!file) return false;
    const double scale = 255.0 / std::fmax(hottest(), 1e-300);
    std::fprintf(file, "P2\n%d %d\n255\n", nx, ny);
    for (int j = ny - 1; j >= 0; --j)
      for (int i = 0; i < nx; ++i)
        std::fprintf(file, "%d%c", static_cast<int>(scale * std::fmax(at(i, j), 0.0)), i + 1 < nx ? ' ' : '\n');
    return std::fclose(file) == 0;
  }

  // Temperatures and time, as they lie in memory.
  bool save(const std::string& path) const {
    std::FILE* file = std::fopen(path.c_str(), "wb");
    if (!file) return false;
    const std::size_t count = static_cast<std::size_t>(ncells);
    const bool good = std::fwrite(&time, sizeof time, 1, file) == 1 && std::fwrite(u, sizeof *u, count, file) == count;
    return std::fclose(file) == 0 && good;
  }

  bool load(const std::string& path) {
    std::FILE* file = std::fopen(path.c_str(), "rb");
    if (!file) return false;
    const std::size_t count = static_cast<std::size_t>(ncells);
    const bool good = std::fread(&time, sizeof time, 1, file) == 1 && std::fread(u, sizeof *u, count, file) == count;
    std::fclose(file);
    return good;
  }

 private:
  double* flux_x = nullptr;
  double* flux_y = nullptr;

  std::ptrdiff_t row_start(int j) const { return static_cast<std::ptrdiff_t>(j) * nx; }

  static double harmonic_mean(double a, double b) { return 2.0 * a * b / (a + b); }

  void allocate(int n) {
    nx = static_cast<int>(std::lround(std::sqrt(static_cast<double>(n))));
    ny = nx;
    if (nx < 2) throw std::invalid_argument("heat: at least 4 cells");
    ncells = nx * ny;
    hx = 1.0 / nx;
    hy = 1.0 / ny;
    const std::size_t count = static_cast<std::size_t>(ncells);
    u = new double[count]();
    dudt = new double[count]();
    conductivity = new double[count]();
    source = new double[count]();
    flux_x = new double[count + static_cast<std::size_t>(ny)]();
    flux_y = new double[count + static_cast<std::size_t>(nx)]();
  }

  // A poor conductor with a good one diagonally across it.
  void set_conductivity() {
    for (int j = 0; j < ny; ++j) {
      for (int i = 0; i < nx; ++i) {
        const double x = (i + 0.5) * hx, y = (j + 0.5) * hy;
        const double away = (x - y) / 0.2;
        conductivity[row_start(j) + i] = 0.2 + 0.8 * std::exp(-away * away);
      }
    }
  }

  // A heated spot.
  void set_source() {
    for (int j = 0; j < ny; ++j) {
      for (int i = 0; i < nx; ++i) {
        const double x = (i + 0.5) * hx - 0.7, y = (j + 0.5) * hy - 0.4;
        source[row_start(j) + i] = 5.0 * std::exp(-(x * x + y * y) / 0.02);
      }
    }
  }

  void set_start() {
    for (int j = 0; j < ny; ++j)
      for (int i = 0; i < nx; ++i) {
        const double x = (i + 0.5) * hx, y = (j + 0.5) * hy;
        u[row_start(j) + i] = (1.0 - x) * u_west + x * u_east + 0.3 * std::sin(3.0 * x) * std::cos(7.0 * y);
      }
  }
};

}  // namespace CODE

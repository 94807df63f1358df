/// @file
/// Implicit against explicit: a beam of bonded particles, clamped at one end, that bends under its weight and swings. What
/// is asked for is slow (how far the tip has sunk after half a swing), what limits explicit steps is fast: Δt < 2/ω, where
/// ω is that of neighbours against each other. Their ratio grows as the square of the length.
#include <phistep/particles/bodies/particles.hpp>
#include <phistep/phistep.hpp>
#include <phistep/sparse.hpp>

#include <cstdio>
#include <stdexcept>

#include "frontier.hpp"

namespace bench {
namespace {
using phistep::Particles;

/// length × 3 × 3 unit masses on a cubic lattice of edge 1, joined along its edges and the diagonals of its faces, k = 1.
struct Beam {
  int length;
  static constexpr int width = 3;
  /// By Gershgorin: every particle has at most 6 + 12 springs, of which a direction sees 2 + 8·½, and so do the others.
  [[nodiscard]] static double largest_frequency() { return std::sqrt(2 * (2 + 8 * 0.5)); }
  /// Of the lowest mode: ω = 1.875² √(EI/(ρA)) / length² with E ≈ 2 k per edge, ρ = 1 and a square section: I/A = w²/12.
  [[nodiscard]] double period() const { return 2 * M_PI * length * length / (3.516 * std::sqrt(2 * 9.0 / 12)); }
  [[nodiscard]] double end() const { return period() / 2; }
  [[nodiscard]] int particles() const { return length * width * width; }

  [[nodiscard]] Particles<double, 3> start() const {
    Eigen::Matrix3Xd r(3, particles());
    std::vector<std::uint8_t> held(static_cast<std::size_t>(r.cols()), 0);
    for (int i = 0; i < particles(); ++i) {
      r.col(i) << i / (width * width), i / width % width, i % width;
      held[static_cast<std::size_t>(i)] = i < width * width;
    }
    Particles<double, 3> beam{r};
    beam.set_still(held);
    return beam;
  }
  /// The weight sinks the tip by some 5 % of the length when it hangs still: g ω⁻² ≈ sag.
  [[nodiscard]] auto force() const {
    std::vector<phistep::Spring> springs;
    for (int i = 0; i < particles(); ++i)
      for (int j = i + 1; j < std::min(particles(), i + 2 * width * width); ++j) {
        const auto apart = [](int a, int b) { return std::abs(a - b); };
        const int dx = apart(i / (width * width), j / (width * width));
        const int dy = apart(i / width % width, j / width % width), dz = apart(i % width, j % width);
        const int square = dx * dx + dy * dy + dz * dz;
        if (square <= 2) springs.push_back({i, j, 1.0, std::sqrt(static_cast<double>(square))});
      }
    const double g = 0.05 * length * std::pow(2 * M_PI / period(), 2);
    return phistep::Gravity{Eigen::Vector3d{0, 0, -g}} + phistep::spring_network<3>(std::move(springs));
  }
  /// How far the end has sunk and drawn back, relative to the length.
  [[nodiscard]] Eigen::Vector2d observable(const Particles<double, 3>& y) const {
    const auto tip = y.r.rightCols(width * width).rowwise().mean().eval();
    return Eigen::Vector2d{tip.z() - (width - 1) / 2.0, tip.x() - (length - 1)} / length;
  }
};

struct Run {
  Eigen::Vector2d observed;
  double seconds = 0;
};

template <class Scheme>
Run run(const Beam& beam, Scheme scheme, int steps) {
  auto y = beam.start();
  const Stopwatch watch;
  phistep::PhiStepper stepper{y, beam.force(), scheme};
  const auto report = phistep::integrate(stepper, y, {0, beam.end()}, phistep::fixed(beam.end() / steps));
  const double seconds = watch.seconds();
  if (!report) return {Eigen::Vector2d::Constant(std::numeric_limits<double>::quiet_NaN()), seconds};
  return {beam.observable(y), seconds};
}

}  // namespace

void bonded(const Options& options, Table& table) {
  bool first = true;
  for (const int length : {20, 40, 80, 160}) {
    if (options.is_short && length > 20) break;
    const Beam beam{length};
    const double stable = 2 / Beam::largest_frequency();
    const int least = static_cast<int>(beam.end() / stable) + 1;
    // Verlet's error falls by 4 a halving: the reference is what it tends to.
    const Eigen::Vector2d coarse = run(beam, phistep::velocity_verlet, 2 * least).observed;
    const Eigen::Vector2d fine = run(beam, phistep::velocity_verlet, 4 * least).observed;
    const Eigen::Vector2d exact = fine + (fine - coarse) / 3;
    const double size = exact.norm();
    const auto error = [&](const Eigen::Vector2d& found) {
      return found.allFinite() ? (found - exact).norm() / size : std::numeric_limits<double>::infinity();
    };
    const std::string scene = std::to_string(length) + " long";
    std::printf("  %s: the tip sinks by %.4f of the length in %.4g; dt < %.2f; reference good to %.1e\n", scene.c_str(),
                -exact[0], beam.end(), stable, (fine - coarse).norm() / 3 / size);
    std::vector<Rung> rungs;
    const auto ladder = [&](const std::string& name, auto scheme, const std::vector<int>& counts) {
      for (const int steps : counts) {
        const Run answer = run(beam, scheme, steps);
        const double off = error(answer.observed);
        if (off < 0.3)
          rungs.push_back({name, beam.end() / steps, off, 0, {name, [beam, scheme, steps] {
                                                                return run(beam, scheme, steps).seconds;
                                                              }}});
        else
          std::printf("    %-18s dt = %.2e: %s, not timed\n", name.c_str(), beam.end() / steps,
                      std::isfinite(off) ? "error over 30 %" : "failed");
        if (answer.seconds > 3) break;
      }
    };
    ladder("velocity Verlet", phistep::velocity_verlet, {3 * least / 4, least, 2 * least});
    ladder("trapezoidal", phistep::trapezoidal, {8, 16, 32, 64, 128, 256});
    ladder("TR-BDF2", phistep::tr_bdf2, {8, 16, 32, 64, 128});
    ladder("backward Euler", phistep::backward_euler, {32, 128, 512});
    take_turns(rungs, std::min(options.rounds, 3));  // differences here are large
    write_rungs(options, "bonded", scene, rungs, first);
    first = false;
    for (const double wanted : {1e-2, 1e-3})
      for (const char* method : {"velocity Verlet", "trapezoidal", "TR-BDF2", "backward Euler"})
        if (const auto seconds = time_to(wanted, method, rungs))
          table.add({"bonded", std::string(method) + ", " + scene, beam.particles(), 1,
                     "time to error " + as_text(wanted), "ms to an error of " + as_text(wanted), 1e3 * *seconds});
  }
}

}  // namespace bench

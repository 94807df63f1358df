// A chemical clock: the reaction of Belousov and Zhabotinskii, whose colours change every five minutes.
//
// Three concentrations swing over five decades, with rates up to 10⁵ times those of the swing: a stiff problem (Field & Noyes
// 1974; Hairer & Wanner, Solving ODEs II, sect. IV.10),
//
//     x' = s (y + x (1 − qx − y)),   y' = (z − (1 + x) y)/s,   z' = w (x − z),   s = 77.27, q = 8.375e-6, w = 0.161.
//
// First the library is asked which stepper to take. Then each of them runs one period and a bit, at one tolerance after the
// other, against the answer at t = 360 known to 17 digits: run time against error, the measure by which steppers are chosen.
// At last the advised one draws the clock by its dense output: few steps, and the curve between them.
//
// Run: oregonator [--short] [--out DIR]        Picture: python3 plot/plot_oregonator.py [DIR]
#include <phistep/advise.hpp>
#include <phistep/phistep.hpp>

#include <cmath>
#include <cstdio>
#include <ctime>
#include <iostream>

#include "command_line.hpp"

using Vec = Eigen::Vector3d;

struct Clock {
  static constexpr double s = 77.27, q = 8.375e-6, w = 0.161, end = 360;
  static Vec start() { return {1, 2, 3}; }
  static Vec exact() { return {1.00081487031852268, 1228.17852154988736, 132.055494284650450}; }
  Vec operator()(const Vec& y) const {
    return {s * (y[1] + y[0] * (1 - q * y[0] - y[1])), (y[2] - (1 + y[0]) * y[1]) / s, w * (y[0] - y[2])};
  }
  Eigen::Matrix3d jacobian(const Vec& y) const {
    return Eigen::Matrix3d{
        {s * (1 - 2 * q * y[0] - y[1]), s * (1 - y[0]), 0}, {-y[1] / s, -(1 + y[0]) / s, 1 / s}, {w, 0, -w}};
  }
};

int main(int argc, char** argv) {
  const CommandLine options(argc, argv);
  const auto wanted = [](double rtol) { return phistep::tolerance{.rtol = rtol, .atol = 1e-6 * rtol}; };
  std::cout << phistep::advise(Clock::start(), Clock{}, {0, Clock::end}, wanted(1e-6)) << '\n';

  std::printf("%-30s %8s %10s %8s %10s %10s\n", "scheme", "rtol", "error", "steps", "calls of f", "time [us]");
  auto table = options.file("oregonator_work.csv");
  table << "scheme,rtol,error,microseconds,steps\n";
  double radau_error = 1;
  const auto race = [&](const char* name, auto scheme, double tightest) {
    for (double rtol = 1e-2; rtol > 0.5 * tightest; rtol /= 10) {
      const int repeats = options.is_short ? 1 : 20;
      Vec y;
      phistep::RunReport report;
      const std::clock_t begin = std::clock();  // of the processor: what else runs does not count
      for (int k = 0; k < repeats; ++k) {
        y = Clock::start();
        phistep::PhiStepper stepper{y, Clock{}, scheme};
        report = phistep::integrate(stepper, y, {0, Clock::end}, wanted(rtol));
      }
      const double time = 1e6 * static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC / repeats;
      if (!report) CommandLine::stop(report.message());
      const double error = ((y - Clock::exact()).array() / Clock::exact().array()).abs().maxCoeff();
      if (rtol <= 1e-9) radau_error = error;
      std::printf("%-30s %8.0e %10.1e %8lld %10lld %10.1f\n", name, rtol, error,
                  static_cast<long long>(report.statistics.steps),
                  static_cast<long long>(report.statistics.force_calls), time);
      table << name << ',' << rtol << ',' << error << ',' << time << ',' << report.statistics.steps << '\n';
    }
  };
  race("tr_bdf2", phistep::tr_bdf2, options.is_short ? 1e-4 : 1e-6);
  race("rodas4", phistep::rodas4, 1e-7);
  race("rodas5p", phistep::rodas5p, 1e-8);
  race("radau", phistep::radau, 1e-10);

  Vec y = Clock::start();
  phistep::PhiStepper stepper{y, Clock{}, phistep::radau};
  auto curve = options.file("oregonator_curve.csv"), steps = options.file("oregonator_steps.csv");
  curve << "t,x,y,z\n", steps << "t,x,y,z\n";
  const auto write = [](auto& file) {
    return [&file](double t, const Vec& at) { file << t << ',' << at[0] << ',' << at[1] << ',' << at[2] << '\n'; };
  };
  std::cout << '\n'
            << phistep::integrate(stepper, y, {0, Clock::end}, wanted(1e-6), phistep::sampled(0.1, write(curve)),
                                  write(steps));
  return radau_error < 1e-7 ? 0 : 1;
}

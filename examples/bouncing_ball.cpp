// A ball dropped on the floor, bounce after bounce, until time itself can't tell them apart.
//
// A bounce is an event: the height passes zero while it falls. The run steps exactly there, the handler turns the velocity
// round and takes a tenth of it, and the run goes on. Dropped from H, the ball meets the floor for the k-th time at
//
//     t_k = √(2H/g) (1 + 2(e + e² + … + e^(k−1))),   so infinitely often before   T = √(2H/g) (1+e)/(1−e)  (Zeno's time).
//
// No Δt is small enough for that. The run notices, stops just before T and says so; a handler that lets the ball rest ends
// it earlier. φ = ½ is exact for a parabola, so the step may be as long as you like: only the bounces are work.
//
// Run: bouncing_ball [--short] [--out DIR]        Picture: python3 plot/plot_bouncing_ball.py [DIR]
#include <phistep/phistep.hpp>

#include <cmath>
#include <cstdio>

#include "command_line.hpp"

using Vec = Eigen::Vector2d;
using Ball = phistep::Motion<Vec>;

int main(int argc, char** argv) {
  const CommandLine options(argc, argv);
  const double H = 1, g = 9.81, e = 0.9, m = 0.2;  // [m] [m/s²] [–] [kg]
  const double drop = std::sqrt(2 * H / g), zeno = drop * (1 + e) / (1 - e);
  const auto height = [](const Ball& now) { return now.r.y(); };
  bool as_expected = true;

  // 1. Thrown along, and followed to the end. The path is sampled for the picture, by interpolation: no step is added.
  auto path = options.file("bouncing_ball_path.csv");
  path << "t_s,x_m,y_m\n";
  Ball ball{Vec{0, H}, Vec{0.3, 0}};
  phistep::PhiStepper stepper{ball, phistep::Gravity{Vec{0, -g}}, phistep::trapezoidal, phistep::mass(m)};
  auto bounce =
      phistep::event(height, {.direction = phistep::Direction::falling}, [=](double, Ball& now) { now.v.y() *= -e; });
  auto draw = phistep::sampled(options.is_short ? 0.02 : 0.002, [&](double t, const Ball& now) {
    path << t << ',' << now.r.x() << ',' << now.r.y() << '\n';
  });
  const auto report = phistep::integrate(stepper, ball, {0, 20}, phistep::fixed(0.5), bounce, draw);

  auto times = options.file("bouncing_ball_times.csv");
  times.precision(17);
  times << "bounce,t_s,formula_s\n";
  std::printf("Dropped from %g m, e = %g, dt = 0.5 s\n\n%6s %22s %22s %10s\n", H, e, "bounce", "t [s]", "formula [s]",
              "error [s]");
  double formula = drop, flight = 2 * drop, worst = 0;
  int k = 0;
  for (const double t : bounce.times()) {
    worst = std::max(worst, std::abs(t - formula));
    times << ++k << ',' << t << ',' << formula << '\n';
    if (k <= 5 || k % 50 == 0) std::printf("%6d %22.15f %22.15f %10.1e\n", k, t, formula, t - formula);
    formula += flight *= e;
  }
  std::printf("\n%d bounces, the worst is %.1e s off. Zeno's time is %.12f s; the run ended %.1e s before:\n%s\n", k,
              worst, zeno, zeno - report.t, report.message().c_str());
  as_expected = as_expected && report.outcome == phistep::Outcome::events_accumulate && k > 200 && worst < 1e-12 &&
                std::abs(zeno - report.t) < 1e-10;

  // 2. The same with a handler that calls 1 mm/s rest, and steps chosen by their error.
  ball = {Vec{0, H}, Vec{0.3, 0}};
  auto until_rest = phistep::event(height, {.direction = phistep::Direction::falling}, [=](double, Ball& now) {
    now.v.y() *= -e;
    return now.v.y() > 1e-3;
  });
  const auto rest =
      phistep::integrate(stepper, ball, {0, 20}, phistep::tolerance{.rtol = 1e-6, .atol = 1e-9}, until_rest);
  const auto wanted = static_cast<std::size_t>(std::ceil(std::log(1e-3 / (g * drop)) / std::log(e)));
  std::printf("\nAt rest below 1 mm/s after %zu bounces (%zu by the formula), t = %.9f s, x = %.9f m:\n%s\n",
              until_rest.times().size(), wanted, rest.t, ball.r.x(), rest.message().c_str());
  as_expected = as_expected && rest.outcome == phistep::Outcome::stopped_by_event &&
                until_rest.times().size() == wanted && std::abs(ball.r.x() - 0.3 * rest.t) < 1e-12;
  if (!as_expected) std::printf("\nThis is not what the formulas say.\n");
  return as_expected ? 0 : 1;
}

// Runs whose options are any numbers at all: refused with a typed error, or ended with an outcome that is true.
#include <phistep/phistep.hpp>

#include <initializer_list>
#include <stdexcept>
#include <vector>

#include "fuzz/fuzz.hpp"

using namespace phistep;
using fuzz::Bytes;
using fuzz::demand;
using Vec = Eigen::VectorXd;

namespace {

struct Decay {
  double rate;
  Vec operator()(const Vec& y, double t) const { return -rate * y + Vec::Constant(y.size(), std::sin(t)); }
};
struct Swing {
  double stiffness;
  Vec operator()(const Vec& r) const { return -stiffness * r.array().sin().matrix(); }
};

/// A number that an option may have: as it should be, or anything.
double option(Bytes& in, double low, double high) { return in.below(4) == 0 ? in.wild() : in.scaled(low, high); }
std::int64_t cap(Bytes& in) { return in.below(16) == 0 ? -std::int64_t{in.byte()} : in.byte(); }
AbsoluteTolerance absolute(Bytes& in) {
  switch (in.below(5)) {
    case 0:
      return option(in, 1e-9, 1e-2);
    case 1:
      return {option(in, 1e-9, 1e-2), option(in, 1e-9, 1e-2)};
    case 2: {
      std::vector<double> each;
      for (int k = in.below(6); k > 0; --k) each.push_back(option(in, 1e-9, 1e-2));
      return each;
    }
    case 3:
      return {option(in, 1e-9, 1e-2), 1e-3, 1e-3, 1e-3, 1e-3, 1e-3};
    default:
      return {};
  }
}
tolerance error_control(Bytes& in) {
  tolerance wanted{.rtol = option(in, 1e-12, 0.5), .atol = absolute(in)};
  const int set = in.byte();
  if (set & 1) wanted.norm = Norm::particle;
  if (set & 2) wanted.filter = static_cast<StepFilter>(in.below(4));
  if (set & 4) wanted.first_step = option(in, 1e-6, 10);
  if (set & 8) wanted.min_step = option(in, 1e-9, 1);
  if (set & 16) wanted.max_step = option(in, 1e-3, 10);
  wanted.max_steps = cap(in);
  return wanted;
}
iteration_control iterations(Bytes& in) {
  iteration_control wanted{.first_step = option(in, 1e-3, 1)};
  const int set = in.byte();
  if (set & 1) wanted.desired = in.below(20) - 2;
  if (set & 2) wanted.order = option(in, 0.5, 3);
  if (set & 4) wanted.min_step = option(in, 1e-9, 1);
  if (set & 8) wanted.max_step = option(in, 1e-3, 10);
  wanted.max_steps = cap(in);
  return wanted;
}
NewtonOptions newton_options(Bytes& in) {
  if (in.flag()) return {};
  return {.rtol = option(in, 1e-9, 1e-2),
          .atol = option(in, 1e-9, 1e-2),
          .max_iterations = in.below(40) - 3,
          .line_search = in.flag()};
}
std::vector<double> times(Bytes& in, const TimeSpan<double>& span) {
  std::vector<double> all;
  for (int k = in.below(8); k > 0; --k)
    all.push_back(in.below(8) == 0 ? in.wild() : in.below(8) == 0 ? span.t1 : in.between(span.t0 - 0.1, span.t1 + 0.1));
  return all;
}

/// One run, and what must be true of it however it ends.
template <class State, class Stepper, class Control, class... More>
void end(Stepper& stepper, State y, const TimeSpan<double>& span, const Control& control, std::int64_t most, Bytes& in,
         More&&... more) {
  // Someone who edits or stops.
  const int whim = in.below(16);
  int seen = 0;
  double last = span.t0;
  const auto meddle = [&](double t, State& now) {
    demand(span.t1 >= span.t0 ? t >= last && t <= span.t1 : t <= last && t >= span.t1, "time goes on, and not too far");
    last = t;
    ++seen;
    if (whim == 1 && seen == 3) std::get<0>(Blocks<State>::all(now))[0] = in.wild();
    return whim != 2 || seen < 4;
  };
  const RunReport report = integrate(stepper, y, span, control, meddle, more...);
  demand(report.statistics.steps <= std::max<std::int64_t>(most, 0), "no more steps than were allowed");
  if (report) demand(report.t == span.t1, "success is at the end");
  demand(!report.message().empty(), "a report has its message");
  demand(report.smallest_dt <= report.largest_dt && report.smallest_dt >= 0, "steps have lengths");
  if (whim != 1 && report.outcome != Outcome::non_finite_state)
    for_each_block([](auto, const auto& block) { demand(block.allFinite(), "what a run reached is finite"); },
                   Blocks<State>::all(y));
}

void run(Bytes& in) {
  const int which = in.below(5);
  TimeSpan<double> span{in.number(-3, 3), in.number(-3, 3)};
  const Eigen::Index n = 1 + in.below(3);
  Vec y(n), v(n);
  for (double& x : y) x = in.number(-2, 2);
  for (double& x : v) x = in.number(-2, 2);
  Motion<Vec> state{y, v};
  const Decay decay{option(in, 1e-2, 1e6)};
  const Swing swing{option(in, 1e-2, 1e3)};
  const double level = in.number(-2, 2);
  const auto crossing = [&](auto value) {
    const EventOptions how{static_cast<Direction>(in.below(3) - 1), in.flag(), in.flag()};
    return event(value, how);
  };
  switch (which) {
    case 0: {
      PhiStepper stepper{y, decay, tr_bdf2, newton(newton_options(in))};
      const tolerance control = error_control(in);
      auto g = crossing([level](const Vec& at) { return at[0] - level; });
      return end(stepper, y, span, control, control.max_steps, in, at_times(times(in, span), [](double, const Vec&) {}),
                 g);
    }
    case 1: {
      PhiStepper stepper{y, decay, radau};
      const tolerance control = error_control(in);
      return end(stepper, y, span, control, control.max_steps, in);
    }
    case 2: {
      PhiStepper stepper{state, swing, velocity_verlet};
      const auto control = fixed(option(in, 1e-3, 10), {.max_steps = cap(in)});
      auto g = crossing([level](double t, const Motion<Vec>& at) { return at.r[0] - level * t; });
      const auto nothing = [](double, const Motion<Vec>&) {};
      return end(stepper, state, span, control, control.options.max_steps + 1000, in,
                 at_times(times(in, span), nothing), g, every(option(in, 1e-3, 1), nothing));
    }
    case 3: {
      PhiStepper stepper{state, swing, trapezoidal,
                         fixed_point({.rtol = option(in, 1e-9, 1e-2),
                                      .atol = option(in, 1e-9, 1e-2),
                                      .max_iterations = in.below(40) - 3,
                                      .depth = in.below(8) - 1})};
      const iteration_control control = iterations(in);
      return end(stepper, state, span, control, control.max_steps, in);
    }
    default: {
      PhiStepper stepper{state, swing, phi(in.number(0, 1))};
      const SmallerOf control = smaller_of(error_control(in), iterations(in));
      const double interval = std::max(std::abs(span.t1 - span.t0) / 100, 1e-3);
      return end(stepper, state, span, control, std::min(control.error.max_steps, control.iterations.max_steps), in,
                 sampled(interval, [](double, const Motion<Vec>&) {}));
    }
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  Bytes in(data, size);
  try {
    run(in);
  } catch (const std::invalid_argument&) {
  }
  return 0;
}

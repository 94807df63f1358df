// Force graphs out of bytes, under any of a dozen schemes, with failures, edits and restarts between the steps. Everything
// is done twice: the same bits. What fails leaves the state as it was, what succeeds is finite, counts only grow.
#include <phistep/phistep.hpp>

#include <stdexcept>
#include <string>
#include <vector>

#include "fuzz/fuzz.hpp"

using namespace phistep;
using fuzz::Bytes;
using fuzz::demand;
using Vec = Eigen::VectorXd;

namespace {

/// At which call a force fails, and how.
struct Trouble {
  int calls = 0, at = -1, kind = 0;
  struct Thrown {};
  void meet(Vec& f) {
    if (calls++ != at) return;
    if (kind == 0) throw Thrown{};
    f[0] = kind == 1 ? std::nan("") : HUGE_VAL;
  }
};

/// A sum of terms among up to five unknowns.
class Graph {
  struct Term {
    int kind;
    Eigen::Index i, j;
    double a, b;
  };

 public:
  Graph(Bytes& in, Eigen::Index n, Trouble& trouble) : trouble_{&trouble} {
    for (int k = in.below(7); k > 0; --k)
      terms_.push_back({in.below(10), in.below(100) % n, in.below(100) % n, in.number(-3, 3), in.number(-2, 2)});
  }
  [[nodiscard]] Vec at(const Vec& r, const Vec& v, double t) const {
    Vec f = Vec::Zero(r.size());
    for (const auto& [kind, i, j, a, b] : terms_) {
      const double d = r[j] - r[i];
      switch (kind) {
        case 0:
          f[i] += a * d, f[j] -= a * d;
          break;  // spring
        case 1:
          f[i] -= a * v[i];
          break;  // drag
        case 2:
          f[i] += a;
          break;  // gravity
        case 3:
          f[i] -= a * r[i] * r[i] * r[i];
          break;  // stiffens
        case 4:
          f[i] += a * std::sin(b * t);
          break;  // drive
        case 5:
          f[i] += a / (d * d);
          break;  // singular
        case 6:
          f[i] -= 1e6 * std::abs(a) * (r[i] - b);
          break;  // stiff
        case 7:
          f[i] += a * std::sqrt(r[i] - b);
          break;  // undefined on one side
        case 8:
          f[i] += r[i] > b ? a : -a;
          break;  // jumps
        default:
          f[i] += std::exp(a * r[i]);  // explodes
      }
    }
    trouble_->meet(f);
    return f;
  }

 private:
  std::vector<Term> terms_;
  Trouble* trouble_;
};
struct OfState {
  Graph graph;
  Vec operator()(const Vec& y, double t) const { return graph.at(y, y, t); }
};
struct OfMotion {
  Graph graph;
  Vec operator()(const Vec& r, const Vec& v, double t) const { return graph.at(r, v, t); }
};
struct OfPosition {
  Graph graph;
  Vec operator()(const Vec& r) const { return graph.at(r, r, 0); }
};

using Log = std::vector<double>;
void tell(Log& log, const Vec& y) { log.insert(log.end(), y.begin(), y.end()); }
void tell(Log& log, const Motion<Vec>& y) { tell(log, y.r), tell(log, y.v); }
double* some_number(Vec& y, Bytes& in) { return &y[in.below(100) % y.size()]; }
double* some_number(Motion<Vec>& y, Bytes& in) { return some_number(in.flag() ? y.r : y.v, in); }
void check_counts(const Statistics& now, const Statistics& before) {
  const Statistics more = now - before;
  demand(more.steps >= 0 && more.force_calls >= 0 && more.jacobians >= 0 && more.factorizations >= 0 &&
             more.solves >= 0 && more.iterations >= 0 && more.linear_iterations >= 0,
         "counts grow");
}

/// What a step did: an outcome, or 100 where the force threw.
template <class Stepper, class State>
double step(Stepper& stepper, State& y, double t, double dt) {
  Log before, after;
  tell(before, y);
  double did = 100;
  try {
    const StepReport report = stepper.step(y, t, dt);
    did = static_cast<double>(report.outcome());
    if (!report) demand(report.message().size() > 20, "a failure has its message");
  } catch (const Trouble::Thrown&) {
  }
  tell(after, y);
  if (did != 0) demand(fuzz::same_bits(before, after), "a failed step changes nothing");
  else
    for (const double x : after) demand(std::isfinite(x), "what succeeds is finite");
  return did;
}

template <class State, class Make>
Log play(Bytes in, State y, Trouble& trouble, Make make) {
  trouble = {};
  Log log;
  auto stepper = make(y);
  double t = in.number(-2, 2);
  std::int64_t tries = 0;
  bool after_failure = false;
  for (int k = 0; k < 8; ++k) {
    const int what = in.below(16);
    if (what == 0) *some_number(y, in) = in.wild();
    if (what == 1) *some_number(y, in) = in.between(-1, 1);
    if (what == 2) stepper.reset();
    if (what == 3) trouble.at = trouble.calls + in.below(12), trouble.kind = in.below(3);
    const double dt = in.below(4) == 0 ? in.number(-1, 1) : in.scaled(1e-3, 1);
    const Statistics before = stepper.statistics();
    // After a failure some schemes still know the Jacobian there, which a restart works out again: nothing is promised then.
    const bool restarts = what == 4 && !after_failure;
    auto restarted = make(y);
    State there = y;
    if (restarts) {  // a restart here goes on in the same way
      Writer out;
      out.save(stepper);
      if constexpr (HasUnsaved<decltype(stepper)>) stepper.forget_unsaved();
      Reader read{out.bytes()};
      read.load(restarted);
      demand(restarted.statistics() == before, "a restart knows the counts");
    }
    const Trouble trouble_before = trouble;
    const double did = step(stepper, y, t, dt);
    log.push_back(did);
    tell(log, y);
    tries += did != 100;
    check_counts(stepper.statistics(), before);
    demand(stepper.statistics().steps + stepper.statistics().failed_steps == tries, "every step counts");
    if (restarts) {
      trouble = trouble_before;
      Log one, two;
      demand(step(restarted, there, t, dt) == did, "a restart has the same outcome");
      tell(one, y), tell(two, there);
      demand(fuzz::same_bits(one, two), "a restart has the same bits");
      demand(after_failure || restarted.statistics() == stepper.statistics(), "a restart has the same counts");
    }
    after_failure = did != 0;
    if (did == 0) t += dt;
  }
  return log;
}

template <class State, class Make>
void twice(const Bytes& in, const State& y, Trouble& trouble, Make make) {
  const Log one = play(in, y, trouble, make), two = play(in, y, trouble, make);
  demand(fuzz::same_bits(one, two), "twice is the same");
}

void run(Bytes& in) {
  const int which = in.below(14);
  const Eigen::Index n = 1 + in.below(5);
  const auto vector = [&] {
    Vec x(n);
    for (double& one : x) one = in.number(-2, 2);
    return x;
  };
  Trouble trouble;
  const Vec y = vector();
  const Graph graph(in, n, trouble);
  if (which < 8) {
    const OfState f{graph};
    const double x = in.number(0, 1);
    const auto play_with = [&](auto scheme) {
      twice(in, y, trouble, [&](const Vec& s) { return PhiStepper{s, f, scheme}; });
    };
    switch (which) {
      case 0:
        return play_with(forward_euler);
      case 1:
        return play_with(phi(x));
      case 2:
        return play_with(midpoint);
      case 3:
        return play_with(tr_bdf2);
      case 4:
        return play_with(rodas4);
      case 5:
        return play_with(radau);
      case 6:
        return play_with(dop853);
      default:
        return play_with(rannacher);
    }
  }
  const Motion<Vec> state{y, vector()};
  const OfMotion f{graph};
  const double m = in.number(0.1, 3), x = in.number(0, 1), z = in.number(0, 1);
  const auto play_with = [&](auto... more) {
    twice(in, state, trouble, [&](const Motion<Vec>& s) { return PhiStepper{s, f, more...}; });
  };
  switch (which) {
    case 8:
      return play_with(velocity_verlet, mass(m));
    case 9:
      return play_with(phi(x, z), mass(m));
    case 10:
      return play_with(trapezoidal, fixed_point({.depth = in.below(4)}));
    case 11:
      return play_with(radau, mass(m));
    case 12:
      return twice(in, state, trouble, [&](const Motion<Vec>& s) { return PhiStepper{s, OfPosition{graph}, rkn86}; });
    default:
      return twice(in, state, trouble, [&](const Motion<Vec>& s) {
        return Halving{PhiStepper{s, f, backward_euler}, 3};
      });
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  Bytes in(data, size);
  try {
    run(in);
  } catch (const std::invalid_argument&) {  // φ or a mass that can't be
  }
  return 0;
}

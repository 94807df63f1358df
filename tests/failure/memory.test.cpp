// Every allocation of a run fails once: std::bad_alloc, nothing half done, nothing leaked. the stress tier does more.
#include "failure/hunger.hpp"

using namespace hunger;
using Vec = Eigen::VectorXd;

namespace memory_cases {

struct Damped {
  Vec operator()(const Vec& r, const Vec& v, double t) const { return states::DampedPull{}(r, v, t); }
};
struct Still {
  Vec operator()(const Vec& r) const { return states::Pull{}(r); }
};
inline const auto motion = [] { return states::SecondOrder<Vec>{}.state; };
inline const auto verlet = [](auto& y) { return PhiStepper{y, Damped{}, velocity_verlet}; };
inline void check(const Tally& tally) {
  INFO(tally.first);
  CHECK(tally.runs > 100);
  CHECK(tally.changed == 0);
  CHECK(tally.untold == 0);
  CHECK(tally.stuck == 0);
  CHECK(tally.otherwise == 0);
}

}  // namespace memory_cases

#if PHISTEP_QUICK

using namespace memory_cases;

TEST_CASE("a run with an event and a recorder, saved and loaded, starved at every allocation") {
  const auto pulled = [](auto& y) { return PhiStepper{y, Still{}, velocity_verlet}; };
  const auto watched = [] { return std::tuple{Recorder<Motion<Vec>>{}}; };
  check(every_allocation("watched", machine(motion, pulled, 0.3, fixed(0.1), watched),
                         {.same_end = 1e-13, .moves_on = true}));
}

TEST_CASE("a Recorder without memory keeps what it has") {
  Recorder<Vec> recorder;
  const Vec y = Vec::LinSpaced(5, 0, 1);
  int thrown = 0;
  for (int n = 0; n < 40; ++n) {
    const Index before = recorder.size();
    heap::count = 0, heap::fatal = n % 2, heap::lasting = true;  // for the times, or for the values
    const Act act = fed([&] { recorder(n, y); });
    heap::fatal = -1;
    thrown += act == Act::starved;
    CHECK(recorder.size() == before + (act == Act::done ? 1 : 0));
    for (Index k = 0; k < recorder.size(); ++k) CHECK((recorder.states().col(k) == y));
    if (act != Act::done) recorder(n, y);
  }
  CHECK(thrown > 2);
}

#elif PHISTEP_FULL

using namespace memory_cases;

TEST_CASE("a run with an event and a recorder, saved and loaded, starved at every allocation") {
  const auto watched = [] {
    return std::tuple{event([](const auto& y) { return y.r[0] - 0.35; }, {}, [](double, auto& y) { y.v[0] *= -0.9; }),
                      Recorder<Motion<Vec>>{}};
  };
  check(every_allocation("watched", machine(motion, verlet, 0.3, fixed(0.1), watched),
                         {.same_end = 1e-13, .moves_on = true}));
}

#elif PHISTEP_STRESS
// Runs that are starved of memory at every allocation, and particles whose forces fail at every call: neighbour lists and
// the history of friction are what they were.

//
#include <phistep/particles.hpp>
#include <phistep/sparse.hpp>

#include <string>
#include <vector>

#include "failure/group.hpp"

using namespace hunger;
using Vec = Eigen::VectorXd;

namespace {

auto with(auto f, auto... more) {
  return [=](auto& y) { return PhiStepper{y, f, more...}; };
}
const std::vector<Kind> numbers{Kind::nan, Kind::inf, Kind::exception};

struct Push : ForceTerm {  // beside other terms; spoils what they have added
  static constexpr bool uses_velocity = false, uses_time = false;
  void add(double, const auto&, auto& out) const {
    if (fault.strikes(Site::force)) out.force.data()[1] = fault.bad();
  }
};

const auto gas = [] {
  Eigen::Matrix3Xd r(3, 27), v(3, 27);
  for (Index k = 0; k < 27; ++k) {
    r.col(k) << 1.3 * static_cast<double>(k % 3), 1.3 * static_cast<double>(k / 3 % 3),
        1.3 * static_cast<double>(k / 9);
    for (int a = 0; a < 3; ++a) v(a, k) = 3 * std::sin(1.7 * static_cast<double>(3 * k + a));
  }
  Particles<double, 3> atoms{r, v};
  atoms.set_mass(2.0).set_box(Box<double, 3>::periodic({0, 0, 0}, {3.9, 3.9, 3.9}));
  return atoms;
};
const auto shower = [] {
  Eigen::Matrix3Xd r(3, 8), v(3, 8);
  for (Index k = 0; k < 8; ++k) {
    r.col(k) << 0.95 * static_cast<double>(k % 2), 0.95 * static_cast<double>(k / 2 % 2),
        0.48 + 0.95 * static_cast<double>(k / 4);
    for (int a = 0; a < 3; ++a) v(a, k) = 3 * std::sin(1.7 * static_cast<double>(3 * k + a));
  }
  Particles<double, 3, Spin> grains{r, v};
  grains.set_mass(1.0).set_radius(0.5).set_box({{0, 0, 0}, {6, 6, 6}, {true, true, false}});
  return grains;
};
auto rubbing() {
  const Hooke hooke{.stiffness = 1e4, .restitution = 0.6, .friction = 0.4, .rolling_friction = 0.1};
  return Contact{hooke} + Walls<Hooke>{hooke, Plane<3>{Eigen::Vector3d::Zero(), Eigen::Vector3d::UnitZ()}} +
         Gravity{Eigen::Vector3d{3, 0, -9}};
}

struct Damped {
  Vec operator()(const Vec& r, const Vec& v, double t) const { return states::DampedPull{}(r, v, t); }
};
struct Driven {
  Vec operator()(const Vec& y, double t) const { return states::DrivenPull{}(y, t); }
};
/// A sparse tangent whose pattern changes with the state.
struct Chain : ForceTerm {
  [[maybe_unused]] static constexpr Structure structure = Structure::sparse;
  static constexpr bool uses_velocity = false, uses_time = false;
  void add(double, const auto& view, auto& out) const {
    const auto& y = view.y;
    for (Index i = 0; i < y.size(); ++i)
      out.rate[i] += -y[i] - y[i] * y[i] * y[i] + (i > 0 ? std::max(0.0, y[i - 1]) : 0.0);
  }
  void add_jacobian(double, const auto& view, auto& sink) const {
    const auto& y = view.y;
    for (Index i = 0; i < y.size(); ++i) {
      sink.rate(i, i, -1 - 3 * y[i] * y[i]);
      if (i > 0 && y[i - 1] > 0) sink.rate(i, i - 1, 1);
    }
  }
};

}  // namespace

TEST_CASE("many particles: lists and friction are what they were") {
  Group group{"particles"};
  const auto law = [](auto r2) {
    using Number = decltype(r2);
    return fault.strikes(Site::solver) ? Number{1.0} * Number{fault.bad()} : Number{1.0} / (r2 * r2);
  };
  const auto lennard_jones = Pairs{LennardJones{}, 1.8, {.skin = 0.1}} + Push{};
  group.add("gas, Verlet", machine(gas, with(lennard_jones, velocity_verlet), 0.08, fixed(0.01)), Site::force, numbers,
            {.renewed = 1e-13});
  group.add("gas, trapezoidal", machine(gas, with(lennard_jones, trapezoidal), 0.04, fixed(0.01)), Site::force, numbers,
            {.same_end = 1e-12, .renewed = 1e-11});
  group.add("a law of the user's own",
            machine(gas, with(Pairs{law, 1.8, {.skin = 0.1}}, velocity_verlet), 0.04, fixed(0.01)), Site::solver,
            {Kind::exception}, {}, 37);

  const auto friction = rubbing() + Push{};
  group.add("grains, symplectic Euler", machine(shower, with(friction, symplectic_euler), 0.03, fixed(1e-3)),
            Site::force, numbers, {.renewed = 1e-12});
  group.add("grains, forward Euler", machine(shower, with(friction, forward_euler), 0.03, fixed(1e-3)), Site::force,
            numbers, {.renewed = 1e-12});
  group.add("grains, Verlet", machine(shower, with(friction, velocity_verlet), 0.01, fixed(1e-3)), Site::force, numbers,
            {.same_end = 1e-10, .renewed = 1e-10});
  group.tell();
}

TEST_CASE("every allocation of a run fails once") {
  auto starve = [all = Tally{}](const char* label, const Make& make, const Promise& promise,
                                bool with_checkpoints = true) mutable {
    figures::progress(label);
    const Tally one = every_allocation(label, make, promise, with_checkpoints);
    INFO(one.first);
    CHECK(one.clean());
    all += one;
    return all;
  };
  const auto motion = [] { return states::SecondOrder<Vec>{}.state; };
  const auto flow = [] { return states::FirstOrder<Vec>{}.state; };
  const auto watched = [] {
    return std::tuple{event([](const auto& y) { return y.r[0] - 0.35; }, {}, [](double, auto& y) { y.v[0] *= -0.9; }),
                      Recorder<Motion<Vec>>{}, at_times({0.15, 0.33}, [](double, const auto&) {}),
                      sampled(0.07, [](double, const auto&) {})};
  };
  const tolerance control{.rtol = 1e-3, .atol = 1e-4};
  starve("Verlet", machine(motion, with(Damped{}, velocity_verlet), 0.6, fixed(0.1)), {.same_end = 1e-14});
  starve("tolerance, trapezoidal", machine(flow, with(Driven{}, trapezoidal), 0.6, control), {.same_end = 1e-3});
  starve("tolerance, rodas4", machine(flow, with(Driven{}, rodas4), 0.6, control), {.same_end = 1e-3});
  starve("tolerance, Halving",
         machine(
             flow,
             [](auto& y) {
               return Halving{PhiStepper{y, Driven{}, backward_euler}, 2};
             },
             0.6, tolerance{.rtol = 1e-1, .atol = 1e-2}),
         {.same_end = 1e-2});
  starve("watched, fixed", machine(motion, with(Damped{}, velocity_verlet), 0.6, fixed(0.1), watched),
         {.same_end = 1e-12, .moves_on = true});
  starve("watched, tolerance", machine(motion, with(Damped{}, tr_bdf2), 0.6, control, watched),
         {.same_end = 2e-3, .moves_on = true});
  starve("gas", machine(gas, with(Pairs{LennardJones{}, 1.8, {.skin = 0.1}}, velocity_verlet), 0.06, fixed(0.01)), {});
  starve("grains", machine(shower, with(rubbing(), symplectic_euler), 0.012, fixed(1e-3)), {});
  const auto sleepy = [](auto& y) {
    return Sleeping{PhiStepper{y, rubbing(), symplectic_euler}, SleepOptions{.speed = 2, .steps = 3, .every = 2}};
  };
  starve("sleepers", machine(shower, sleepy, 0.012, fixed(1e-3)), {});
  heap::news_alone = true;  // Eigen 3.4's sparse classes don't look at what malloc returns
  const Tally all =
      starve("sparse", machine(flow, with(Chain{}, tr_bdf2), 0.6, fixed(0.1)), {.same_end = 1e-13, .leaks = true});
  heap::news_alone = false;

  INFO(all.first);
  figures::told(static_cast<double>(all.runs), "memory: runs with an allocation that fails", "runs");
  figures::at_most(0, static_cast<double>(all.untold), "memory: anything but std::bad_alloc", "runs");
  figures::at_most(0, static_cast<double>(all.changed), "memory: state or checkpoint changed by a failure", "runs");
  figures::at_most(0, static_cast<double>(all.stuck), "memory: could not go on", "runs");
  figures::at_most(0, static_cast<double>(all.otherwise), "memory: another end, or a block leaked", "runs");
}

#endif

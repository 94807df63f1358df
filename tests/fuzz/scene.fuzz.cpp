// Scenes out of bytes: refused by std::invalid_argument where they are set up or first seen, or stepped with an outcome.
#include <phistep/particles.hpp>

#include <Eigen/Geometry>

#include <stdexcept>
#include <vector>

#include "fuzz/fuzz.hpp"

using namespace phistep;
using fuzz::Bytes;
using fuzz::demand;

namespace {

template <int dim>
Eigen::Matrix<double, dim, 1> vector(Bytes& in, double low, double high) {
  Eigen::Matrix<double, dim, 1> x;
  for (int a = 0; a < dim; ++a) x[a] = in.number(low, high);
  return x;
}
template <class P>
P particles(Bytes& in) {
  constexpr int dim = P::dimensions;
  const int n = in.below(13), set = in.byte();
  typename P::Vectors r(dim, n), v(dim, n);
  for (int j = 0; j < n; ++j) r.col(j) = vector<dim>(in, 0, 4), v.col(j) = vector<dim>(in, -1, 1);
  P y{r, v};
  const auto column = [&](double low, double high) {
    typename P::Column x(n);
    for (int j = 0; j < n; ++j) x[j] = in.number(low, high);
    return x;
  };
  if (set & 1) y.set_mass(column(0.1, 2));
  if (set & 2) y.set_radius(column(0.2, 0.8));
  if (set & 4) {
    Eigen::VectorXi type(n);
    for (int j = 0; j < n; ++j) type[j] = in.below(5) - (in.below(32) == 0);
    y.set_type(type);
  }
  if (set & 8) y.set_charge(column(-1, 1));
  if (set & 16) {
    std::vector<std::uint8_t> still;
    for (int j = 0; j < n; ++j) still.push_back(in.byte() % 3 == 0);
    if (in.below(16) == 0) still.push_back(1);
    y.set_still(still);
  }
  if (set & 32) {
    Box<double, dim> box{vector<dim>(in, -1, 1), vector<dim>(in, 2, 6), {}};
    for (auto& periodic : box.is_periodic) periodic = in.flag();
    y.set_box(box);
  }
  if (set & 64) y.set_inertia_factor(in.number(0.1, 1));
  return y;
}
Hooke hooke(Bytes& in) {
  return {.stiffness = in.number(1, 1e4),
          .restitution = in.number(0.1, 1),
          .friction = in.number(0, 1),
          .rolling_friction = in.number(0, 0.3)};
}
Hertz hertz(Bytes& in) {
  return {.modulus = in.number(1, 1e4), .shear_modulus = in.number(0, 1e3), .restitution = in.number(0.1, 1)};
}
template <class Law>
Materials<Law> materials(Bytes& in, auto law) {
  const int types = in.below(4);
  Materials<Law> table = types == 0 ? Materials<Law>{law(in)} : Materials<Law>{types, law(in)};
  if (types > 1 && in.flag()) table.set(in.below(5) - 1, in.below(5), law(in));
  return table;
}
std::vector<Spring> springs(Bytes& in, Eigen::Index n) {
  std::vector<Spring> all;
  for (int k = in.below(12); k > 0; --k) {
    std::ptrdiff_t i = in.below(13) - (in.below(64) == 0), j = in.below(13);
    if (in.below(64) == 0) i = static_cast<std::ptrdiff_t>(in.word());
    if (in.below(8) != 0 && (n < 2 || i >= n || j >= n || i == j)) continue;
    all.push_back({i, j, in.number(0, 1e3), in.number(0, 2)});
  }
  return all;
}
std::vector<Wall<3>> walls(Bytes& in) {
  std::vector<Wall<3>> all;
  for (int k = in.below(4); k > 0; --k) {
    if (in.flag()) {
      all.push_back(Plane<3>{vector<3>(in, -1, 1), vector<3>(in, -1, 1), vector<3>(in, -1, 1), in.below(3)});
    } else {
      SolidBox<3> box{vector<3>(in, 0, 4), vector<3>(in, 0.1, 2)};
      if (in.flag()) box.axes = Eigen::AngleAxisd(in.number(0, 3), Eigen::Vector3d::UnitX()).toRotationMatrix();
      box.type = in.below(3);
      all.push_back(box);
    }
  }
  return all;
}

/// Steps, edits, adds and erases; what fails leaves every bit.
template <class P>
void go(Bytes& in, P y, auto make) {
  auto stepper = make(y);
  double t = in.number(-1, 1);
  for (int k = 0; k < 6; ++k) {
    const auto r = y.r, v = y.v;
    const double dt = in.number(1e-4, 0.05);
    const StepReport report = stepper.step(y, t, dt);
    if (report) {
      t += dt;
      demand(y.r.allFinite() && y.v.allFinite(), "what succeeds is finite");
    } else {
      demand(fuzz::same_bits(r, y.r) && fuzz::same_bits(v, y.v), "a failed step changes nothing");
      demand(!report.message().empty(), "a failure has its message");
    }
    demand(stepper.statistics().steps + stepper.statistics().failed_steps == k + 1, "every step counts");
    switch (in.below(10)) {
      case 0:
        y.add(particles<P>(in));
        break;
      case 1:
        if (y.size() > 0) y.erase(in.below(16) % y.size());
        break;
      case 2:
        if (y.size() > 0) y.r.col(0)[0] = in.wild();
        break;
      case 3:
        y.set_radius(in.number(0.2, 0.9));
        break;
      case 4:
        stepper.reset();
        break;
      default:
        break;
    }
  }
}

void scene(Bytes& in) {
  using Grains = Particles<double, 3, Spin>;
  using Atoms = Particles<double, 3>;
  const int kind = in.below(8);
  const auto gravity = [&in] { return Gravity{vector<3>(in, -10, 10)}; };
  switch (kind) {
    case 0:
    case 1: {
      const auto y = particles<Grains>(in);
      const auto law = materials<Hooke>(in, hooke);
      const auto force = Contact{law, in.number(0, 0.1)} + Walls<Hooke>{law, walls(in)} + gravity();
      if (kind == 0) return go(in, y, [&](const Grains& x) { return PhiStepper{x, force, symplectic_euler}; });
      const SleepOptions sleep{.speed = in.number(0, 1), .steps = in.below(5), .every = in.below(4)};
      return go(in, y, [&](const Grains& x) { return Sleeping{PhiStepper{x, force, symplectic_euler}, sleep}; });
    }
    case 2: {
      const auto y = particles<Atoms>(in);
      const auto law = materials<Hertz>(in, hertz);
      const auto force = Contact{law} + Walls<Hertz>{law, walls(in)} + gravity();
      return go(in, y, [&](const Atoms& x) { return PhiStepper{x, force, backward_euler}; });
    }
    case 3:
    case 4: {
      const auto y = particles<Atoms>(in);
      const Pairs force{LennardJones{in.number(0.1, 2), in.number(0.5, 1.5)},
                        in.number(0.5, 2.5),
                        {.skin = in.number(0, 0.5), .unchecked_every = in.below(4)}};
      if (kind == 3) return go(in, y, [&](const Atoms& x) { return PhiStepper{x, force, velocity_verlet}; });
      return go(in, y, [&](const Atoms& x) { return PhiStepper{x, force, trapezoidal}; });
    }
    case 5: {
      const auto y = particles<Atoms>(in);
      const auto force =
          spring_network<3>(springs(in, y.size()), {in.number(0, 1)}) + gravity() + LinearDrag{in.number(0, 1)};
      return go(in, y, [&](const Atoms& x) { return PhiStepper{x, force, midpoint}; });
    }
    case 6: {
      const auto y = particles<Particles<double, 2>>(in);
      const auto force = AllPairs{SoftenedGravity{in.number(0.1, 1), in.number(0, 0.5)}};
      return go(in, y, [&](const auto& x) { return PhiStepper{x, force, velocity_verlet}; });
    }
    default: {
      const auto y = particles<Particles<double, 2>>(in);
      const Pairs force{LennardJones{in.number(0.1, 2), in.number(0.5, 1.5)}, in.number(0.5, 2.5)};
      return go(in, y, [&](const auto& x) { return PhiStepper{x, force, symplectic_euler}; });
    }
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  Bytes in(data, size);
  try {
    scene(in);
  } catch (const std::invalid_argument&) {
  }
  return 0;
}

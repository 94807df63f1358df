#pragma once

// Symmetries of space and of names: particles turned, mirrored, shifted, set in motion and renamed move as they would have.

#include <phistep/particles.hpp>

#ifdef _OPENMP
#include <omp.h>
#endif

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <numeric>
#include <string>
#include <utility>
#include <vector>

#include "contract/property.hpp"
#include "contract/states.hpp"

namespace particles {

using namespace phistep;
using property::Source;
using Places = Eigen::Matrix3Xd;

constexpr double u = std::numeric_limits<double>::epsilon() / 2;

/// What moves.
struct Scene {
  enum Kind { all_pairs, short_pairs, springs, implicit_springs, contacts } kind;
  Places r, v;
  Eigen::VectorXd mass, radius;
  std::vector<Spring> bonds;
  double phi = 0.5;
  double dt = 0.01;
  int steps = 1;
};

/// The stage form goes on from a solve by 1/φ of its increment, and so do the roundings of the solve.
inline double amplification(const Scene& scene) { return scene.kind == Scene::implicit_springs ? 1 / scene.phi : 1; }

/// A smooth law that ends smoothly at 2.5, F/r ≤ 1.
inline constexpr auto soft = [](auto r2) {
  const auto x = 1.0 - r2 / 6.25;
  return x * x;
};

/// The motion of a scene; false where a step fails.
inline bool run(const Scene& scene, Places& r, Places& v, Statistics* counts = nullptr) {
  const auto go = [&](auto& y, auto stepper) {
    for (int n = 0; n < scene.steps; ++n)
      if (!stepper.step(y, n * scene.dt, scene.dt)) return false;
    r = y.r, v = y.v;
    if (counts != nullptr) *counts = stepper.statistics();
    return true;
  };
  if (scene.kind == Scene::contacts) {
    Particles<double, 3, Spin> grains{scene.r, scene.v};
    grains.set_mass(scene.mass).set_radius(scene.radius);
    const Hooke law{.stiffness = 30, .restitution = 0.7, .friction = 0.4};
    return go(grains, PhiStepper{grains, Contact{law}, symplectic_euler});
  }
  Particles<double, 3> y{scene.r, scene.v};
  y.set_mass(scene.mass);
  switch (scene.kind) {
    case Scene::all_pairs:
      return go(y, PhiStepper{y, AllPairs{SoftenedGravity{1.0, 0.5}}, velocity_verlet});
    case Scene::short_pairs:
      return go(y, PhiStepper{y, Pairs{soft, 2.5, {.skin = 0.4}}, velocity_verlet});
    case Scene::springs:
      return go(y, PhiStepper{y, spring_network<3>(scene.bonds), velocity_verlet});
    default:
      return go(y, PhiStepper{y, spring_network<3>(scene.bonds), phistep::phi_stage(scene.phi)});
  }
}

inline Scene draw_scene(Source& source, int most) {
  Scene scene;
  scene.kind = static_cast<Scene::Kind>(
      source.one_of("scene", {"all pairs", "short pairs", "springs", "implicit springs", "contacts"}));
  const int n = source.integer("particles", 2, most);
  // On a jittered grid: nobody sits on another, where directions have no meaning.
  const int across = std::max(2, static_cast<int>(std::ceil(std::cbrt(n))));
  const double jitter = scene.kind == Scene::contacts ? 0.02 : 0.2;
  scene.r.resize(3, n);
  scene.v.resize(3, n);
  const Eigen::VectorXd about = source.numbers("jitter", std::min(3 * n, 96), 1),
                        speeds = source.numbers("v", std::min(3 * n, 96), 1);
  for (Index i = 0; i < n; ++i)
    for (Index a = 0; a < 3; ++a) {
      const Index place = a == 0 ? i % across : a == 1 ? i / across % across : i / (across * across);
      const Index k = (3 * i + a) % about.size();
      scene.r(a, i) = 0.97 * static_cast<double>(place) + jitter * about[k];
      scene.v(a, i) = 0.5 * speeds[(k * 7) % about.size()];
    }
  scene.mass = Eigen::VectorXd::Ones(n);
  scene.radius = Eigen::VectorXd::Constant(n, 0.5);
  for (Index i = 0; i < n; ++i) scene.mass[i] += 0.25 * static_cast<double>(i % 3);
  const auto particle = [&] { return static_cast<std::ptrdiff_t>(source.below(static_cast<std::uint64_t>(n))); };
  if (scene.kind == Scene::springs || scene.kind == Scene::implicit_springs)
    for (int s = 0; s < std::min(2 * n, 60); ++s)
      if (const auto i = particle(), j = particle(); i != j)
        // Not where it is as long as at rest, nor compressed to nothing.
        scene.bonds.push_back({i, j, source.real("stiffness", 0, 2), source.real("length", 0, 1)});
  scene.phi = source.real("phi", 0.05, 1);
  scene.dt = source.real("dt", 0.0009765625, 0.03125);
  scene.steps = source.integer("steps", 1, 12);
  return scene;
}

/// x → Q x + c + w t, and names i → order[i].
struct Symmetry {
  Eigen::Matrix3d Q = Eigen::Matrix3d::Identity();
  Eigen::Vector3d shift = Eigen::Vector3d::Zero(), boost = Eigen::Vector3d::Zero();
  std::vector<Index> order;
};

inline Scene transformed(const Scene& scene, const Symmetry& by) {
  Scene other = scene;
  for (Index i = 0; i < scene.r.cols(); ++i) {
    const Index j = by.order[static_cast<std::size_t>(i)];
    other.r.col(j) = by.Q * scene.r.col(i) + by.shift;
    other.v.col(j) = by.Q * scene.v.col(i) + by.boost;
    other.mass[j] = scene.mass[i];
    other.radius[j] = scene.radius[i];
  }
  for (Spring& s : other.bonds) {
    s.i = by.order[static_cast<std::size_t>(s.i)];
    s.j = by.order[static_cast<std::size_t>(s.j)];
  }
  return other;
}
/// How far two scenes' ends are apart, once one is transformed.
inline double difference(const Scene& scene, const Symmetry& by, const Places& r, const Places& v,
                         const Places& other_r, const Places& other_v) {
  const double time = scene.dt * scene.steps;
  double worst = 0;
  for (Index i = 0; i < r.cols(); ++i) {
    const Index j = by.order[static_cast<std::size_t>(i)];
    const double x = (by.Q * r.col(i) + by.shift + time * by.boost - other_r.col(j)).cwiseAbs().maxCoeff();
    const double w = (by.Q * v.col(i) + by.boost - other_v.col(j)).cwiseAbs().maxCoeff();
    worst = std::max(worst, std::isnan(x + w) ? HUGE_VAL : std::max(x, w));
  }
  return worst;
}

inline std::vector<Index> identity(Index n) {
  std::vector<Index> order(static_cast<std::size_t>(n));
  std::iota(order.begin(), order.end(), Index{0});
  return order;
}

/// 3 and 4. Any of them at once: the motion is the same to rounding.
///
/// Each step rounds positions as large as |r| + |shift| + t|boost|, and adds up to n forces, n·u of their sum each. What
/// comes of it grows by e^{√K t} ≤ e (stiffness per mass ≤ n, at most 30 for contacts; t ≤ 0.4); a contact's friction
/// begins and ends with the sliding, which rounding may put off by a step of rounding's own size.
inline void symmetry(Source& source) {
  const Scene scene = draw_scene(source, 12);
  const Index n = scene.r.cols();
  Symmetry by;
  by.order = identity(n);
  if (source.flag("renamed"))
    for (std::size_t i = by.order.size() - 1; i > 0; --i) std::swap(by.order[i], by.order[source.below(i + 1)]);
  if (source.flag("turned")) {
    Eigen::Vector4d q = source.numbers("quaternion", 4, 1);
    if (q.norm() < 0.1) q = Eigen::Vector4d(1, 1, 0, 0);
    q.normalize();
    const double w = q[0], x = q[1], y = q[2], z = q[3];
    by.Q << 1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y), 2 * (x * y + w * z),
        1 - 2 * (x * x + z * z), 2 * (y * z - w * x), 2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y);
  }
  // A spin mirrors otherwise than a velocity; ours start from rest, so that nothing needs to know.
  if (source.flag("mirrored")) by.Q.row(0) *= -1;
  if (source.flag("shifted")) by.shift = source.numbers("shift", 3, 100);
  if (source.flag("boosted")) by.boost = source.numbers("boost", 3, 10);
  const Scene other = transformed(scene, by);
  Places r, v, other_r, other_v;
  source.require(run(scene, r, v), "a step fails");
  source.require(run(other, other_r, other_v), "a step fails once transformed");
  const double size = r.cwiseAbs().maxCoeff() + by.shift.cwiseAbs().maxCoeff() + by.boost.cwiseAbs().maxCoeff() + 1;
  source.bound(difference(scene, by, r, v, other_r, other_v),
               8 * static_cast<double>(n + scene.steps) * u * size * amplification(scene), "moves otherwise");
}

/// 3. Mirrored axes and halved or doubled units of length (with forces that have none) change no bit where sums go by names
/// rather than by places: springs and all pairs.
inline void mirror(Source& source) {
  Scene scene = draw_scene(source, 12);
  source.assume(scene.kind != Scene::short_pairs && scene.kind != Scene::contacts);
  Symmetry by;
  by.order = identity(scene.r.cols());
  for (Index a = 0; a < 3; ++a)
    if (source.flag("mirrored axis")) by.Q(a, a) = -1;
  const Scene other = transformed(scene, by);
  Places r, v, other_r, other_v;
  source.require(run(scene, r, v) && run(other, other_r, other_v), "a step fails");
  source.require((by.Q * r == other_r) && (by.Q * v == other_v), "a mirror changes bits");
}

/// 9. Forces between particles keep the momentum, whatever the scheme.
///
/// Forces are equal and opposite to the bit or to rounding: what is left is u of each particle's momentum and of the
/// impulses Δt F that it gets, in a step.
inline void momentum(Source& source) {
  const Scene scene = draw_scene(source, 12);
  Places r, v;
  source.require(run(scene, r, v), "a step fails");
  const Eigen::Vector3d before = scene.v * scene.mass, after = v * scene.mass;
  const double momenta = (v.cwiseAbs() * scene.mass).maxCoeff() + (scene.v.cwiseAbs() * scene.mass).maxCoeff();
  const auto n = static_cast<double>(scene.r.cols());
  // Contacts push with up to 30 · 0.1, springs pull with up to 2 · 4, stars with 2 each other.
  const double forces = 8 * (n * n + static_cast<double>(scene.bonds.size()));
  source.bound((after - before).cwiseAbs().maxCoeff(),
               8 * scene.steps * u * (momenta + scene.dt * forces) * amplification(scene), "momentum is lost");
}

#ifdef _OPENMP
/// 7. One thread or several: the same bits, the same counts.
inline void threads(Source& source) {
  // Loops are shared in chunks of some hundred rows.
  Scene scene = draw_scene(source, 1500);
  scene.steps = std::min(scene.steps, 4);
  const int several = source.integer("threads", 2, 4);
  Places r, v, other_r, other_v;
  Statistics one, more;
  omp_set_num_threads(1);
  const bool ok = run(scene, r, v, &one);
  omp_set_num_threads(several);
  const bool again = run(scene, other_r, other_v, &more);
  omp_set_num_threads(1);
  source.require(ok && again, "a step fails");
  source.require(r == other_r && v == other_v, "threads change bits");
  source.require(one == more, "threads change counts");
}
#endif

}  // namespace particles

/// @file
/// The bare update by hand: the best loops we could write for these cases alone. phistep is not used here.
///
/// *Unguarded* loops work in place and check nothing. *Guarded* loops give phistep's promise: if any number of the new
/// state is not finite they return false and have changed nothing. They write beside the state and commit by swap.
#pragma once

#include <Eigen/Core>

#include <vector>

namespace overhead {

/// Where a guarded step writes; becomes the state.
struct Beside {
  Eigen::VectorXd r, v;
};

// Forward Euler, force array given: r⁺ = r + Δt v, v⁺ = v + Δt/m f.
void hand_euler(Eigen::VectorXd& r, Eigen::VectorXd& v, const Eigen::VectorXd& f, double mass, double dt);
void eigen_euler(Eigen::VectorXd& r, Eigen::VectorXd& v, const Eigen::VectorXd& f, double mass, double dt);
[[nodiscard]] bool hand_euler_guarded(Eigen::VectorXd& r, Eigen::VectorXd& v, const Eigen::VectorXd& f, double mass,
                                      double dt, Beside& next);
/// The same past the caches, by streaming stores: for states that don't fit them. Without SSE2, the loop above.
[[nodiscard]] bool hand_euler_guarded_streaming(Eigen::VectorXd& r, Eigen::VectorXd& v, const Eigen::VectorXd& f,
                                                double mass, double dt, Beside& next);

// Velocity Verlet, the same force array given to both half-kicks; the passes are kept apart, as by a force call.
void hand_verlet(Eigen::VectorXd& r, Eigen::VectorXd& v, const Eigen::VectorXd& f, double mass, double dt);
void eigen_verlet(Eigen::VectorXd& r, Eigen::VectorXd& v, const Eigen::VectorXd& f, double mass, double dt);
[[nodiscard]] bool hand_verlet_guarded(Eigen::VectorXd& r, Eigen::VectorXd& v, const Eigen::VectorXd& f, double mass,
                                       double dt, Beside& next);
[[nodiscard]] bool hand_verlet_guarded_streaming(Eigen::VectorXd& r, Eigen::VectorXd& v, const Eigen::VectorXd& f,
                                                 double mass, double dt, Beside& next);

// Particles tied by a list of springs, under a uniform force; unguarded, in place. Verlet's f is that at r.
struct Chain {
  struct Tie {
    Eigen::Index i, j;
    double stiffness, length;
  };
  std::vector<Tie> ties;
  double pull;
};
void hand_chain_force(const Eigen::VectorXd& r, Eigen::VectorXd& f, const Chain& chain);
void hand_chain_euler(Eigen::VectorXd& r, Eigen::VectorXd& v, Eigen::VectorXd& f, const Chain& chain, double mass,
                      double dt);
void hand_chain_verlet(Eigen::VectorXd& r, Eigen::VectorXd& v, Eigen::VectorXd& f, const Chain& chain, double mass,
                       double dt);

// An existing code's array of structs, its force given in them.
struct Body {
  double r[3], v[3], f[3], mass, radius, charge;
};
static_assert(sizeof(Body) == 96);
void hand_bodies_euler(std::vector<Body>& bodies, double dt);
void hand_bodies_verlet(std::vector<Body>& bodies, double dt);

// `steps` steps of small fixed states. A guarded run ends at the first step that would not be finite.
/// Forward Euler for the Lorenz system (σ = 10, ρ = 28, β = 8/3): three doubles, or Eigen's Vector3d.
[[nodiscard]] Eigen::Vector3d hand_lorenz_doubles(Eigen::Vector3d y, double dt, long steps);
[[nodiscard]] Eigen::Vector3d hand_lorenz_eigen(Eigen::Vector3d y, double dt, long steps);
[[nodiscard]] Eigen::Vector3d hand_lorenz_eigen_guarded(Eigen::Vector3d y, double dt, long steps);

/// One particle on a spring, Ψ(r) = −r, m = 1. [Vector3d r and v]
struct Particle {
  Eigen::Vector3d r, v;
};
[[nodiscard]] Particle hand_spring_euler(Particle y, double dt, long steps);
[[nodiscard]] Particle hand_spring_euler_guarded(Particle y, double dt, long steps);
[[nodiscard]] Particle hand_spring_verlet(Particle y, double dt, long steps);
[[nodiscard]] Particle hand_spring_verlet_guarded(Particle y, double dt, long steps);

}  // namespace overhead

/// @file
/// phistep: the φ-method for ODEs and motion. Needs Eigen and nothing else. Beside it: sparse.hpp, krylov.hpp, autodiff.hpp;
/// automatic.hpp, advise.hpp, preflight.hpp; particles.hpp; io.hpp; in_place.hpp, fields.hpp; all.hpp.
#pragma once

// IWYU pragma: begin_exports
#include "phistep/base/version.hpp"  // first: it refuses what would break the others
// State, stepper, loop, and what they report.
#include "phistep/base/outcome/outcome.hpp"      // how a step or a run ended
#include "phistep/base/outcome/statistics.hpp"   // counts of the work done
#include "phistep/base/outcome/step_report.hpp"  // what step(y, t, dt) returns
#include "phistep/base/state/blocks.hpp"         // what a state is: an Eigen vector or a struct of blocks
#include "phistep/base/state/motion.hpp"         // Motion{r, v}
#include "phistep/run/run.hpp"  // integrate(stepper, y, {t0, t1}, control, observers…); Run: the same, step by step
#include "phistep/run/stepper/halving.hpp"      // Halving{stepper}: a step that fails is done in halves
#include "phistep/run/stepper/phi_stepper.hpp"  // PhiStepper{y, force, scheme, mass, solver}
#include "phistep/step/mass/mass.hpp"           // mass(m), capacity(C): a number, a vector, a matrix
// Control and observers.
#include "phistep/run/control/fixed_step.hpp"         // fixed(dt)
#include "phistep/run/control/iteration_control.hpp"  // Δt by how many iterations a solve takes
#include "phistep/run/errors/tolerance.hpp"           // tolerance{.rtol, .atol}
#include "phistep/run/observers/at_times.hpp"         // at_times, sampled, every: at given times
#include "phistep/run/observers/completed_step.hpp"   // CompletedStep: both ends of a step, and what lies between
#include "phistep/run/observers/event.hpp"            // event: at roots of g(t, y)
#include "phistep/run/observers/recorder.hpp"         // Recorder: keeps t and y
// Schemes.
#include "phistep/schemes/composed.hpp"  // srkn6b, srkn11b: symplectic, for m v' = Ψ(r); composed(scheme): order 8 of symmetric ones
#include "phistep/schemes/generalized_alpha.hpp"  // generalized_alpha(ρ∞): order 2, damps; newmark(β, γ), hht(α), bossak(α)
#include "phistep/schemes/nystrom/nystrom.hpp"  // rkn86, rkn1210: explicit, for m v' = Ψ(r)
#include "phistep/schemes/phi.hpp"  // phi(φ), forward_euler, trapezoidal, rannacher, midpoint, backward_euler, symplectic_euler
#include "phistep/schemes/radau/radau.hpp"              // radau: stiff, any number of stages
#include "phistep/schemes/rosenbrock.hpp"               // rodas4, rodas4p2, rodas5p: linearly implicit
#include "phistep/schemes/runge_kutta/runge_kutta.hpp"  // tsit5, dop853: explicit
#include "phistep/schemes/tr_bdf2.hpp"                  // tr_bdf2: order 2, L-stable
#include "phistep/schemes/velocity_verlet.hpp"          // velocity_verlet
// Forces.
#include "phistep/force/annotate.hpp"  // what a lambda can't say of itself: affine(f), banded(…), symmetric(f), with_energy(f, V)
#include "phistep/force/at.hpp"                   // at(forward_euler, term), seldom(k, term): kicks of their own
#include "phistep/force/drag.hpp"                 // LinearDrag, QuadraticDrag
#include "phistep/force/gravity.hpp"              // Gravity{g}, UniformForce{F}
#include "phistep/force/linear.hpp"               // linear(K), linear(K, C): a matrix
#include "phistep/force/local.hpp"                // local<dim>(f), ExternalField{f}: one particle's force, for each
#include "phistep/force/sum.hpp"                  // sums of terms
#include "phistep/particles/springs/springs.hpp"  // spring_network(springs)
// Solvers.
#include "phistep/linear/banded/banded_system.hpp"  // band matrices
#include "phistep/step/solve/fixed_point.hpp"       // fixed_point(): no Jacobian, no matrix
#include "phistep/step/solve/newton.hpp"            // Newton's iteration
// Checks.
#include "phistep/study/checks/check_force.hpp"  // check_force: a function of its argument? check_jacobian: against differences
#include "phistep/study/checks/make_consistent.hpp"  // make_consistent: starts of differential-algebraic equations
#include "phistep/study/energy/energy_ledger.hpp"    // EnergyLedger: where a motion's energy went
// IWYU pragma: end_exports

// Random sequences of operations, for every kind of stepper that keeps something from step to step.
#include <phistep/sparse.hpp>

#include "properties/machine_cases.hpp"

using namespace machine;

namespace {

constexpr auto composed_verlet = composed(velocity_verlet);

/// One factorization a run.
struct Affinely : SecondOrder {
  static auto stepper(const Motion<Vec>& y, Mood* mood) {
    const Eigen::Index n = y.r.size();
    Eigen::MatrixXd K = -2 * Eigen::MatrixXd::Identity(n, n);
    for (Eigen::Index i = 0; i + 1 < n; ++i) K(i, i + 1) = K(i + 1, i) = 1;
    return PhiStepper{y, linear(K, Eigen::MatrixXd(-0.3 * Eigen::MatrixXd::Identity(n, n))) + Trouble{mood}, midpoint};
  }
};
/// Conjugate gradients on the edges.
struct Springs {
  static constexpr bool has_past = false;
  static Motion<Vec> start(int) { return {spread(9, 0.4), spread(9, 1.9)}; }
  static auto stepper(const Motion<Vec>& y, Mood* mood) {
    return PhiStepper{y, spring_network<3>({{0, 1, 20, 0.5}, {1, 2, 30, 0.5}, {2, 0, 5, 0.2}}) + Trouble{mood},
                      backward_euler};
  }
};
struct GasByTrapezoids : Gas {
  static auto stepper(const State& y, Mood* mood) { return PhiStepper{y, force(mood), trapezoidal}; }
};

/// Tangents by differences remain in the result, not only in the way to it: as good as differences are.
template <class Case>
Promise linear_stages(const char* name) {
  return promise<Case>(name, false, false, 1e5, 1, 6);
}
Promise looking_ahead(Promise promise) {
  promise.looks_ahead = true;
  return promise;
}

}  // namespace

TEST_CASE("whatever was done before, the next step is a fresh stepper's") {
  for (const Promise& each : {
           promise<Flow<forward_euler>>("forward Euler", true, true, 0, 1, 6),
           promise<Flow<trapezoidal>>("trapezoidal, Newton", false, false, 64, 1, 6),
           promise<Flow<tr_bdf2>>("TR-BDF2, Newton", false, false, 64, 1, 6),
           promise<Starts>("Rannacher's start", false, false, 64, 1, 6),
           linear_stages<Flow<rodas4>>("Rodas4"),
           promise<Flow<radau>>("Radau", false, false, 256, 1, 6),
           promise<Flow<tsit5>>("tsit5", false, true, 64, 1, 6),
           promise<Swing<velocity_verlet>>("velocity Verlet", true, true, 0, 1, 6),
           promise<Swing<srkn6b>>("srkn6b", false, true, 64, 1, 6),
           looking_ahead(promise<Swing<rkn86>>("RKN 8(6)", false, true, 64, 1, 6)),
           promise<Swing<composed_verlet>>("composed Verlet", false, true, 64, 1, 6),
           promise<DampedSwing<velocity_verlet>>("Verlet with drag", false, false, 64, 1, 6),
           promise<DampedSwing<phi_07>>("phi = 0.7, Newton", false, false, 64, 1, 6),
           promise<Affinely>("affine, midpoint", false, false, 256, 4, 4),
           promise<Springs>("springs, CG", false, false, 256, 3, 3),
           with_list(promise<GasByVerlet>("a gas, Verlet", false, true, 64, 1, 9)),
           with_list(promise<GasByTrapezoids>("a gas, trapezoidal", false, false, 64, 1, 9)),
           promise<Grains>("grains with friction", true, true, 0, 1, 6),
       })
    property::report(std::string("any sequence of operations: ") + each.name, 3000,
                     [&each](Source& source) { live(source, each); });
}

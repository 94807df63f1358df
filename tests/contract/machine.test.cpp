// Random sequences of steps, failures, edits, checkpoints and resets against fresh steppers. Explicit ones, and
// particles: the full tier.
#include <phistep/particles.hpp>

#include "contract/machine_vectors.hpp"
#if PHISTEP_STRESS
#include <phistep/sparse.hpp>
#endif

namespace machine {

/// A gas in a periodic box: its list of neighbours lives long.
struct Gas {
  static constexpr bool has_past = false;
  using State = Particles<double, 3>;
  static State start(int n) {
    Eigen::Matrix3Xd r(3, n), v(3, n);
    for (Index k = 0; k < n; ++k) {
      r.col(k) << static_cast<double>(k % 2), static_cast<double>(k / 2 % 2), static_cast<double>(k / 4);
      v.col(k) = 0.5 * spread(3, static_cast<double>(k));
    }
    State gas{1.2 * r, v};
    gas.set_box(Box<double, 3>::periodic({0, 0, 0}, {5, 5, 5}));
    return gas;
  }
  static auto force(Mood* mood) {
    // Soft and smooth, so that no edit makes it stiff and no rounding makes a jump at the cutoff.
    const auto soft = [](auto r2) {
      const auto x = 1.0 - r2 / 3.24;
      return x * x;
    };
    return Pairs{soft, 1.8, {.skin = 0.3}} + Trouble{mood};
  }
  static bool edit(State& y, const Edit& edit) {
    if (y.size() == 0 || edit.kind != Edit::others) return false;
    y.set_mass(Vec(Vec::Constant(y.size(), 1.25 + edit.value)));
    return true;
  }
  static void resize(State& y, int n, const Edit& edit) {
    if (n > y.size()) {
      State more = start(n);
      const Index old = y.size();
      more.erase_if([old](Index i) { return i < old; });
      y.add(more);
    } else if (n < y.size()) {
      int gone = static_cast<int>(y.size()) - n;
      y.erase_if([&gone, &edit](Index i) { return (i + edit.which) % 2 == 0 && gone-- > 0; });
    }
  }
};
struct GasByVerlet : Gas {
  static auto stepper(const State& y, Mood* mood) { return PhiStepper{y, force(mood), velocity_verlet}; }
};

/// A list's reference positions are memory, which a fresh stepper hasn't.
inline Promise with_list(Promise promise) {
  promise.forgets = false;
  return promise;
}

/// Grains that touch, rub and remember.
struct Grains {
  static constexpr bool has_past = true;
  using State = Particles<double, 2, Spin>;
  static State start(int n) {
    Eigen::Matrix2Xd r(2, n), v(2, n);
    for (Index k = 0; k < n; ++k) {
      r.col(k) << 0.95 * static_cast<double>(k % 3), 0.96 * static_cast<double>(k / 3);
      v.col(k) = 0.1 * spread(2, static_cast<double>(k));
    }
    State grains{r, v};
    grains.set_radius(0.5);
    return grains;
  }
  static auto stepper(const State& y, Mood* mood) {
    const Hooke law{.stiffness = 20, .restitution = 0.7, .friction = 0.4};
    return PhiStepper{y, Contact{law} + Trouble{mood}, symplectic_euler};
  }
};

}  // namespace machine

using namespace machine;

#if PHISTEP_FULL
// Random sequences of steps, failures, edits, checkpoints and resets against fresh steppers, explicit and of particles.

TEST_CASE("whatever was done before, the next step is a fresh stepper's") {
  for (const Promise& each : {
           promise<Swing<velocity_verlet>>("velocity Verlet", true, true, 0, 1, 5),
           with_list(promise<GasByVerlet>("a gas by Verlet", false, true, 64, 1, 9)),
           promise<Grains>("grains with friction", true, true, 0, 1, 6),
       })
    property::check(each.name, 200, [&each](Source& source) { live(source, each); });
}

#elif PHISTEP_STRESS
// Random sequences of operations, for every kind of stepper that keeps something from step to step.

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

#endif

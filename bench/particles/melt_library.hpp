/// @file
/// phistep's melt: velocity Verlet, a pair law, a neighbour list.
#pragma once

#include <phistep/phistep.hpp>

#include <phistep/particles/bodies/particles.hpp>
#include <phistep/particles/pairs/pairs.hpp>

#include <functional>
#include <stdexcept>
#include <utility>

#include "melt.hpp"
#include "rows.hpp"

namespace bench {

/// The melt with another scalar or another law, from the same start.
template <class Scalar, class Law>
class LibraryMelt {
 public:
  using State = phistep::Particles<Scalar, 3>;

  LibraryMelt(const Scene& scene, Law law, phistep::PairOptions options)
      : state_{start(scene)}, pairs_{std::move(law), melt_cutoff, options}, stepper_{make(state_, pairs_)} {}
  LibraryMelt(const LibraryMelt&) = delete;  // the stepper refers to the force
  LibraryMelt& operator=(const LibraryMelt&) = delete;

  void step(int times) {
    for (int n = 0; n < times; ++n)
      if (const auto report =
              stepper_.step(state_, static_cast<Scalar>(melt_dt * done_++), static_cast<Scalar>(melt_dt));
          !report)
        throw std::runtime_error(report.message());
  }
  [[nodiscard]] const State& state() const { return state_; }
  [[nodiscard]] const phistep::Pairs<Law>& force() const { return pairs_; }
  [[nodiscard]] auto view() const { return State::view(state_, masses_); }

 private:
  static State start(const Scene& scene) {
    State atoms{scene.r.template cast<Scalar>(), scene.v.template cast<Scalar>()};
    using Vector = Eigen::Matrix<Scalar, 3, 1>;
    atoms.set_box(phistep::Box<Scalar, 3>::periodic(Vector::Zero(), Vector::Constant(static_cast<Scalar>(scene.side))));
    return atoms;
  }
  static auto make(const State& atoms, phistep::Pairs<Law>& pairs) {
    return phistep::PhiStepper{atoms, std::ref(pairs), phistep::velocity_verlet};
  }
  State state_;
  decltype(State::masses(std::declval<const State&>())) masses_ = State::masses(state_);
  phistep::Pairs<Law> pairs_;
  decltype(make(std::declval<const State&>(), std::declval<phistep::Pairs<Law>&>())) stepper_;
  int done_ = 0;
};

/// Seconds of `steps` steps. One is made before: like LAMMPS' set-up, the first list and force are not counted.
template <class Scalar = double, class Law = phistep::LennardJones>
[[nodiscard]] double time_melt(const Scene& scene, int steps, phistep::PairOptions options, int threads = 1,
                               Law law = {}) {
  use_threads(threads);
  LibraryMelt<Scalar, Law> melt{scene, std::move(law), options};
  melt.step(1);
  const Stopwatch watch(threads);
  melt.step(steps);
  return watch.seconds();
}

}  // namespace bench

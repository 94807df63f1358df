#include "problems/kepler.hpp"

#include "motion.hpp"

work_precision::Table work_precision::kepler() {
  using problems::Kepler;
  const Kepler kepler;
  constexpr double end = 100 * Kepler::period;
  // 100 periods are a double only nearly: where the bodies are at that double, by Kepler's equation in quadruple precision.
  const Kepler::State exact{{4.00000000000000022e-01, -5.15322701505990260e-13}, {1.61038344242875145e-12, 2.0}};
  return small_motion<problems::KeplerForce>("kepler", "Kepler, e = 0.6, 100 periods", kepler.start(), end, exact, 1.0,
                                             1.7e5, 4);
}

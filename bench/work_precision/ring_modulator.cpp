#include "problems/ring_modulator.hpp"

#include "driven.hpp"

work_precision::Table work_precision::ring_modulator() {
  return driven_stiff<problems::RingModulator>("ring_modulator", "Ring modulator to t = 1 ms", 1e-2);
}

#pragma once

#include <Eigen/Core>

#include <array>

#include "problems/ring_pairs.hpp"

namespace problems {

/// Seven stars in a plane, masses 1 … 7, G = 1, to t = 3 (Hairer, Nørsett & Wanner, Solving ODEs I, sect. II.10, PLEI): close
/// encounters, of which the nearest is at a distance of 0.013. Positions: seven x, seven y.
struct Pleiades {
  using Vector = Eigen::Matrix<double, 14, 1>;
  static constexpr double end = 3;

  [[nodiscard]] static Vector positions() { return Vector{{3, 3, -1, -3, 2, -2, 2, 3, -3, 2, 0, 0, -4, 4}}; }
  [[nodiscard]] static Vector velocities() { return Vector{{0, 0, 0, 0, 0, 1.75, -1.5, 0, 0, 0, -1.25, 1, 0, 0}}; }
  template <class T>
  static void acceleration(const T* r, T* a) {
    attract<7, 2>({1, 2, 3, 4, 5, 6, 7}, r, a);
  }
  Vector operator()(const Vector& r) const {
    Vector a;
    acceleration(r.data(), a.data());
    return a;
  }

  /// At t = 3, by a symmetric composition of order 8 (Kahan & Li) in quadruple precision; the published values agree to 13 digits.
  [[nodiscard]] static Vector exact_positions() {
    return Vector{{3.70613914397051269e-01, 3.23728409205723322e+00, -3.22255903241832353e+00, 6.59709145577530798e-01,
                   3.42558170715657972e-01, 1.56217210140063112e+00, -7.00309292221249491e-01, -3.94343758551739221e+00,
                   -3.27138097397254990e+00, 5.22508184345654403e+00, -2.59061243497746929e+00, 1.19821369339227468e+00,
                   -2.42968234493582347e-01, 1.09144924042897973e+00}};
  }
  [[nodiscard]] static Vector exact_velocities() {
    return Vector{{3.41700380631431466e+00, 1.35458450162550115e+00, -2.59006559781077561e+00, 2.02505373471424122e+00,
                   -1.15581510016044908e+00, -8.07298817022302218e-01, 5.95239635420871882e-01,
                   -3.74124496123400840e+00, 3.77345968575062918e-01, 9.38685886955107907e-01, 3.66792222720056960e-01,
                   -3.47404635380849425e-01, 2.34491544818093711e+00, -1.94702043426329197e+00}};
  }
};

}  // namespace problems

#include "gravity.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <memory>

#ifdef __AVX512F__
#include <immintrin.h>
#endif

namespace bench {

template <class Scalar>
Scalar* Cluster<Scalar>::on_a_line(std::vector<Scalar>& memory) {
  void* start = memory.data();
  std::size_t room = memory.size() * sizeof(Scalar);
  return static_cast<Scalar*>(std::align(64, 1, start, room));
}
template struct Cluster<double>;
template struct Cluster<float>;

namespace {

/// Pair by pair, Newton's third law.
template <class Scalar>
void textbook(Cluster<Scalar>& c) {
  const Scalar eps2 = static_cast<Scalar>(c.epsilon * c.epsilon);
  for (Scalar* a : {c.ax, c.ay, c.az}) std::fill(a, a + c.n, Scalar{0});
  for (std::size_t i = 0; i < c.n; ++i)
    for (std::size_t j = i + 1; j < c.n; ++j) {
      const Scalar x = c.x[j] - c.x[i], y = c.y[j] - c.y[i], z = c.z[j] - c.z[i];
      const Scalar r2 = x * x + y * y + z * z + eps2, s = 1 / (r2 * std::sqrt(r2));
      const Scalar p = s * c.m[j], q = s * c.m[i];
      c.ax[i] += p * x, c.ay[i] += p * y, c.az[i] += p * z;
      c.ax[j] -= q * x, c.ay[j] -= q * y, c.az[j] -= q * z;
    }
}

#ifdef __AVX512F__
/// The instructions of one type.
struct Doubles {
  using Number = double;
  using Vector = __m512d;
  static constexpr std::size_t width = 8, tile = 512;  // tile: seven arrays of it stay in L1
  static Vector load(const double* p) { return _mm512_load_pd(p); }
  static void store(double* p, Vector v) { _mm512_store_pd(p, v); }
  static Vector all(double s) { return _mm512_set1_pd(s); }
  static Vector fma(Vector a, Vector b, Vector c) { return _mm512_fmadd_pd(a, b, c); }
  static Vector minus(Vector a, Vector b, Vector c) { return _mm512_fnmadd_pd(a, b, c); }
  static Vector estimate(Vector a) { return _mm512_rsqrt14_pd(a); }
  static Vector root(Vector a) { return _mm512_sqrt_pd(a); }
  static double sum(Vector a) { return _mm512_reduce_add_pd(a); }
  /// p(e) of y³ (1 + e p(e)) = r⁻³, e = 1 − r² y²
  static Vector series(Vector e) { return fma(e, fma(e, all(2.1875), all(1.875)), all(1.5)); }
};
struct Floats {
  using Number = float;
  using Vector = __m512;
  static constexpr std::size_t width = 16, tile = 1024;
  static Vector load(const float* p) { return _mm512_load_ps(p); }
  static void store(float* p, Vector v) { _mm512_store_ps(p, v); }
  static Vector all(float s) { return _mm512_set1_ps(s); }
  static Vector fma(Vector a, Vector b, Vector c) { return _mm512_fmadd_ps(a, b, c); }
  static Vector minus(Vector a, Vector b, Vector c) { return _mm512_fnmadd_ps(a, b, c); }
  static Vector estimate(Vector a) { return _mm512_rsqrt14_ps(a); }
  static Vector root(Vector a) { return _mm512_sqrt_ps(a); }
  static float sum(Vector a) { return _mm512_reduce_add_ps(a); }
  static Vector series(Vector) { return all(1.5f); }
};

/// Particle i in a lane, j in all of them; every pair twice.
template <class V, class Number = typename V::Number>
void one_sided(Cluster<Number>& c) {
  using Vector = typename V::Vector;
  const Vector eps2 = V::all(static_cast<Number>(c.epsilon * c.epsilon));
  for (std::size_t i = 0; i < c.n; i += V::width) {
    const Vector xi = V::load(c.x + i), yi = V::load(c.y + i), zi = V::load(c.z + i);
    Vector ax = V::all(0), ay = ax, az = ax;
    for (std::size_t j = 0; j < c.n; ++j) {
      const Vector dx = V::all(c.x[j]) - xi, dy = V::all(c.y[j]) - yi, dz = V::all(c.z[j]) - zi;
      const Vector r2 = V::fma(dx, dx, V::fma(dy, dy, V::fma(dz, dz, eps2)));
      const Vector y = V::estimate(r2), y2 = y * y, e = V::minus(r2, y2, V::all(1)), y3 = (V::all(c.m[j]) * y) * y2;
      const Vector k = V::fma(e * V::series(e), y3, y3);
      ax = V::fma(k, dx, ax), ay = V::fma(k, dy, ay), az = V::fma(k, dz, az);
    }
    V::store(c.ax + i, ax), V::store(c.ay + i, ay), V::store(c.az + i, az);
  }
}

/// Every pair once: four j in all lanes with sums in registers, the i's of a tile streamed past them.
template <class V, class Number = typename V::Number>
void two_sided(Cluster<Number>& c) {
  using Vector = typename V::Vector;
  constexpr std::size_t at_once = 4, w = V::width;
  const Vector eps2 = V::all(static_cast<Number>(c.epsilon * c.epsilon));
  for (Number* a : {c.ax, c.ay, c.az}) std::fill(a, a + c.n, Number{0});
  for (std::size_t tile = 0; tile < c.n; tile += V::tile) {
    const std::size_t tile_end = std::min(c.n, tile + V::tile);
    for (std::size_t j = tile; j < c.n; j += at_once) {
      const std::size_t end = std::min(tile_end, j / w * w);
      Vector axj[at_once], ayj[at_once], azj[at_once];
      for (std::size_t b = 0; b < at_once; ++b) axj[b] = ayj[b] = azj[b] = V::all(0);
      for (std::size_t i = tile; i < end; i += w) {
        const Vector xi = V::load(c.x + i), yi = V::load(c.y + i), zi = V::load(c.z + i), mi = V::load(c.m + i);
        Vector ax = V::load(c.ax + i), ay = V::load(c.ay + i), az = V::load(c.az + i);
#pragma GCC unroll 4
        for (std::size_t b = 0; b < at_once; ++b) {
          const Vector dx = V::all(c.x[j + b]) - xi, dy = V::all(c.y[j + b]) - yi, dz = V::all(c.z[j + b]) - zi;
          const Vector r2 = V::fma(dx, dx, V::fma(dy, dy, V::fma(dz, dz, eps2)));
          const Vector y = V::estimate(r2), y2 = y * y, e = V::minus(r2, y2, V::all(1)), y3 = y * y2;
          const Vector k = V::fma(e * V::series(e), y3, y3), ki = k * V::all(c.m[j + b]), kj = k * mi;
          ax = V::fma(ki, dx, ax), ay = V::fma(ki, dy, ay), az = V::fma(ki, dz, az);
          axj[b] = V::minus(kj, dx, axj[b]), ayj[b] = V::minus(kj, dy, ayj[b]), azj[b] = V::minus(kj, dz, azj[b]);
        }
        V::store(c.ax + i, ax), V::store(c.ay + i, ay), V::store(c.az + i, az);
      }
      for (std::size_t b = 0; b < at_once; ++b)
        c.ax[j + b] += V::sum(axj[b]), c.ay[j + b] += V::sum(ayj[b]), c.az[j + b] += V::sum(azj[b]);
    }
  }
  for (std::size_t i = 0; i < c.n; i += w) {  // squares on the diagonal
    const Vector xi = V::load(c.x + i), yi = V::load(c.y + i), zi = V::load(c.z + i);
    Vector ax = V::load(c.ax + i), ay = V::load(c.ay + i), az = V::load(c.az + i);
    for (std::size_t j = i; j < i + w; ++j) {
      const Vector dx = V::all(c.x[j]) - xi, dy = V::all(c.y[j]) - yi, dz = V::all(c.z[j]) - zi;
      const Vector r2 = dx * dx + dy * dy + dz * dz + eps2, k = V::all(c.m[j]) / (r2 * V::root(r2));
      ax += k * dx, ay += k * dy, az += k * dz;
    }
    V::store(c.ax + i, ax), V::store(c.ay + i, ay), V::store(c.az + i, az);
  }
}
#endif

}  // namespace

template <class Scalar>
std::vector<Kernel<Scalar>> gravity_by_hand() {
  std::vector<Kernel<Scalar>> kernels{{"textbook, pair by pair", textbook<Scalar>}};
#ifdef __AVX512F__
  using V = std::conditional_t<sizeof(Scalar) == 8, Doubles, Floats>;
  kernels.push_back({"hand AVX-512, every pair twice", one_sided<V>});
  kernels.push_back({"hand AVX-512, every pair once", two_sided<V>});
#endif
  return kernels;
}
template std::vector<Kernel<double>> gravity_by_hand();
template std::vector<Kernel<float>> gravity_by_hand();

}  // namespace bench

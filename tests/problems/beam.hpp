#pragma once

#include <Eigen/Core>

#include <array>
#include <cmath>

namespace problems {

/// Beam: an elastic beam of 40 joints, clamped at one end, pulled at the other until t = π, to t = 5 (Hairer & Wanner, Solving ODEs
/// II, sect. IV.10). Unknowns: 40 angles, then 40 angular velocities. Its Jacobian is dense; everybody forms it by differences.
struct Beam {
  using State = Eigen::VectorXd;
  static constexpr int joints = 40;
  static constexpr double end = 5;

  [[nodiscard]] static State start() { return State::Zero(2 * joints); }
  template <class Y, class Out>
  static void rate(double t, const Y& y, Out&& out) {
    constexpr int n = joints;
    constexpr double n2 = double{n} * n, n4 = n2 * n2;
    std::array<double, n> s{}, c{}, v{}, w{}, above{}, diagonal{};
    const auto at = [](auto& x, int i) -> double& { return x[static_cast<std::size_t>(i)]; };
    for (int i = 1; i < n; ++i) at(s, i) = std::sin(y[i] - y[i - 1]), at(c, i) = std::cos(y[i] - y[i - 1]);
    at(v, 0) = (-3 * y[0] + y[1]) * n4;
    for (int i = 1; i < n - 1; ++i) at(v, i) = (y[i - 1] - 2 * y[i] + y[i + 1]) * n4;
    at(v, n - 1) = (y[n - 2] - y[n - 1]) * n4;
    if (t <= 3.14159265358979324) {
      const double F = 1.5 * std::sin(t) * std::sin(t);
      for (int i = 0; i < n; ++i) at(v, i) += n2 * F * (std::cos(y[i]) + std::sin(y[i]));
    }
    at(w, 0) = at(s, 1) * at(v, 1);
    for (int i = 1; i < n - 1; ++i) at(w, i) = -at(s, i) * at(v, i - 1) + at(s, i + 1) * at(v, i + 1);
    at(w, n - 1) = -at(s, n - 1) * at(v, n - 2);
    for (int i = 0; i < n; ++i) at(w, i) += y[n + i] * y[n + i];
    // C w = D v + θ'², C tridiagonal: 1 3 at its ends, 2 inside, −cos(θ_i − θ_{i−1}) beside
    at(diagonal, 0) = 1;
    for (int i = 1; i < n; ++i) at(diagonal, i) = 2, at(above, i - 1) = -at(c, i);
    at(diagonal, n - 1) = 3;
    for (int i = n - 2; i >= 0; --i) {
      const double q = at(above, i) / at(diagonal, i + 1);
      at(w, i) -= at(w, i + 1) * q;
      at(diagonal, i) -= at(above, i) * q;
    }
    at(w, 0) /= at(diagonal, 0);
    for (int i = 1; i < n; ++i) at(w, i) = (at(w, i) - at(above, i - 1) * at(w, i - 1)) / at(diagonal, i);
    for (int i = 0; i < n; ++i) out[i] = y[n + i];
    out[n] = at(v, 0) - at(c, 1) * at(v, 1) + at(s, 1) * at(w, 1);
    for (int i = 1; i < n - 1; ++i)
      out[n + i] = 2 * at(v, i) - at(c, i) * at(v, i - 1) - at(c, i + 1) * at(v, i + 1) - at(s, i) * at(w, i - 1) +
                   at(s, i + 1) * at(w, i + 1);
    out[2 * n - 1] = 3 * at(v, n - 1) - at(c, n - 1) * at(v, n - 2) - at(s, n - 1) * at(w, n - 2);
  }
  template <class Y, class Put>
  static void entries(double t, const Y& y, Put&& put) {
    State from(2 * joints), moved(2 * joints), x(2 * joints);
    for (int i = 0; i < 2 * joints; ++i) x[i] = y[i];
    rate(t, x, from);
    for (int j = 0; j < 2 * joints; ++j) {
      const double before = x[j], step = 1e-8 * std::fmax(1.0, std::abs(before));
      x[j] = before + step;
      rate(t, x, moved);
      for (int i = 0; i < 2 * joints; ++i) put(i, j, (moved[i] - from[i]) / (x[j] - before));
      x[j] = before;
    }
  }

  /// Two codes at tight tolerances, which agree to 6e-11.
  [[nodiscard]] static State exact() {
    return State{{-0.0057923665912927146, -0.016952985507205691, -0.027691033129714531, -0.03800815655878087,
                  -0.047906168597415012,  -0.057387104352737459, -0.066453273134525481, -0.075107305819786377,
                  -0.083352197654123675,  -0.091191346546445909, -0.098628587001300477, -0.10566822003778654,
                  -0.11231503954092202,   -0.1185743552726994,   -0.1244520128755269,   -0.12995441132639238,
                  -0.13508851806100597,   -0.13986188191941384,  -0.14428264410148445,  -0.14835954724625805,
                  -0.15210194290010501,   -0.15551979780608285,  -0.15862369934199724,  -0.16142486037016779,
                  -0.16393512381927811,   -0.16616696734404049,  -0.16813350817781328,  -0.16984850806019736,
                  -0.17132637824404132,   -0.1725821847462157,   -0.17363165379752746,  -0.1744911773839653,
                  -0.17517781878629046,   -0.17570931787124108,  -0.17610409602281096,  -0.17638126071750312,
                  -0.17656060975642901,   -0.17666263522600714,  -0.17670852708069709,  -0.17672017610752111,
                  0.037473626810098713,   0.10991178801848343,   0.17983604743909204,   0.24724273055514831,
                  0.31212938204777729,    0.37449473768588365,   0.43433860737577168,   0.49166203543938414,
                  0.54646778549062391,    0.59876097022330343,   0.64854936114412354,   0.69584351688672308,
                  0.74065726687036293,    0.78300817478712603,   0.82291766586546911,   0.86041103059352042,
                  0.89551755020853041,    0.92827082630852165,   0.95870893344752461,   0.98687478218132751,
                  1.012816579950464,      1.0365877366942478,    1.0582468264902087,    1.0778578114135737,
                  1.0954902220082425,     1.1112191643178011,    1.1251252692641702,    1.1372945265890346,
                  1.1478180252041228,     1.1567921319679191,    1.1643188451375808,    1.1705059925980184,
                  1.1754674243237921,     1.1793230032044901,    1.1821985862950568,    1.1842261112187076,
                  1.1855439098176788,     1.1862970842236775,    1.1866376188774568,    1.1867246151324584}};
  }
};

}  // namespace problems

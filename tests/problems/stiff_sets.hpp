#pragma once

#include <Eigen/Core>
#include <cmath>
#include <vector>

// Stiff problems of public sets, as rates on bare arrays.
//   a1 … f3   STIFF DETEST (W. H. Enright, T. E. Hull & B. Lindberg, Comparing numerical methods for stiff systems of O.D.E.s,
//             BIT 15 (1975) 10; W. H. Enright & J. D. Pryce, ACM Trans. Math. Softw. 13 (1987) 1), without those that stand
//             in files of their own
//   chapman   ozone by day and night (D. Kahaner, C. Moler & S. Nash, Numerical Methods and Software, 1989, sect. 8.9)
//   fitzhugh, lotka, rigid body   SciMLBenchmarks' of the same names, not stiff

namespace problems {

struct Flow {
  const char* name;
  std::vector<double> start;
  double end;    ///< [time]
  double small;  ///< atol / rtol
  void (*rate)(double t, const double* y, double* out);
  bool uses_time = false;
};

namespace stiff {

template <int alpha>
void rings(double, const double* y, double* f) {
  f[0] = -10 * y[0] + alpha * y[1], f[1] = -alpha * y[0] - 10 * y[1];
  f[2] = -4 * y[2], f[3] = -y[3], f[4] = -0.5 * y[4], f[5] = -0.1 * y[5];
}
/// @param tenths  of beta
template <int tenths>
void cascade(double, const double* y, double* f) {
  constexpr double beta = tenths / 10.0;
  const double a = y[0] * y[0], b = y[1] * y[1], c = y[2] * y[2];
  f[0] = -y[0] + 2, f[1] = -10 * y[1] + beta * a, f[2] = -40 * y[2] + 4 * beta * (a + b);
  f[3] = -100 * y[3] + 10 * beta * (a + b + c);
}

}  // namespace stiff

[[nodiscard]] inline std::vector<Flow> stiff_sets() {
  using C = const double*;
  using D = double*;
  return {
      {"a1",
       {1, 1, 1, 1},
       20,
       1e-3,
       [](double, C y, D f) { f[0] = -0.5 * y[0], f[1] = -y[1], f[2] = -100 * y[2], f[3] = -90 * y[3]; }},
      {"a2", std::vector<double>(9, 0.0), 120, 1e-3,
       [](double, C y, D f) {
         f[0] = -1800 * y[0] + 900 * y[1], f[8] = 1000 * y[7] - 2000 * y[8] + 1000;
         for (int i = 1; i < 8; ++i) f[i] = y[i - 1] - 2 * y[i] + y[i + 1];
       }},
      {"a3",
       {1, 1, 1, 1},
       20,
       1e-3,
       [](double, C y, D f) {
         f[0] = -1e4 * y[0] + 100 * y[1] - 10 * y[2] + y[3], f[1] = -1e3 * y[1] + 10 * y[2] - 10 * y[3];
         f[2] = -y[2] + 10 * y[3], f[3] = -0.1 * y[3];
       }},
      {"a4", std::vector<double>(10, 1.0), 1, 1e-3,
       [](double, C y, D f) {
         for (int i = 0; i < 10; ++i) f[i] = -std::pow(i + 1.0, 5) * y[i];
       }},
      {"b1",
       {1, 0, 1, 0},
       20,
       1e-3,
       [](double, C y, D f) {
         f[0] = -y[0] + y[1], f[1] = -100 * y[0] - y[1], f[2] = -100 * y[2] + y[3], f[3] = -1e4 * y[2] - 100 * y[3];
       }},
      {"b2", std::vector<double>(6, 1.0), 20, 1e-3, stiff::rings<3>},
      {"b3", std::vector<double>(6, 1.0), 20, 1e-3, stiff::rings<8>},
      {"b4", std::vector<double>(6, 1.0), 20, 1e-3, stiff::rings<25>},
      {"b5", std::vector<double>(6, 1.0), 20, 1e-3, stiff::rings<100>},
      {"c1",
       {1, 1, 1, 1},
       20,
       1e-3,
       [](double, C y, D f) {
         f[0] = -y[0] + y[1] * y[1] + y[2] * y[2] + y[3] * y[3], f[1] = -10 * y[1] + 10 * (y[2] * y[2] + y[3] * y[3]);
         f[2] = -40 * y[2] + 40 * y[3] * y[3], f[3] = -100 * y[3] + 2;
       }},
      {"c2", {1, 1, 1, 1}, 20, 1e-3, stiff::cascade<1>},
      {"c3", {1, 1, 1, 1}, 20, 1e-3, stiff::cascade<10>},
      {"c4", {1, 1, 1, 1}, 20, 1e-3, stiff::cascade<100>},
      {"c5", {1, 1, 1, 1}, 20, 1e-3, stiff::cascade<200>},
      {"d1",
       {0, 0, 0},
       400,
       1e-3,
       [](double, C y, D f) {
         f[0] = 0.2 * (y[1] - y[0]), f[1] = 10 * y[0] - (60 - 0.125 * y[2]) * y[1] + 0.125 * y[2], f[2] = 1;
       }},
      {"d3",
       {1, 1, 0, 0},
       20,
       1e-4,
       [](double, C y, D f) {
         const double first = 100 * y[0] * y[1], second = 1e4 * y[1] * y[1];
         f[0] = y[2] - first, f[1] = y[2] + 2 * y[3] - first - 2 * second, f[2] = -y[2] + first, f[3] = -y[3] + second;
       }},
      {"d4",
       {1, 1, 0},
       50,
       1e-6,
       [](double, C y, D f) {
         const double first = 0.013 * y[0] + 1000 * y[0] * y[2], second = 2500 * y[1] * y[2];
         f[0] = -first, f[1] = -second, f[2] = -first - second;
       }},
      {"d5",
       {0, 0},
       100,
       1e-3,
       [](double, C y, D f) {
         const double all = 0.01 + y[0] + y[1];
         f[0] = 0.01 - all * (1 + (y[0] + 1000) * (y[0] + 1)), f[1] = 0.01 - all * (1 + y[1] * y[1]);
       }},
      {"d6",
       {1, 0, 0},
       1,
       1e-8,
       [](double, C y, D f) {
         f[0] = -y[0] + 1e8 * y[2] * (1 - y[0]), f[1] = -10 * y[1] + 3e7 * y[2] * (1 - y[1]), f[2] = -f[0] - f[1];
       }},
      {"e1",
       {0, 0, 0, 0},
       1,
       1e-8,
       [](double, C y, D f) {
         constexpr double g = 100;
         f[0] = y[1], f[1] = y[2], f[2] = y[3];
         f[3] = (y[0] * y[0] - std::sin(y[0]) - g * g * g * g) * y[0] +
                (y[1] * y[2] / (y[0] * y[0] + 1) - 4 * g * g * g) * y[1] + (1 - 6 * g * g) * y[2] +
                (10 * std::exp(-y[3] * y[3]) - 4 * g) * y[3] + 1;
       }},
      {"e3",
       {1, 1, 0},
       500,
       1e-3,
       [](double, C y, D f) {
         f[0] = -(55 + y[2]) * y[0] + 65 * y[1], f[1] = 0.0785 * (y[0] - y[1]), f[2] = 0.1 * y[0];
       }},
      {"f1",
       {761, 0, 600, 0.1},
       1000,
       1e-3,
       [](double, C y, D f) {
         const double k = std::exp(20.7 - 1500 / y[0]);
         f[0] = 1.3 * (y[2] - y[0]) + 10400 * k * y[1], f[1] = 1880 * (y[3] - y[1] * (1 + k));
         f[2] = 1752 - 269 * y[2] + 267 * y[0], f[3] = 0.1 + 320 * y[1] - 321 * y[3];
       }},
      {"f2",
       {1, 0},
       240,
       1e-3,
       [](double, C y, D f) { f[0] = -y[0] - y[0] * y[1] + 294 * y[1], f[1] = y[0] * (1 - y[1]) / 98 - 3 * y[1]; }},
      {"f3",
       {4e-6, 1e-6, 0, 0, 0},
       100,
       1e-9,
       [](double, C y, D f) {
         const double one = 1e7 * y[1] * y[0], two = 1e7 * y[1] * y[4];
         f[0] = -one + 10 * y[2], f[1] = -one - two + 10 * y[2] + 10 * y[3], f[2] = one - 1.001e4 * y[2] + 1e-3 * y[3];
         f[3] = 1e4 * y[2] - 10.001 * y[3] + two, f[4] = 10 * y[3] - two;
       }},
      {"chapman",
       {1e6, 1e12},
       864000 / 2.0,
       1,
       [](double t, C y, D f) {
         const double sun = std::sin(3.141592653589793 / 43200 * t), k1 = 1.63e-16, k2 = 4.66e-16, o2 = 3.7e16;
         const double k3 = sun > 0 ? std::exp(-22.62 / sun) : 0, k4 = sun > 0 ? std::exp(-7.601 / sun) : 0;
         f[0] = -k1 * y[0] * o2 - k2 * y[0] * y[1] + 2 * k3 * o2 + k4 * y[1];
         f[1] = k1 * y[0] * o2 - k2 * y[0] * y[1] - k4 * y[1];
       },
       true},
      {"fitzhugh",
       {1, 1},
       100,
       1e-1,
       [](double, C y, D f) {
         f[0] = y[0] - y[0] * y[0] * y[0] / 3 - y[1] + 0.5, f[1] = 0.08 * (y[0] + 0.7 - 0.8 * y[1]);
       }},
      {"lotka",
       {1, 1},
       10,
       1e-1,
       [](double, C y, D f) { f[0] = 1.5 * y[0] - y[0] * y[1], f[1] = -3 * y[1] + y[0] * y[1]; }},
      {"rigid body",
       {1, 0, 0.9},
       20,
       1e-1,
       [](double t, C y, D f) {
         f[0] = -2 * y[1] * y[2], f[1] = 1.25 * y[0] * y[2];
         f[2] = -0.5 * y[0] * y[1] +
                (t >= 3 && t <= 4 ? 0.25 * std::sin(3.141592653589793 * t) * std::sin(3.141592653589793 * t) : 0);
       },
       true},
  };
}

}  // namespace problems

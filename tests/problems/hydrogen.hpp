#pragma once

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <cstddef>
#include <vector>

namespace problems {

/// Hydrogen and air burn at 101325 Pa from 1000 K: 29 reactions of 10 species, to twice the ignition delay. The state is the
/// temperature [K] and the mass fractions. Rates and heats are those of the published mechanism that Cantera has as h2o2.yaml.
struct Hydrogen {
  static constexpr int species = 10;
  using State = Eigen::Matrix<double, species + 1, 1>;
  static constexpr double end = 2 * 0.000312, pressure = 101325, gas_constant = 8314.46261815324;
  /// The temperature at the end, by extrapolation in long double; Cantera's reactor at rtol 1e-12: 2675.38762.
  static constexpr double burnt = 2675.3876199092;

  [[nodiscard]] static State start() {
    State y = State::Zero();
    y[0] = 1000, y[1 + h2] = 0.028522387527567396, y[1 + o2] = 0.22635400697100733, y[1 + n2] = 0.7451236055014252;
    return y;
  }

  State operator()(const State& y) const {
    const double temperature = y[0], inverse = 1 / temperature, logarithm = std::log(temperature);
    std::array<double, species> concentration, enthalpy, gibbs, made{};  // enthalpy and gibbs over R T
    double moles = 0, heat_capacity = 0, all = 0;
    for (std::size_t i = 0; i < species; ++i) moles += fraction(y, i) / thermo()[i].mass;
    const double density = pressure / (gas_constant * temperature * moles);
    for (std::size_t i = 0; i < species; ++i) {
      const Thermo& s = thermo()[i];
      const std::array<double, 7>& a = temperature > 1000 ? s.hot : s.cold;
      double power = 1, capacity = 0, energy = a[5] * inverse, entropy = a[0] * logarithm + a[6];
      for (std::size_t k = 0; k < 5; ++k, power *= temperature) {
        capacity += a[k] * power, energy += a[k] * power / static_cast<double>(k + 1);
        if (k > 0) entropy += a[k] * power / static_cast<double>(k);
      }
      concentration[i] = density * fraction(y, i) / s.mass, all += concentration[i];
      enthalpy[i] = energy, gibbs[i] = energy - entropy, heat_capacity += fraction(y, i) * capacity / s.mass;
    }
    const double standard = pressure / (gas_constant * temperature);
    for (const Reaction& r : reactions()) {
      double forward = r.rate.at(inverse, logarithm), colliders = r.any * all;
      for (const Collider& c : r.colliders) colliders += c.more * concentration[c.which];
      if (r.low.ln_a != 0) forward *= fall_off(r.low.at(inverse, logarithm) * colliders / forward, temperature);
      else if (r.any != 0 || !r.colliders.empty()) forward *= colliders;
      double there = forward, back = forward, free = 0;
      for (const int i : r.from) there *= concentration[at(i)], free += gibbs[at(i)];
      for (const int i : r.to)
        if (i >= 0) back *= concentration[at(i)], free -= gibbs[at(i)];
      const double speed = there - back * std::exp(-free) * (r.to[1] < 0 ? standard : 1);
      for (const int i : r.from) made[at(i)] -= speed;
      for (const int i : r.to)
        if (i >= 0) made[at(i)] += speed;
    }
    State out;
    double heat = 0;
    for (std::size_t i = 0; i < species; ++i) {
      heat += enthalpy[i] * made[i];
      out[static_cast<Eigen::Index>(i) + 1] = made[i] * thermo()[i].mass / density;
    }
    out[0] = -temperature * heat / (density * heat_capacity);
    return out;
  }

 private:
  enum Species { h2, h, o, o2, oh, h2o, ho2, h2o2, ar, n2 };
  /// Polynomials of the heat capacity below and above 1000 K, then the constants of enthalpy and entropy.
  struct Thermo {
    double mass;  ///< [kg/kmol]
    std::array<double, 7> cold, hot;
  };
  /// exp(ln_a) Tᵇ exp(−e/T) [m, kmol, s]
  struct Arrhenius {
    double ln_a = 0, b = 0, e = 0;
    [[nodiscard]] double at(double inverse, double logarithm) const {
      return std::exp(ln_a + b * logarithm - e * inverse);
    }
  };
  struct Collider {
    std::size_t which;
    double more;
  };
  struct Reaction {
    Arrhenius rate;
    std::array<int, 2> from, to;  ///< −1: none
    double any = 0;               ///< efficiency of all colliders; 0 without any: no collider is needed
    std::vector<Collider> colliders = {};
    Arrhenius low = {};  ///< of the low-pressure limit, where the rate falls off
  };

  [[nodiscard]] static std::size_t at(int i) { return static_cast<std::size_t>(i); }
  [[nodiscard]] static double fraction(const State& y, std::size_t i) { return y[static_cast<Eigen::Index>(i) + 1]; }
  /// Troe's form, of the one reaction that has it.
  [[nodiscard]] static double fall_off(double reduced, double temperature) {
    const double centre = std::log10(0.2654 * std::exp(-temperature / 94) + 0.7346 * std::exp(-temperature / 1756) +
                                     std::exp(-5182 / temperature));
    const double x = std::log10(reduced + 1e-300) - 0.4 - 0.67 * centre;
    const double y = x / (0.75 - 1.27 * centre - 0.14 * x);
    return reduced / (1 + reduced) * std::pow(10, centre / (1 + y * y));
  }

  [[nodiscard]] static const std::array<Thermo, species>& thermo() {
    static const std::array<Thermo, species> all{{
        {2.016,
         {2.34433112, 0.00798052075, -1.9478151e-05, 2.01572094e-08, -7.37611761e-12, -917.935173, 0.683010238},
         {3.3372792, -4.94024731e-05, 4.99456778e-07, -1.79566394e-10, 2.00255376e-14, -950.158922, -3.20502331}},
        {1.008,
         {2.5, 7.05332819e-13, -1.99591964e-15, 2.30081632e-18, -9.27732332e-22, 25473.6599, -0.446682853},
         {2.50000001, -2.30842973e-11, 1.61561948e-14, -4.73515235e-18, 4.98197357e-22, 25473.6599, -0.446682914}},
        {15.999,
         {3.1682671, -0.00327931884, 6.64306396e-06, -6.12806624e-09, 2.11265971e-12, 29122.2592, 2.05193346},
         {2.56942078, -8.59741137e-05, 4.19484589e-08, -1.00177799e-11, 1.22833691e-15, 29217.5791, 4.78433864}},
        {31.998,
         {3.78245636, -0.00299673416, 9.84730201e-06, -9.68129509e-09, 3.24372837e-12, -1063.94356, 3.65767573},
         {3.28253784, 0.00148308754, -7.57966669e-07, 2.09470555e-10, -2.16717794e-14, -1088.45772, 5.45323129}},
        {17.007,
         {3.99201543, -0.00240131752, 4.61793841e-06, -3.88113333e-09, 1.3641147e-12, 3615.08056, -0.103925458},
         {3.09288767, 0.000548429716, 1.26505228e-07, -8.79461556e-11, 1.17412376e-14, 3858.657, 4.4766961}},
        {18.015,
         {4.19864056, -0.0020364341, 6.52040211e-06, -5.48797062e-09, 1.77197817e-12, -30293.7267, -0.849032208},
         {3.03399249, 0.00217691804, -1.64072518e-07, -9.7041987e-11, 1.68200992e-14, -30004.2971, 4.9667701}},
        {33.006,
         {4.30179801, -0.00474912051, 2.11582891e-05, -2.42763894e-08, 9.29225124e-12, 294.80804, 3.71666245},
         {4.0172109, 0.00223982013, -6.3365815e-07, 1.1424637e-10, -1.07908535e-14, 111.856713, 3.78510215}},
        {34.014,
         {4.27611269, -0.000542822417, 1.67335701e-05, -2.15770813e-08, 8.62454363e-12, -17702.5821, 3.43505074},
         {4.16500285, 0.00490831694, -1.90139225e-06, 3.71185986e-10, -2.87908305e-14, -17861.7877, 2.91615662}},
        {39.95, {2.5, 0, 0, 0, 0, -745.375, 4.366}, {2.5, 0, 0, 0, 0, -745.375, 4.366}},
        {28.014,
         {3.298677, 0.0014082404, -3.963222e-06, 5.641515e-09, -2.444854e-12, -1020.8999, 3.950372},
         {2.92664, 0.0014879768, -5.68476e-07, 1.0097038e-10, -6.753351e-15, -922.7977, 5.980528}},
    }};
    return all;
  }
  [[nodiscard]] static const std::vector<Reaction>& reactions() {
    static const std::vector<Reaction> all{
        {{25.5107575797285, -1, 0}, {o, o}, {o2, -1}, 1, {{ar, -0.17}, {h2, 1.4}, {h2o, 14.4}}},
        {{26.9378739353686, -1, 0}, {h, o}, {oh, -1}, 1, {{ar, -0.3}, {h2, 1}, {h2o, 5}}},
        {{3.65583960003574, 2.7, 3150.15427970227}, {h2, o}, {h, oh}},
        {{23.7189981105004, 0, 0}, {ho2, o}, {o2, oh}},
        {{9.17263850479217, 2, 2012.87813399506}, {h2o2, o}, {ho2, oh}},
        {{28.6606405331097, -0.86, 0}, {h, o2}, {ho2, -1}, 1, {{ar, -1}, {h2o, -1}, {n2, -1}, {o2, -1}}},
        {{30.6659741026358, -1.24, 0}, {h, o2}, {ho2, -1}, 0, {{o2, 1}}},
        {{30.0522777386401, -0.76, 0}, {h, o2}, {ho2, -1}, 0, {{h2o, 1}}},
        {{30.88911765395, -1.24, 0}, {h, o2}, {ho2, -1}, 0, {{n2, 1}}},
        {{27.2743461719898, -0.8, 0}, {h, o2}, {ho2, -1}, 0, {{ar, 1}}},
        {{30.9081658489207, -0.6707, 8575.36407035247}, {h, o2}, {o, oh}},
        {{27.6310211159285, -1, 0}, {h, h}, {h2, -1}, 1, {{ar, -0.37}, {h2, -1}, {h2o, -1}}},
        {{25.2230755072767, -0.6, 0}, {h, h}, {h2, -1}, 0, {{h2, 1}}},
        {{31.7253656781506, -1.25, 0}, {h, h}, {h2, -1}, 0, {{h2o, 1}}},
        {{37.629818848269, -2, 0}, {h, oh}, {h2o, -1}, 1, {{ar, -0.62}, {h2, -0.27}, {h2o, 2.65}}},
        {{22.1020319316455, 0, 337.660306977672}, {h, ho2}, {h2o, o}},
        {{24.5254739763674, 0, 537.438461776682}, {h, ho2}, {h2, o2}},
        {{25.1540826357897, 0, 319.544403771716}, {h, ho2}, {oh, oh}},
        {{9.40096073158483, 2, 2616.74157419358}, {h, h2o2}, {h2, ho2}},
        {{23.0258509299405, 0, 1811.59032059556}, {h, h2o2}, {h2o, oh}},
        {{12.2830336866663, 1.51, 1726.04299990077}, {h2, oh}, {h, h2o}},
        {{25.0273309301506, -0.37, 0},
         {oh, oh},
         {h2o2, -1},
         1,
         {{ar, -0.3}, {h2, 1}, {h2o, 5}},
         {28.4639302388637, -0.9, -855.473206947902}},
        {{3.57515068878559, 2.4, -1061.7932156824}, {oh, oh}, {h2o, o}},
        {{23.3974144863729, 0, -251.609766749383}, {ho2, oh}, {h2o, o2}},
        {{21.4164130175064, 0, 214.874740803973}, {h2o2, oh}, {h2o, ho2}},
        {{35.0694046459729, 0, 14799.6864801987}, {h2o2, oh}, {h2o, ho2}},
        {{18.6830450084199, 0, -820.247839602988}, {ho2, ho2}, {h2o2, o2}},
        {{26.7635205482238, 0, 6038.63440198519}, {ho2, ho2}, {h2o2, o2}},
        {{29.2404590283627, 0, 8720.79451553361}, {ho2, oh}, {h2o, o2}},
    };
    return all;
  }
};

}  // namespace problems

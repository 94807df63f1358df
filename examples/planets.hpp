// What the solar system example needs beside the stepper: the ephemeris, energy and angular momentum.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <cstdio>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "command_line.hpp"

/// data/planets_de421.txt: GMs, positions and velocities of ten bodies of the solar system, at nine epochs.
struct Ephemeris {
  static constexpr int bodies = 10;
  using Bodies = Eigen::Matrix<double, 3, bodies>;  // one column a body
  struct Epoch {
    double t;  // days since J2000.0
    Bodies r;  // [au], barycentric
    Bodies v;  // [au/day]
  };
  std::vector<std::string> names;
  Eigen::Vector<double, bodies> GM;  // [au³/day²]
  std::vector<Epoch> epochs;

  [[nodiscard]] const char* name(int body) const { return names[static_cast<std::size_t>(body)].c_str(); }
  [[nodiscard]] const Epoch& epoch(Eigen::Index k) const { return epochs[static_cast<std::size_t>(k)]; }
  [[nodiscard]] double years(Eigen::Index k) const { return epoch(k).t / 365.25; }
};

/// Of masses GM: [au⁵/day⁴].
inline double energy(const Ephemeris& bodies, const auto& y) {
  double e = 0.5 * y.v.colwise().squaredNorm().dot(bodies.GM);
  for (int i = 0; i < Ephemeris::bodies; ++i)
    for (int j = i + 1; j < Ephemeris::bodies; ++j) e -= bodies.GM[i] * bodies.GM[j] / (y.r.col(j) - y.r.col(i)).norm();
  return e;
}
/// Of masses GM: [au⁵/day³].
inline Eigen::Vector3d angular_momentum(const Ephemeris& bodies, const auto& y) {
  Eigen::Vector3d L{0, 0, 0};
  for (int i = 0; i < Ephemeris::bodies; ++i)
    L += bodies.GM[i] * Eigen::Vector3d(y.r.col(i)).cross(Eigen::Vector3d(y.v.col(i)));
  return L;
}

#ifdef EXAMPLE_DATA_DIR
inline const std::string default_data = EXAMPLE_DATA_DIR "/planets_de421.txt";
#else
inline const std::string default_data =
    (std::filesystem::path(__FILE__).parent_path() / "data" / "planets_de421.txt").string();
#endif

inline Ephemeris read_ephemeris(const std::string& path) {
  Ephemeris read;
  std::ifstream in(path);
  std::string word;
  for (Eigen::Index body = 0; in >> word;) {
    if (word[0] == '#') {
      std::getline(in, word);
    } else if (word == "gm" && read.names.size() < Ephemeris::bodies) {
      in >> word >> read.GM[static_cast<Eigen::Index>(read.names.size())];
      read.names.push_back(word);
    } else if (word == "epoch") {
      double julian_date = 0;
      in >> julian_date;
      read.epochs.push_back({julian_date - 2451545.0, Ephemeris::Bodies::Zero(), Ephemeris::Bodies::Zero()});
      body = 0;
    } else if (!read.epochs.empty() && body < Ephemeris::bodies && word == read.names[static_cast<std::size_t>(body)]) {
      for (double& x : read.epochs.back().r.col(body)) in >> x;
      for (double& x : read.epochs.back().v.col(body)) in >> x;
      ++body;
    } else {
      CommandLine::stop(path + ": didn't expect \"" + word + '"');
    }
  }
  if (!in.eof() || read.epochs.size() < 2) CommandLine::stop("can't read " + path + " (another place: --data FILE)");
  return read;
}

/// A row a body, a column an epoch after the first.
inline void print_errors(const Ephemeris& bodies, const Eigen::MatrixXd& error) {
  std::printf("%10s", "years");
  for (Eigen::Index e = 0; e < error.cols(); ++e) std::printf(" %9g", bodies.years(e + 1));
  for (int body = 0; body < Ephemeris::bodies; ++body) {
    std::printf("\n%10s", bodies.name(body));
    for (Eigen::Index e = 0; e < error.cols(); ++e) std::printf(" %9.1e", error(body, e));
  }
  std::printf("\n");
}

/// Lines of t, name, x, y, z; the inner planets for a good revolution only.
inline void write_positions(std::ostream& out, const Ephemeris& bodies, double t, const Ephemeris::Bodies& r) {
  if (t == 0) out << "t_day,body,x_au,y_au,z_au\n";
  for (int body = 0; body < Ephemeris::bodies; ++body)
    if (body > 4 || t < 700)
      out << t << ',' << bodies.name(body) << ',' << r(0, body) << ',' << r(1, body) << ',' << r(2, body) << '\n';
}

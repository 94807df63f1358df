// Reads a frame of extended XYZ, as ASE, OVITO and phistep write it, and goes on from there: 108 atoms of argon at 60 K.
//
// read_frame() is the reader: copy it. data/argon_ase.xyz was written by ASE (bulk, MaxwellBoltzmannDistribution, write), in its
// units: Å, eV, u, and so 10.18 fs of time. ASE has momenta, phistep velo.
//
// Run: read_xyz [--short] [--out DIR] [--file FILE]
// Frames: read_xyz.xyz opens in ASE and OVITO
#include <phistep/io.hpp>
#include <phistep/particles.hpp>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <istream>
#include <map>
#include <regex>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "command_line.hpp"

struct Frame {
  Eigen::Matrix3d lattice = Eigen::Matrix3d::Zero();  // vectors as columns; 0: there is none
  std::vector<std::string> species;
  std::map<std::string, Eigen::MatrixXd> columns;  // of numbers, by their names: a column a particle
};

/// The next frame; false where there is none.
bool read_frame(std::istream& in, Frame& frame) {
  std::string line, about;
  if (!std::getline(in, line) || !std::getline(in, about)) return false;
  const auto value_of = [&about](const std::string& key) {  // of key=word or key="some words"
    std::smatch found;
    const std::regex pair("(^|\\s)" + key + "=(\"([^\"]*)\"|\\S+)");
    if (!std::regex_search(about, found, pair)) return std::string{};
    return found[3].matched ? found.str(3) : found.str(2);
  };
  frame = {};
  std::istringstream lattice(value_of("Lattice"));
  for (double& x : frame.lattice.reshaped()) lattice >> x;
  std::string properties = value_of("Properties");  // name:type:width:name:type:width…
  if (properties.empty()) properties = "species:S:1:pos:R:3";
  std::replace(properties.begin(), properties.end(), ':', ' ');

  const long n = std::stol(line);
  for (long j = 0; j < n; ++j) {
    std::getline(in, line);
    std::istringstream row(line), names(properties);
    std::string name, type, word;
    for (long width; names >> name >> type >> width;) {
      auto& column = frame.columns[name];
      if (j == 0 && (type == "R" || type == "I")) column.setZero(width, n);
      for (long i = 0; i < width; ++i)
        if (type == "R" || type == "I") row >> column(i, j);
        else if (row >> word && name == "species") frame.species.push_back(word);
    }
    if (!in || !row) throw std::runtime_error("this is no line of a particle: " + line);
  }
  return true;
}

int main(int argc, char** argv) {
  CommandLine options(argc, argv, {{"--file", EXAMPLE_DATA_DIR "/argon_ase.xyz"}});
  std::ifstream in(options.own["--file"]);
  Frame frame;
  if (!read_frame(in, frame)) CommandLine::stop("there is no frame in " + options.own["--file"]);
  const double m = 39.95, epsilon = 0.0103, sigma = 3.40, k_B = 8.617333e-5;  // [u] [eV] [Å] [eV/K]
  phistep::Particles<double, 3> atoms{frame.columns.at("pos"), frame.columns.at("momenta") / m};
  atoms.set_mass(m).set_box(phistep::Box<double, 3>::periodic({0, 0, 0}, frame.lattice.diagonal()));
  std::printf("%ld atoms of %s, %.1f K\n", long(atoms.size()), frame.species[0].c_str(),
              phistep::temperature(atoms, k_B));

  const double cutoff = 7, t1 = options.is_short ? 5 : 500, dt = 0.5;  // [Å], 10.18 fs
  const phistep::Pairs argon{phistep::LennardJones{.epsilon = epsilon, .sigma = sigma}.shifted(cutoff), cutoff};
  phistep::PhiStepper stepper{atoms, argon, phistep::velocity_verlet};
  auto frames = options.file("read_xyz.xyz");
  const auto report =
      phistep::integrate(stepper, atoms, {0, t1}, phistep::fixed(dt),
                         phistep::every(t1 / 5, phistep::extended_xyz(frames, {.species = {frame.species[0]}})));
  frames.close();

  // What was written is read back: the last frame is the state, to the 9 digits written.
  std::ifstream written(options.out / "read_xyz.xyz");
  int count = 0;
  while (read_frame(written, frame)) ++count;
  const double difference = (frame.columns.at("velo") - atoms.v).cwiseAbs().maxCoeff();
  std::printf("%d frames written and read back, %.1f K\n", count, phistep::temperature(atoms, k_B));
  return report && count == 6 && difference < 1e-8 ? 0 : 1;
}

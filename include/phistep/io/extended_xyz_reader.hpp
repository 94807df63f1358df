/// @file
/// Frames in the extended XYZ format, back into Particles.
///
///     ExtendedXyzReader frames{"melt.xyz"};
///     for (Particles<double, 3> atoms; frames.next(atoms);) …      // frames.time(), frames.species()
///     read_extended_xyz("start.xyz", grains);                      // the first frame alone
///
/// Targets come in any order; those that nothing is known of are skipped. What write_extended_xyz wrote comes back to the
/// digits that it wrote, bit for bit with {.exact = true}. A compressed file: `zcat frames.xyz.gz | program`, and std::cin.
#pragma once

#include <cstdint>
#include <fstream>
#include <istream>
#include <limits>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "phistep/core/version.hpp"
#include "phistep/io/frame_parser.hpp"
#include "phistep/io/text_reader.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// One frame after the other, from a file or a stream.
class ExtendedXyzReader {
 public:
  /// @param species  names of the types 0, 1, …; others get the next number as they come
  explicit ExtendedXyzReader(const std::string& path, std::vector<std::string> species = {})
      : file_{std::make_unique<std::ifstream>(path, std::ios::binary)},
        text_{*file_, path},
        species_{std::move(species)} {
    if (!*file_) throw std::runtime_error("phistep: cannot open " + path);
  }
  explicit ExtendedXyzReader(std::istream& in, std::vector<std::string> species = {}, std::string name = "extended XYZ")
      : text_{in, std::move(name)}, species_{std::move(species)} {}

  /// Reads a frame into the particles, which become what it says: without a column mass theirs are 1, without a Lattice their
  /// box is open. False where the text ends.
  /// @throws std::runtime_error that names the line, where it isn't a frame; the particles are what they were then
  template <class P>
  [[nodiscard]] bool next(P& particles) {
    do
      if (!text_.next_line()) return false;
    while (text_.skip_blanks());
    const auto n = text_.number<std::int64_t>("the number of particles");
    if (n < 0) text_.fail("there can't be fewer than 0 particles");
    text_.end_line();
    std::vector<std::string> species = species_;
    FrameParser<P> frame{text_, species};
    P read = frame.read(n);
    particles = std::move(read);
    species_ = std::move(species);
    time_ = frame.time();
    return true;
  }
  /// Of the last frame; NaN where it says none. [time]
  [[nodiscard]] double time() const { return time_; }
  /// The names of types, in the order of their numbers.
  [[nodiscard]] const std::vector<std::string>& species() const { return species_; }

 private:
  std::unique_ptr<std::ifstream> file_;
  TextReader text_;
  std::vector<std::string> species_;
  double time_ = std::numeric_limits<double>::quiet_NaN();
};

/// The next frame of a stream (lines are counted from here), or the first of a file; false where there is none. Returns its
/// time by `time`, if that is given.
template <class P>
bool read_extended_xyz(std::istream& in, P& particles, double* time = nullptr) {
  ExtendedXyzReader reader{in};
  if (!reader.next(particles)) return false;
  if (time != nullptr) *time = reader.time();
  return true;
}
/// @throws std::runtime_error where the file can't be opened, or has no frame
template <class P>
void read_extended_xyz(const std::string& path, P& particles, double* time = nullptr) {
  ExtendedXyzReader reader{path};
  if (!reader.next(particles)) throw std::runtime_error("phistep: there is no frame in " + path);
  if (time != nullptr) *time = reader.time();
}

}}  // namespace phistep::PHISTEP_ABI

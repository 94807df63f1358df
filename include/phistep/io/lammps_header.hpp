/// @file
/// The lines of a LAMMPS data file, and what its header says.
#pragma once

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <string>
#include <string_view>
#include <vector>

#include "phistep/core/version.hpp"
#include "phistep/io/text_reader.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// Lines with comments behind #.
class LammpsText : public TextReader {
 public:
  using TextReader::TextReader;

  /// The next line that isn't blank, without its comment.
  bool next() {
    while (next_line()) {
      std::string_view line = rest();
      comment_ = {};
      if (const auto hash = line.find('#'); hash != line.npos) {
        comment_ = line.substr(hash + 1);
        line = line.substr(0, hash);
      }
      while (!line.empty() && std::isspace(static_cast<unsigned char>(line.back()))) line.remove_suffix(1);
      set_rest(line);
      if (!skip_blanks()) return true;
    }
    return false;
  }
  [[nodiscard]] bool starts_section() const { return std::isalpha(static_cast<unsigned char>(rest().front())); }
  /// The first word of the last line's comment; empty where there is none.
  [[nodiscard]] std::string_view first_of_comment() const {
    std::string_view word = comment_;
    while (!word.empty() && std::isspace(static_cast<unsigned char>(word.front()))) word.remove_prefix(1);
    return word.substr(0, word.find_first_of(" \t"));
  }

 private:
  std::string_view comment_;
};

/// How many lines the sections have, and the box.
template <class Scalar>
struct LammpsHeader {
  std::int64_t atoms = -1, types = 0, bonds = 0, bond_types = 0;
  std::array<Scalar, 3> lower{Scalar(-0.5), Scalar(-0.5), Scalar(-0.5)};  ///< LAMMPS' own
  std::array<Scalar, 3> upper{Scalar(0.5), Scalar(0.5), Scalar(0.5)};

  /// Reads one line.
  void take(LammpsText& text) {
    // Numbers, then words that say what they are.
    std::vector<std::string_view> values;
    while (!text.skip_blanks() && !std::isalpha(static_cast<unsigned char>(text.rest().front())))
      values.push_back(text.word());
    std::string key;
    while (!text.skip_blanks()) (key += key.empty() ? "" : " ") += text.word();
    const auto needs = [&](std::size_t n) {
      if (values.size() != n) text.fail(std::to_string(n) + " number(s) should stand before \"" + key + '"');
    };
    const auto count = [&](std::int64_t& to) {
      needs(1);
      to = text.as_number<std::int64_t>(values[0], key.c_str());
      if (to < 0) text.fail("there can't be fewer than 0 " + key);
    };
    static constexpr std::string_view sides[] = {"xlo xhi", "ylo yhi", "zlo zhi"};
    static constexpr std::string_view others[] = {"angles",
                                                  "dihedrals",
                                                  "impropers",
                                                  "angle types",
                                                  "dihedral types",
                                                  "improper types",
                                                  "ellipsoids",
                                                  "lines",
                                                  "triangles",
                                                  "bodies",
                                                  "extra bond per atom",
                                                  "extra angle per atom",
                                                  "extra dihedral per atom",
                                                  "extra improper per atom",
                                                  "extra special per atom"};
    if (key == "atoms") count(atoms);
    else if (key == "atom types") count(types);
    else if (key == "bonds") count(bonds);
    else if (key == "bond types") count(bond_types);
    else if (const auto side = std::find(std::begin(sides), std::end(sides), key); side != std::end(sides)) {
      needs(2);
      const auto a = static_cast<std::size_t>(side - std::begin(sides));
      lower[a] = text.as_number<Scalar>(values[0], "lower side");
      upper[a] = text.as_number<Scalar>(values[1], "upper side");
      if (!(upper[a] > lower[a]) || !std::isfinite(upper[a] - lower[a]))
        text.fail("the box has no extent, or none that numbers hold: " + key);
    } else if (key == "xy xz yz") {
      needs(3);
      for (const std::string_view tilt : values)
        if (text.as_number<Scalar>(tilt, "tilt") != 0) text.fail("a box with a tilt isn't known here");
    } else if (std::find(std::begin(others), std::end(others), key) == std::end(others)) {
      text.fail("nothing is known of \"" + key + '"');
    }
  }
};

}}  // namespace phistep::PHISTEP_ABI

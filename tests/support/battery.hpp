#pragma once

// A battery runs many members of one family and counts those that come out wrong. What the library gets wrong today is known: a
// battery names the count, which may fall and not rise, and the issue that is to make it 0.
//
//     const battery::Tally& tally() {                                   // run once, looked at twice
//       static const battery::Tally counted = run_all();
//       return counted;
//     }
//     TEST_CASE("mechanisms: no more are wrong than known") { battery::at_most(3, tally()); }
//     TEST_CASE("mechanisms: none is wrong", "[!shouldfail][46-A]") { battery::none(tally()); }
//
// [!shouldfail] turns red when the second holds: then take the tag away, and the first case with it.

#include <string>
#include <utility>
#include <vector>

#include "support/figures.hpp"

namespace battery {

/// What a battery counted. Wrong: a result beyond what was allowed that says success, or a failure where success is due.
struct Tally {
  std::string name;
  int members = 0, wrong = 0;
  std::vector<std::string> examples = {};  // of the wrong ones, the first few

  void right() { ++members; }
  void wrong_one(std::string what) {
    ++members;
    ++wrong;
    if (examples.size() < 12) examples.push_back(std::move(what));
  }
  void count(bool is_right, const std::string& what) { is_right ? right() : wrong_one(what); }
};

/// At most as many as known are wrong; prints the count and examples.
inline void at_most(int known_wrong, const Tally& tally) {
  const std::string quantity = "wrong of " + std::to_string(tally.members);
  for (const std::string& example : tally.examples) figures::progress(tally.name + ": " + example);
  REQUIRE(tally.members > 0);
  figures::at_most(known_wrong, tally.wrong, tally.name, quantity);
}
inline void none(const Tally& tally) {
  CAPTURE(tally.name, tally.examples);
  CHECK(tally.wrong == 0);
}

}  // namespace battery

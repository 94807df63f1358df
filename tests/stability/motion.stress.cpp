// The atlas for motion: pairs, stages, Verlet and what is made of it. motion_stiff.stress.cpp has the stiff schemes.

#include <phistep/phistep.hpp>

#include <cmath>
#include <map>
#include <string>
#include <vector>

#include "stability/motion_survey.hpp"

using namespace stability::motion;

namespace {

const std::vector<Entry>& all() {
  static const std::vector<Entry> entries = [] {
    std::vector<Entry> made;
    subjects::add_pairs(made);
    subjects::add_verlet(made);
    subjects::add_compositions(made);
    subjects::add_nystrom(made);
    return made;
  }();
  return entries;
}

}  // namespace

TEST_CASE("atlas, motion: no cell of a pair, a composition or a Nystrom pair is unexplained") {
  survey(all(), "atlas, motion: every cell as theory says");
}

TEST_CASE("atlas, motion: how far an oscillation doesn't grow") {
  // Of the compositions: from the traces of their published coefficients' shears, evaluated elsewhere.
  const std::map<std::string, double> known{{"velocity_verlet", 2},       {"symplectic_euler", 2},
                                            {"srkn6b", 3.16346},          {"srkn11b", 3.14143},
                                            {"forward_euler", 0},         {"composed(velocity_verlet)", 3.09644},
                                            {"backward_euler", HUGE_VAL}, {"trapezoidal", HUGE_VAL}};
  for (const Entry& entry : all()) {
    const auto found = known.find(entry.subject.name);
    read_off(entry.subject, found == known.end() ? NAN : found->second);
  }
}

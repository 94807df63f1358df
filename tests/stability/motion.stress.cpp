// The atlas for motion: pairs, stages, Verlet and what is made of it. motion_stiff.stress.cpp has the stiff schemes.

#include <phistep/phistep.hpp>

#include <cmath>
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
  for (const Entry& entry : all())
    read_off(entry.subject,
             entry.subject.name == "velocity_verlet" || entry.subject.name == "symplectic_euler" ? 2 : NAN);
}

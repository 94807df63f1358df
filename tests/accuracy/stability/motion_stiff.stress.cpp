// The atlas for motion, stiff schemes and explicit Runge-Kutta: TR-BDF2, Rannacher's start, Rosenbrock, Radau.

#include <phistep/phistep.hpp>

#include <vector>

#include "accuracy/stability/motion_survey.hpp"

using namespace stability::motion;

namespace {

const std::vector<Entry>& all() {
  static const std::vector<Entry> entries = [] {
    std::vector<Entry> made;
    subjects::add_two_solves(made);
    subjects::add_rosenbrock(made);
    subjects::add_radau(made);
    subjects::add_runge_kutta(made);
    return made;
  }();
  return entries;
}

}  // namespace

TEST_CASE("atlas, motion, stiff schemes: no cell is unexplained") {
  survey(all(), "atlas, motion, stiff: every cell as theory says");
}

TEST_CASE("atlas, motion, stiff schemes: how far an oscillation doesn't grow") {
  for (const Entry& entry : all()) read_off(entry.subject);
}

// lammps_data: the full product and what is dear to compile. The quick half is lammps_data.test.cpp.
#include "io/lammps_data_cases.hpp"

using namespace lammps_data_cases;

TEST_CASE("in the plane, and in float") {
  const std::string text =
      "grains\r\n1 atoms\r\n1 atom types\r\n-4 4 xlo xhi\r\n\r\nAtoms # sphere\r\n\r\n1 1 3 2.5 0.1 3 0\r\n\r\n"
      "Velocities\r\n\r\n1 1 2 0 0 0 6\r\n";
  const auto discs = read_as<Particles<float, 2, Spin>>(text).atoms;
  CHECK((discs.r.col(0) == Eigen::Vector2f(0.1F, 3)));
  CHECK(discs.omega(0, 0) == 6);
  CHECK(discs.box().lower == Eigen::Vector2f(-4, -0.5F));
}

TEST_CASE("a malformed data file is told by its name, the line, and what is wrong there") {
  const std::string head = "t\n2 atoms\n1 atom types\n\n", start = head + "Atoms # atomic\n\n",
                    atoms = start + "1 1 0 0 0\n2 1 1 1 1\n\n";
  struct Case {  // pointers alone: a hundred strings take seconds to compile
    const char *before, *text;
    int line;
    const char* why;
  };
  const std::vector<Case> cases{
      {"", "", 0, "empty"},
      {"", "t\nx atoms\n", 2, "how many atoms"},
      {"", "t\n1 atom types\n\nAtoms\n", 4, "how many atoms"},
      {"", "t\n1.5 atoms\n", 2, "whole number"},
      {"", "t\n-1 atoms\n", 2, "fewer than 0"},
      {"", "t\n1 2 atoms\n", 2, "1 number(s) should stand before"},
      {"", "t\n99999999999999999999 atoms\n", 2, "too large"},
      {"", "t\n5 apples\n", 2, "nothing is known of \"apples\""},
      {"", "t\n1 xlo xhi\n", 2, "2 number(s)"},
      {"", "t\n1 1 xlo xhi\n", 2, "no extent"},
      {"", "t\n0 1e999 xlo xhi\n", 2, "too large"},
      {"", "t\n-1.7e308 1.7e308 xlo xhi\n", 2, "no extent"},
      {"", "t\n1 atoms\n3000000000000 atom types\n\nMasses\n\n1 1\n\nAtoms\n", 9,
       "Masses ends after 1 of 3000000000000"},
      {"", "t\n1 atoms\n1 atom types\n\nAtoms # sphere\n\n1 1 1e120 1 0 0 0\n", 7, "numbers can't hold"},
      {"", "t\n1 atoms\n1 atom types\n\nAtoms # sphere\n\n1 1 1e-120 1 0 0 0\n", 7, "numbers can't hold"},
      {start.c_str(), "9223372036854775807 1 0 0 0\n", 7, "an id must be > 0 and < 2^62"},
      {atoms.c_str(), "Velocities\n\n-9223372036854775808 0 0 0\n", 12, "there is no atom"},
      {"", "t\n0 0 0.5 xy xz yz\n", 2, "tilt"},
      {head.c_str(), "", 4, "Atoms is missing"},
      {head.c_str(), "Atom\n", 5, "\"Atom\" is no section"},
      {head.c_str(), "Velocities\n\n1 0 0 0\n", 5, "before Atoms"},
      {head.c_str(), "Atoms # dipole\n\n1", 5, "atom style dipole"},
      {start.c_str(), "1 1 0 0 0\n", 7, "Atoms ends after 1 of 2"},
      {start.c_str(), "1 1 0 0 0\n\nVelocities\n", 9, "Atoms ends after 1 of 2"},
      {atoms.c_str(), "3 1 1 1 1\n", 10, "more than the 2 lines"},
      {atoms.c_str(), "Atoms # atomic\n", 10, "a second section Atoms"},
      {start.c_str(), "1 1 0 0\n2 1 1 1 1\n", 7, "the line ends where coordinate"},
      {start.c_str(), "1 1 0 0 O\n2 1 1 1 1\n", 7, "not \"O\""},
      {start.c_str(), "1 1 0 0 1x\n2 1 1 1 1\n", 7, "not \"1x\""},
      {start.c_str(), "1 1 0 0 nan\n2 1 1 1 1\n", 7, "not finite"},
      {start.c_str(), "1 1 0 0 1e999\n2 1 1 1 1\n", 7, "too large"},
      {start.c_str(), "1 1 0 0 0 1 1\n", 7, "the line ends where image flag"},
      {start.c_str(), "1 1 0 0 0 1 1 1 1\n", 7, "nothing should follow"},
      {start.c_str(), "1 2 0 0 0\n", 7, "type 2 isn't one of 1 … 1"},
      {start.c_str(), "1 0 0 0 0\n", 7, "type 0"},
      {start.c_str(), "0 1 0 0 0\n", 7, "id must be > 0"},
      {start.c_str(), "2 1 0 0 0\n2 1 1 1 1\n", 8, "a second atom 2"},
      {atoms.c_str(), "Velocities\n\n1 0 0 0\n3 0 0 0\n", 13, "there is no atom 3"},
      {atoms.c_str(), "Velocities\n\n1 0 0 0\n1 0 0 0\n", 13, "a second velocity of atom 1"},
      {atoms.c_str(), "Velocities\n\n1 0 0 0\n2 0 0 0 0\n", 13, "nothing should follow"},
      {atoms.c_str(), "Masses\n\n1 0\n", 12, "mass must be > 0"},
      {atoms.c_str(), "Masses\n\n", 11, "Masses ends after 0 of 1"},
      {atoms.c_str(), "Bonds\n\n1 1 1 2\n", 12, "more than the 0 lines"},
      {"", "t\n1 atoms\n1 bonds\n1 bond types\n1 atom types\nAtoms # bond\n\n5 1 1 0 0 0\n\nBonds\n\n1 1 5 5\n", 12,
       "with itself"},
      {head.c_str(), "Atoms # sphere\n\n1 1 0 1 0 0 0\n", 7, "diameter must be > 0"},
  };
  const auto check = [](const std::string& text, int line, const char* why) {
    CAPTURE(text);
    CHECK_THROWS_AS(read(text), std::runtime_error);
    CHECK_THROWS_WITH(read(text), contains("melt.data, line " + std::to_string(line) + ":") && contains(why));
  };
  for (const Case& one : cases) check(std::string(one.before) + one.text, one.line, one.why);
  check(head + std::string(3, '\0') + "\x01\x02", 5, "nothing is known");
  CHECK_THROWS_WITH((read_as<Particles<double, 2>>(start + "1 1 0 0 3\n")), contains("line 7") && contains("plane"));
  CHECK_THROWS_WITH(read(atoms, {.style = "charge"}), contains("line 5") && contains("atomic, not charge"));
  CHECK_THROWS_WITH(read_lammps_data("no/such.data"), contains("no/such.data"));
}

// extended_xyz_reader: the full product and what is dear to compile. The quick half is extended_xyz_reader.test.cpp.
#include "io/extended_xyz_reader_cases.hpp"

using namespace extended_xyz_reader_cases;

TEMPLATE_TEST_CASE("a frame of Particles comes back bit for bit", "", double, float) {
  const auto y = grains<TestType>();
  std::stringstream file;
  write_extended_xyz(file, 0.1, y, {.species = {"X"}, .exact = true});
  Grains<TestType> back;
  double time = 0;
  REQUIRE(read_extended_xyz(file, back, &time));
  check_equal(y, back);
  CHECK((y.omega == back.omega));
  CHECK((y.temperature == back.temperature));
  CHECK(time == 0.1);
  CHECK_FALSE(read_extended_xyz(file, back));
}

TEST_CASE("an open box has no lattice; discs turn by one number") {
  Particles<double, 2, Spin> y{Eigen::Matrix2d{{1, 2}, {3, 4}}};
  y.set_radius(0.5).set_mass(2);
  y.omega << 7, 8;
  std::stringstream out;
  extended_xyz(out)(0.0, y);
  CHECK(out.str() ==
        "2\npbc=\"F F F\" inertia_factor=0.4 "
        "Properties=species:S:1:pos:R:3:velo:R:3:id:I:1:mass:R:1:radius:R:1:omega:R:1 "
        "Time=0\nX 1 3 0 0 0 0 0 2 0.5 7\nX 2 4 0 0 0 0 1 2 0.5 8\n");
  Particles<double, 2, Spin> back;
  CHECK(read_extended_xyz(out, back));
  check_equal(y, back);
  CHECK((back.omega == y.omega));
}

TEST_CASE("a malformed frame is told by its name, the line and what is wrong there, and leaves the particles alone") {
  const std::string first = "1\nTime=1\nX 0 0 0\n", p = "Properties=species:S:1:pos:R:3";
  const std::string one_p = "1\n" + p, two_p = "2\n" + p;
  struct Case {
    const char *before, *text;  // pointers alone: a hundred strings take seconds to compile
    int line;
    const char* why;
  };
  const std::vector<Case> cases{
      {"", "two\n", 4, "should be a whole number, not \"two\""},
      {"", "-2\n", 4, "fewer than 0"},
      {"", "2 3\n", 4, "nothing should follow"},
      {"", "2", 4, "second line"},
      {"", "99999999999\n\nX 0 0 0\n", 6, "after 1 of 99999999999"},
      {"", "2\n\nX 0 0 0\n", 6, "after 1 of 2"},
      {"", "1\n\nX 0 0\n", 6, "the line ends where pos"},
      {"", "1\n\nX 0 0 0 0\n", 6, "nothing should follow"},
      {"", "1\n\nX 0 0 zero\n", 6, "not \"zero\""},
      {"", "1\n\nX 0 0 nan\n", 6, "not finite"},
      {"", "1\n\nX 0 0 0x1\n", 6, "not \"0x1\""},
      {"", "1\n\nX 0 0 +-1\n", 6, "not \"+-1\""},
      {"", "1\n\n\n", 6, "the line ends where species"},
      {"", "1\nProperties=species:S:1\nX\n", 5, "no positions"},
      {"", "1\nProperties=pos:R\n", 5, "the width"},
      {"", "1\nProperties=pos:Q:3\n", 5, "types S, R, I, L"},
      {"", "1\nProperties=pos:S:3\n", 5, "can't be of type S"},
      {"", "1\nProperties=pos:R:2\n", 5, "needs 3 columns"},
      {"", "1\nProperties=pos:R:0\n", 5, "name:type:width"},
      {one_p.c_str(), ":pos:R:3\n", 5, "pos twice"},
      {one_p.c_str(), ":id:R:1\n", 5, "can't be of type R"},
      {"", "1\nTime=soon\n", 5, "Time should be a number"},
      {"", "1\nLattice=\"1 0 0 0 1 0 0 0 1\n", 5, "has no end"},
      {"", "1\nLattice=\"1 0 0 0 1 0 0 0\"\n", 5, "the line ends where Lattice"},
      {"", "1\nLattice=\"1 0 0 0.5 1 0 0 0 1\"\n", 5, "leaning"},
      {"", "1\nLattice=\"1 0 0 0 -1 0 0 0 1\"\n", 5, "no extent"},
      {"", "1\npbc=\"T T T\"\n", 5, "pbc without a Lattice"},
      {"", "1\npbc=\"F F maybe\"\n", 5, "three of T and F"},
      {one_p.c_str(), ":radius:R:1\nX 0 0 0 0\n", 6, "radius must be > 0"},
      {one_p.c_str(), ":mass:R:1\nX 0 0 0 -1\n", 6, "mass must be > 0"},
      {one_p.c_str(), ":type_index:I:1\nX 0 0 0 -1\n", 6, "type_index can't be -1"},
      {one_p.c_str(), ":id:I:1\nX 0 0 0 1.5\n", 6, "whole number"},
      {two_p.c_str(), ":id:I:1\nX 0 0 0 7\nX 0 0 1 7\n", 5, "two particles have the id 7"},
  };
  for (const Case& one : cases) {
    CAPTURE(one.before, one.text);
    std::istringstream in(first + one.before + one.text);
    ExtendedXyzReader frames{in, {}, "grains.xyz"};
    Atoms y;
    REQUIRE(frames.next(y));
    y.set_mass(3);
    const auto* body = &y.body();
    std::string said;
    try {
      (void)frames.next(y);
    } catch (const std::runtime_error& error) {
      said = error.what();
    }
    CHECK_THAT(said, contains("grains.xyz, line " + std::to_string(one.line) + ":") && contains(one.why));
    CHECK((y.size() == 1 && &y.body() == body && frames.time() == 1));
  }
  std::istringstream in("1\n\nX 0 0 1\n");
  Particles<double, 2> plane;
  CHECK_THROWS_WITH(read_extended_xyz(in, plane), contains("line 3") && contains("plane"));
  CHECK_THROWS_WITH(read_extended_xyz("no/such.xyz", plane), contains("no/such.xyz"));
}

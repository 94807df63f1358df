#include "io/extended_xyz_reader_cases.hpp"

using namespace extended_xyz_reader_cases;

TEMPLATE_TEST_CASE("a frame of Particles comes back bit for bit", "", double) { check_round_trip<TestType>(); }

TEST_CASE("with nine digits, what was read writes the same text") {
  std::stringstream first, second;
  auto write = extended_xyz(first);
  write(1.5, grains<double>());
  Grains<double> back;
  std::istringstream in(first.str());
  CHECK(read_extended_xyz(in, back));
  extended_xyz(second)(1.5, back);
  CHECK(first.str() == second.str());
  CHECK((back.r - grains<double>().r).cwiseAbs().maxCoeff() <= 5e-10);  // |r| < 1
}

TEST_CASE("a frame of plain particles: box, species by type, ids; positions wrapped if wanted") {
  Atoms y{Eigen::Matrix<double, 3, 2>{{0.5, 11.5}, {-1, 2}, {0, 0}}};
  y.set_type(Eigen::Vector2i(1, 0)).set_box(Box<double, 3>::periodic({0, 0, 0}, {10, 4, 4}));
  std::ostringstream out;
  auto write = extended_xyz(out, {.species = {"Ar", "Kr"}, .wrapped = true}, column("f", Eigen::Vector2d(1, 2)));
  write(2.0, y);
  CHECK(out.str() ==
        "2\nLattice=\"10 0 0 0 4 0 0 0 4\" Origin=\"0 0 0\" pbc=\"T T T\" "
        "Properties=species:S:1:pos:R:3:velo:R:3:id:I:1:type_index:I:1:f:R:1 Time=2\n"
        "Kr 0.5 3 0 0 0 0 0 1 1\nAr 1.5 2 0 0 0 0 1 0 2\n");
  y.set_type(Eigen::Vector2i(1, 2));
  CHECK_THROWS_AS(write(2.0, y), std::invalid_argument);
}

TEST_CASE("columns in any order, with some that nothing is known of") {
  const auto y = read<Atoms>(
      "2\r\nsome words Properties=forces:R:3:radius:R:1:vel:R:3:name:S:2:pos:R:3:fixed:L:1:id:I:1 "
      "Lattice=\"2 0 0 0 3 0 0 0 4\" title='a \"b\" c' e=-1.5 pbc=\"T 0 true\"\r\n"
      "1 2 3 0.5 4 5 6 a b 7 8 9 T 5\r\n-1 -2 -3 0.25 -4 -5 -6 c d -7 -8 -9 F 4\r\n\r\n");
  CHECK((y.r == Eigen::Matrix<double, 3, 2>{{7, -7}, {8, -8}, {9, -9}}));
  CHECK((y.v == Eigen::Matrix<double, 3, 2>{{4, -4}, {5, -5}, {6, -6}}));
  CHECK((y.radius() == Eigen::Vector2d(0.5, 0.25)));
  CHECK(y.id() == std::vector<std::int64_t>{5, 4});
  CHECK(y.box().upper == Eigen::Vector3d(2, 3, 4));
  CHECK(y.box().is_periodic == std::array<bool, 3>{true, false, true});
  CHECK(y.type().size() == 0);
}

TEST_CASE("a plain XYZ file") {
  const auto y = read<Atoms>("2\nwater, don't drink\nO 1 2 3\nH 4 5 6\n");
  CHECK((y.r.col(1) == Eigen::Vector3d(4, 5, 6)));
  CHECK(y.v.isZero(0));
  CHECK((y.type() == Eigen::Vector2i(0, 1)));
  CHECK(y.box().is_open());
}

TEST_CASE("frame after frame: numbers of particles change, species keep their numbers") {
  std::istringstream in("1\nTime=1\nO 0 0 0\n2\nTime=2\nH 0 0 0\nO 0 0 1\n0\nno time\n");
  ExtendedXyzReader frames{in};
  Atoms y;
  REQUIRE(frames.next(y));
  CHECK((frames.time() == 1 && y.size() == 1));
  REQUIRE(frames.next(y));
  CHECK((frames.time() == 2 && y.type() == Eigen::Vector2i(1, 0)));
  CHECK(frames.species() == std::vector<std::string>{"O", "H"});
  REQUIRE(frames.next(y));
  CHECK((std::isnan(frames.time()) && y.size() == 0));
  CHECK_FALSE(frames.next(y));
}

TEST_CASE("named types have the numbers that the caller gives them") {
  std::istringstream in("2\n\nKr 0 0 0\nHe 1 1 1\n");
  ExtendedXyzReader frames{in, {"Ar", "Kr"}};
  Atoms y;
  REQUIRE(frames.next(y));
  CHECK((y.type() == Eigen::Vector2i(1, 2)));
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
  Atoms none;
  CHECK_THROWS_WITH(read_extended_xyz("no/such.xyz", none), contains("no/such.xyz"));
}

TEST_CASE("a frame cut anywhere throws or has lost nothing but the end of its last number") {
  std::stringstream whole;
  extended_xyz(whole)(1.5, grains<double>());
  const std::string text = whole.str();
  for (std::size_t n = 1; n < text.size(); ++n) {
    std::istringstream in(text.substr(0, n));
    Grains<double> y;
    try {
      const bool found = read_extended_xyz(in, y);
      CHECK(found);
      CHECK(y.size() == 5);
    } catch (const std::runtime_error& error) {
      CHECK_THAT(error.what(), contains("line "));
      CHECK(y.size() == 0);
    }
  }
}

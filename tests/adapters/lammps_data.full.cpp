// The reader of LAMMPS data files, adapters/lammps/read_data.hpp.
#include <Eigen/Core>

#include <numbers>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "../../adapters/lammps/read_data.hpp"
#include "support/catch.hpp"

using namespace phistep;

namespace {
auto read(const std::string& text, LammpsOptions options = {}) {
  std::istringstream in(text);
  return read_lammps_data(in, options, "melt.data");
}
template <class P>
auto read_as(const std::string& text, LammpsOptions options = {}) {
  std::istringstream in(text);
  return read_lammps_data<P>(in, options, "melt.data");
}

const std::string atomic =
    "LAMMPS data file via write_data\n\n3 atoms\n2 atom types\n\n-1 2.5 xlo xhi\n0 4 ylo yhi # a comment\n0 5 zlo "
    "zhi\n\n"
    "Masses\n\n1 39.95\n2 83.8  # Kr\n\nPair Coeffs # lj/cut\n\n1 1 1\n2 1 1\n\n"
    "Atoms # atomic\n\n7 2 0.5 1 1.5 0 1 -2\n2 1 1e-1 +2 3 0 0 0\n3 1 1 1 1 0 0 0\n\n"
    "Velocities\n\n3 0 0 0\n2 -1 2 -3\n7 .5 .25 .125\n";
}  // namespace

TEST_CASE("atomic: by increasing id, with masses, types, images, velocities and the box") {
  auto data = read(atomic);
  const auto& atoms = data.atoms;
  CHECK(atoms.id() == std::vector<std::int64_t>{2, 3, 7});
  CHECK((atoms.r == (Eigen::Matrix3d() << 0.1, 1, 0.5, 2, 1, 1, 3, 1, 1.5).finished()));
  CHECK((atoms.v == (Eigen::Matrix3d() << -1, 0, 0.5, 2, 0, 0.25, -3, 0, 0.125).finished()));
  CHECK((atoms.type() == Eigen::Vector3i(0, 0, 1)));
  CHECK((atoms.mass() == Eigen::Vector3d(39.95, 39.95, 83.8)));
  CHECK(atoms.radius().size() == 0);
  CHECK(atoms.charge().size() == 0);
  CHECK(atoms.box() == Box<double, 3>::periodic({-1, 0, 0}, {2.5, 4, 5}));
  CHECK(data.type_mass == std::vector<double>{39.95, 83.8});
  CHECK(data.molecule.empty());
  CHECK((data.image.col(2) == Eigen::Vector3i(0, 1, -2)));
  data.unwrap();
  CHECK((data.atoms.r.col(2) == Eigen::Vector3d(0.5, 5, -8.5)));
  data.unwrap();  // once
  CHECK((data.atoms.r.col(2) == Eigen::Vector3d(0.5, 5, -8.5)));
}

TEST_CASE("an id beyond those of the file goes to a particle that is added") {
  auto atoms = read(atomic).atoms;
  atoms.add(atoms);
  CHECK(atoms.id() == std::vector<std::int64_t>{2, 3, 7, 8, 9, 10});
}

TEST_CASE("ids of one's own are all different, one a particle") {
  Particles<double, 3> atoms{Eigen::Matrix3Xd::Zero(3, 2)};
  atoms.set_id({5, -1});
  CHECK_THROWS_WITH(atoms.set_id({4, 4}), contains("the id 4"));
  CHECK_THROWS_WITH(atoms.set_id({1, 2, 3}), contains("3 ids for 2"));
  CHECK(atoms.id() == std::vector<std::int64_t>{5, -1});
}

TEST_CASE("which axes are periodic is the caller's to say") {
  CHECK(read(atomic, {.periodic = {true, false, true}}).atoms.box().is_periodic ==
        std::array<bool, 3>{true, false, true});
}

TEST_CASE("sphere: radii, masses from densities, angular velocities") {
  const std::string text =
      "grains\n1 atoms\n1 atom types\n\nAtoms # sphere\n\n1 1 3 2.5 0 0 1\n\nVelocities\n\n1 1 2 3 4 5 6\n";
  const auto grains = read_as<Particles<double, 3, Spin>>(text).atoms;
  CHECK(grains.radius()[0] == 1.5);
  CHECK(grains.mass()[0] == Approx(2.5 * 4 / 3 * std::numbers::pi * 3.375).epsilon(1e-15));
  CHECK((grains.omega.col(0) == Eigen::Vector3d(4, 5, 6)));
  CHECK(read(text).atoms.v.col(0) == Eigen::Vector3d(1, 2, 3));  // where they don't turn
  // LAMMPS' own box where the file has none
  CHECK(grains.box() == Box<double, 3>::periodic(Eigen::Vector3d::Constant(-0.5), Eigen::Vector3d::Constant(0.5)));
}

TEST_CASE("charge, bond and full; bonds as pairs of columns") {
  const auto ions = read("ions\n2 atoms\n1 atom types\n\nAtoms # charge\n\n2 1 -1 0 0 1\n1 1 1 0 0 0\n").atoms;
  CHECK((ions.charge() == Eigen::Vector2d(1, -1)));
  CHECK((ions.mass() == Eigen::Vector2d(1, 1)));
  const std::string rest = "\n\nBonds\n\n1 2 9 5\n2 1 5 4\n\nAngles\n\n1 1 9 5 4\n";
  const std::string head =
      "net\n3 atoms\n1 atom types\n2 bonds\n2 bond types\n1 angles\n1 angle types\n2 extra bond per atom\n\n";
  const auto check = [](const auto& net) {
    REQUIRE(net.bonds.size() == 2);
    CHECK((net.bonds[0].i == 2 && net.bonds[0].j == 1 && net.bonds[0].type == 1));
    CHECK((net.bonds[1].i == 1 && net.bonds[1].j == 0 && net.bonds[1].type == 0));
    CHECK(net.molecule == std::vector<std::int64_t>{70, 71, 71});
  };
  check(read(head + "Atoms # bond\n\n4 70 1 0 0 0\n5 71 1 0 0 1\n9 71 1 0 0 2" + rest));
  const auto full = read(head + "Atoms # full\n\n4 70 1 .5 0 0 0\n5 71 1 -.5 0 0 1\n9 71 1 0 0 0 2" + rest);
  check(full);
  CHECK((full.atoms.charge() == Eigen::Vector3d(0.5, -0.5, 0)));
}

TEST_CASE("a style that the file doesn't say comes from the caller, or is atomic") {
  const std::string head = "x\n1 atoms\n1 atom types\n\nAtoms\n\n";
  CHECK((read(head + "1 1 1 2 3\n").atoms.r.col(0) == Eigen::Vector3d(1, 2, 3)));
  CHECK(read(head + "1 1 2 3 1 2 3 0 0 0\n", {.style = "sphere"}).atoms.radius()[0] == 1);
  CHECK_THROWS_WITH(read(head + "1 1 2 3 1 2 3\n"), contains("line 7") && contains("image flag"));
}

TEST_CASE("no atoms") { CHECK(read("empty\n\n0 atoms\n").atoms.size() == 0); }

TEST_CASE("a malformed data file is told by its name, the line, and what is wrong there") {
  const std::string head = "t\n2 atoms\n1 atom types\n\n", start = head + "Atoms # atomic\n\n",
                    atoms = start + "1 1 0 0 0\n2 1 1 1 1\n\n";
  struct Case {  // pointers alone: a hundred strings take seconds to compile
    const char *before, *text;
    int line;
    const char* why;
  };
  const std::vector<Case> cases{
      {"", "", 1, "empty"},
      {"", "t\nx atoms\n", 2, "how many atoms"},
      {"", "t\n1 atom types\n\nAtoms\n", 4, "how many atoms"},
      {"", "t\n1.5 atoms\n", 2, "whole number"},
      {"", "t\n-1 atoms\n", 2, "fewer than 0"},
      {"", "t\n99999999999999999999 atoms\n", 2, "whole number"},
      {"", "t\n1 xlo xhi\n", 2, "upper side should be"},
      {"", "t\n1 1 xlo xhi\n", 2, "no extent"},
      {"", "t\n0 1e999 xlo xhi\n", 2, "finite number"},
      {"", "t\n-1.7e308 1.7e308 xlo xhi\n", 2, "no extent"},
      {"", "t\n1 atoms\n3000000000000 atom types\n\nMasses\n\n1 1\n\nAtoms\n", 9,
       "Masses ends after 1 of 3000000000000"},
      {"", "t\n1 atoms\n1 atom types\n\nAtoms # sphere\n\n1 1 1e120 1 0 0 0\n", 7, "numbers can't hold"},
      {"", "t\n1 atoms\n1 atom types\n\nAtoms # sphere\n\n1 1 1e-120 1 0 0 0\n", 7, "numbers can't hold"},
      {start.c_str(), "9223372036854775807 1 0 0 0\n", 7, "an id must be > 0 and < 2^62"},
      {atoms.c_str(), "Velocities\n\n-9223372036854775808 0 0 0\n", 12, "there is no atom"},
      {"", "t\n0 0 0.5 xy xz yz\n", 2, "tilt"},
      {head.c_str(), "", 4, "Atoms is missing"},
      {head.c_str(), "Atom\n", 5, "Atoms is missing"},
      {head.c_str(), "Velocities\n\n1 0 0 0\n", 5, "before Atoms"},
      {head.c_str(), "Atoms # dipole\n\n1", 5, "atom style dipole"},
      {start.c_str(), "1 1 0 0 0\n", 7, "Atoms ends after 1 of 2"},
      {start.c_str(), "1 1 0 0 0\n\nVelocities\n", 9, "Atoms ends after 1 of 2"},
      {atoms.c_str(), "3 1 1 1 1\n", 10, "Atoms has more lines"},
      {atoms.c_str(), "Atoms # atomic\n", 10, "a second section Atoms"},
      {start.c_str(), "1 1 0 0\n2 1 1 1 1\n", 7, "the line ends where coordinate"},
      {start.c_str(), "1 1 0 0 O\n2 1 1 1 1\n", 7, "not \"O\""},
      {start.c_str(), "1 1 0 0 1x\n2 1 1 1 1\n", 7, "not \"1x\""},
      {start.c_str(), "1 1 0 0 nan\n2 1 1 1 1\n", 7, "finite number"},
      {start.c_str(), "1 1 0 0 1e999\n2 1 1 1 1\n", 7, "finite number"},
      {start.c_str(), "1 1 0 0 0 1 1\n", 7, "the line ends where image flag"},
      {start.c_str(), "1 1 0 0 0 1 1 1 1\n", 7, "nothing should follow"},
      {start.c_str(), "1 2 0 0 0\n", 7, "type 2 isn't one of 1 … 1"},
      {start.c_str(), "1 0 0 0 0\n", 7, "type 0"},
      {start.c_str(), "0 1 0 0 0\n", 7, "id must be > 0"},
      {start.c_str(), "2 1 0 0 0\n2 1 1 1 1\n", 8, "a second atom 2"},
      {atoms.c_str(), "Velocities\n\n1 0 0 0\n3 0 0 0\n", 13, "there is no atom 3"},
      {atoms.c_str(), "Velocities\n\n1 0 0 0\n2 0 0 0 0\n", 13, "nothing should follow"},
      {atoms.c_str(), "Masses\n\n1 0\n", 12, "mass must be > 0"},
      {atoms.c_str(), "Masses\n\n", 11, "Masses ends after 0 of 1"},
      {atoms.c_str(), "Bonds\n\n1 1 1 2\n", 12, "Bonds has more lines"},
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
  check(head + std::string(3, '\0') + "\x01\x02", 5, "Atoms is missing");
  CHECK_THROWS_WITH(read(atoms, {.style = "charge"}), contains("line 5") && contains("atomic, not charge"));
  CHECK_THROWS_WITH(read_lammps_data("no/such.data"), contains("no/such.data"));
}

TEST_CASE("a file cut anywhere throws or has lost nothing but the end of its last number") {
  for (std::size_t n = 0; n < atomic.size(); ++n) {
    try {
      const auto data = read(atomic.substr(0, n));
      CHECK(data.atoms.size() == 3);
    } catch (const std::runtime_error& error) {
      CHECK_THAT(error.what(), contains("melt.data, line "));
    }
  }
}

TEST_CASE("in the plane, and in float") {
  const std::string text =
      "grains\r\n1 atoms\r\n1 atom types\r\n-4 4 xlo xhi\r\n\r\nAtoms # sphere\r\n\r\n1 1 3 2.5 0.1 3 0\r\n\r\n"
      "Velocities\r\n\r\n1 1 2 0 0 0 6\r\n";
  const auto discs = read_as<Particles<float, 2, Spin>>(text).atoms;
  CHECK((discs.r.col(0) == Eigen::Vector2f(0.1F, 3)));
  CHECK(discs.omega(0, 0) == 6);
  CHECK(discs.box().lower == Eigen::Vector2f(-4, -0.5F));
}

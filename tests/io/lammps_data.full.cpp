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
  const std::string text = "t\n2 atoms\n1 atom types\n\nAtoms # atomic\n\n1 1 0 0 3\n";
  CHECK_THROWS_WITH((read_as<Particles<double, 2>>(text)), contains("line 7") && contains("plane"));
}

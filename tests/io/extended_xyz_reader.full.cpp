// extended_xyz_reader: the full product and what is dear to compile. The quick half is extended_xyz_reader.test.cpp.
#include "io/extended_xyz_reader_cases.hpp"

using namespace extended_xyz_reader_cases;

TEMPLATE_TEST_CASE("a frame of Particles comes back bit for bit", "", double, float) { check_round_trip<TestType>(); }

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
  Particles<double, 2> plane;
  CHECK_THROWS_WITH(read_extended_xyz("no/such.xyz", plane), contains("no/such.xyz"));
}

#include <phistep/io.hpp>

#include <Eigen/Core>

#include <sstream>
#include <stdexcept>
#include <string>

#include "support/catch.hpp"

using namespace phistep;

TEST_CASE("an extended XYZ frame: count, columns and time, then one line a particle") {
  std::ostringstream out;
  Eigen::Matrix<double, 3, 2> r, v;
  r << 1, 4, 2, 5, 3, 6;
  v << 0.5, 0, 0, -0.25, 0, 0;
  write_extended_xyz(out, 1.5, r, v, "Fe");
  CHECK(out.str() == "2\nProperties=species:S:1:pos:R:3:velo:R:3 Time=1.5\nFe 1 2 3 0.5 0 0\nFe 4 5 6 0 -0.25 0\n");
}

TEST_CASE("missing coordinates are zero") {
  std::ostringstream out;
  write_extended_xyz(out, 0, Eigen::Matrix<double, 2, 1>(1, 2), Eigen::Matrix<double, 2, 1>(3, 4));
  CHECK_THAT(out.str(), contains("X 1 2 0 3 4 0\n"));
}

TEST_CASE("frames append, and the stream's precision is left as it was") {
  std::ostringstream out;
  out.precision(3);
  const Eigen::Matrix<double, 3, 1> r(1.0 / 3, 0, 0);
  write_extended_xyz(out, 0, r, r);
  write_extended_xyz(out, 1, r, r);
  CHECK(out.precision() == 3);
  CHECK_THAT(out.str(), contains("0.333333343") || contains("0.333333333"));
  CHECK_THAT(out.str(), contains("Time=1\n"));
}

TEST_CASE("shapes that are no frame throw, and so does a stream that fails") {
  std::ostringstream out;
  const Eigen::MatrixXd r = Eigen::MatrixXd::Zero(3, 2);
  CHECK_THROWS_AS(write_extended_xyz(out, 0, Eigen::MatrixXd::Zero(4, 2), Eigen::MatrixXd::Zero(4, 2)),
                  std::invalid_argument);
  CHECK_THROWS_AS(write_extended_xyz(out, 0, r, Eigen::MatrixXd::Zero(3, 1)), std::invalid_argument);
  CHECK_THROWS_AS(write_extended_xyz(out, 0, r, Eigen::MatrixXd::Zero(2, 2)), std::invalid_argument);
  CHECK(out.str().empty());
  out.setstate(std::ios::badbit);
  CHECK_THROWS_AS(write_extended_xyz(out, 0, r, r), std::runtime_error);
}

TEST_CASE("progress shows the start and the end, and not every step between") {
  std::ostringstream out;
  auto bar = progress(out, 10.0);
  const Eigen::Vector2d y(1, 2);
  for (int n = 0; n <= 1000; ++n) bar(n == 1000 ? 10.0 : 0.01 * n, y);
  const std::string text = out.str();
  CHECK_THAT(text, contains("t = 0  0 %") && contains("t = 10  100 %"));
  CHECK(text.back() == '\n');
  CHECK(text.size() < 2000);
}

TEST_CASE("progress without a known end shows no share") {
  std::ostringstream out;
  auto bar = progress(out);
  bar(2.0, Eigen::Vector2d(1, 2));
  CHECK_THAT(out.str(), contains("t = 2") && !contains("%"));
}

TEST_CASE("progress backward") {
  std::ostringstream out;
  auto bar = progress(out, 0.0);
  bar(4.0, 0), bar(0.0, 0);
  CHECK_THAT(out.str(), contains("t = 4  0 %") && contains("t = 0  100 %"));
}

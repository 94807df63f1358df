#include <phistep/base/state/motion.hpp>
#include <phistep/io.hpp>
#include <phistep/run/observers/at_times.hpp>

#include <Eigen/Core>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <fstream>
#include <locale>
#include <random>
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
  write_extended_xyz(out, 1.5, r, v, {.species = {"Fe"}});
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

TEST_CASE("an extended XYZ frame: a species a particle, columns of one's own") {
  std::ostringstream out;
  const Eigen::Matrix2d r = (Eigen::Matrix2d() << 1, 3, 2, 4).finished();
  write_extended_xyz(out, 1.5, r, Eigen::Matrix2d(Eigen::Matrix2d::Zero()), {.species = {"Fe", "O"}},
                     column("radius", Eigen::Vector2d(0.25, 1.0 / 3)), column("id", Eigen::Vector2i(7, -8)),
                     column("torque", r));
  CHECK(out.str() ==
        "2\nProperties=species:S:1:pos:R:3:velo:R:3:radius:R:1:id:I:1:torque:R:2 Time=1.5\n"
        "Fe 1 2 0 0 0 0 0.25 7 1 2\nO 3 4 0 0 0 0 0.333333333 -8 3 4\n");
}

TEST_CASE("extended_xyz observes motions: matrices, flat vectors, columns that are functions") {
  std::ostringstream out;
  auto observer =
      extended_xyz(out, {.species = {"Ar"}},
                   column("speed", [](double, const auto& y) -> Eigen::VectorXd { return y.v.colwise().norm(); }));
  Motion<Eigen::Matrix3Xd> y{Eigen::Matrix3Xd::Zero(3, 2), Eigen::Matrix3Xd::Zero(3, 2)};
  y.v.col(1) << 3, 4, 0;
  observer(0.25, y);
  CHECK(out.str() ==
        "2\nProperties=species:S:1:pos:R:3:velo:R:3:speed:R:1 Time=0.25\nAr 0 0 0 0 0 0 0\nAr 0 0 0 3 4 0 5\n");

  std::ostringstream plane;
  auto flat = every(1.0, extended_xyz(plane, {.dimensions = 2}));
  const Motion<Eigen::Vector4d> pair{Eigen::Vector4d(1, 2, 3, 4), Eigen::Vector4d(5, 6, 7, 8)};
  for (const double t : {0.0, 0.5, 1.0}) CHECK(flat(t, pair));
  CHECK(plane.str() ==
        "2\nProperties=species:S:1:pos:R:3:velo:R:3 Time=0\nX 1 2 0 5 6 0\nX 3 4 0 7 8 0\n"
        "2\nProperties=species:S:1:pos:R:3:velo:R:3 Time=1\nX 1 2 0 5 6 0\nX 3 4 0 7 8 0\n");
  plane.str("");
  extended_xyz(plane)(0.0, Motion<Eigen::VectorXd>{});
  CHECK(plane.str() == "0\nProperties=species:S:1:pos:R:3:velo:R:3 Time=0\n");
  auto wrong = extended_xyz(plane);
  CHECK_THROWS_AS(wrong(0.0, pair), std::invalid_argument);  // four numbers are no particles in space
}

TEST_CASE("columns and species that are no frame throw before anything is written") {
  std::ostringstream out;
  const Eigen::MatrixXd r = Eigen::MatrixXd::Zero(3, 2);
  const auto write = [&](FrameInfo info, auto... columns) { write_extended_xyz(out, 0, r, r, info, columns...); };
  CHECK_THROWS_AS(write({.species = {}}), std::invalid_argument);
  CHECK_THROWS_AS(write({.species = {"A", "B", "C"}}), std::invalid_argument);
  CHECK_THROWS_AS(write({.species = {"two words"}}), std::invalid_argument);
  CHECK_THROWS_AS(write({}, column("m", Eigen::Vector3d(1, 2, 3))), std::invalid_argument);
  CHECK_THROWS_AS(write({}, column("a:b", Eigen::Vector2d(1, 2))), std::invalid_argument);
  CHECK(out.str().empty());
}

namespace {
/// Writes 1,5 for 1.5 and 1.000 for a thousand.
struct German : std::numpunct<char> {
  char do_decimal_point() const override { return ','; }
  char do_thousands_sep() const override { return '.'; }
  std::string do_grouping() const override { return "\3"; }
};
}  // namespace

TEST_CASE("tables and frames look the same in every locale") {
  std::ostringstream out;
  out.imbue(std::locale(std::locale::classic(), new German));
  const Eigen::Matrix<double, 3, 1> r(1234.5, 0, 0);
  write_extended_xyz(out, 4321.5, r, r);
  CHECK_THAT(out.str(), contains("Time=4321.5\nX 1234.5 0 0"));
  out.str("");
  Recorder<Eigen::Vector2d> recorder;
  recorder(1234.5, Eigen::Vector2d(0.5, 12345));
  write_csv(out, recorder);
  CHECK(out.str() == "t,y0,y1\n1234.5,0.5,12345\n");
}

TEST_CASE("a recorder as comma-separated values: names, then one line a time, to the last bit") {
  Recorder<Motion<Eigen::Vector2d>> recorder;
  std::ostringstream empty;
  write_csv(empty, recorder);
  CHECK(empty.str() == "t\n");

  recorder(0.1, Motion<Eigen::Vector2d>{Eigen::Vector2d(1.0 / 3, -2), Eigen::Vector2d(5e-324, 1e300)});
  recorder(0.30000000000000004,
           Motion<Eigen::Vector2d>{Eigen::Vector2d(std::nan(""), -INFINITY), Eigen::Vector2d(0, 8)});
  std::ostringstream out;
  write_csv(out, recorder);
  CHECK(out.str() == "t,r0,r1,v0,v1\n0.1,0.3333333333333333,-2,5e-324,1e+300\n0.30000000000000004,nan,-inf,0,8\n");

  Recorder<Eigen::MatrixXf> matrix;
  matrix(0.1f, (Eigen::MatrixXf(2, 2) << 1, 2, 3, 0.1f).finished());
  std::ostringstream floats;
  write_csv(floats, matrix);
  CHECK(floats.str() == "t,y0_0,y1_0,y0_1,y1_1\n0.1,1,3,2,0.1\n");
}

TEST_CASE("every number of a table reads back to its bits") {
  std::mt19937_64 random(5);
  Recorder<Eigen::VectorXd> recorder;
  Eigen::VectorXd y(100);
  for (auto& x : y) {
    do x = std::bit_cast<double>(random());
    while (!std::isfinite(x));
  }
  recorder(0.0, y);
  std::ostringstream out;
  write_csv(out, recorder);
  std::istringstream in(out.str());
  std::string line, cell;
  std::getline(in, line), std::getline(in, line);
  std::istringstream cells(line);
  std::getline(cells, cell, ',');
  for (const double x : y) {
    std::getline(cells, cell, ',');
    CHECK(std::bit_cast<std::uint64_t>(std::strtod(cell.c_str(), nullptr)) == std::bit_cast<std::uint64_t>(x));
  }
}

TEST_CASE("csv writes while a run goes on: the state, or columns of one's own") {
  std::ostringstream all, own;
  auto whole = csv(all);
  auto columns = csv(own, column("energy, total", [](double, const auto& y) { return y.squaredNorm(); }),
                     column("steps", [n = 0](double, const auto&) mutable { return n++; }));
  Eigen::VectorXd y = Eigen::Vector2d(1, 2);
  for (const double t : {0.0, 0.5}) whole(t, y), columns(t, y);
  CHECK(all.str() == "t,y0,y1\n0,1,2\n0.5,1,2\n");
  CHECK(own.str() == "t,\"energy, total\",steps\n0,5,0\n0.5,5,1\n");
  CHECK_THROWS_AS(whole(1.0, Eigen::VectorXd(Eigen::VectorXd::Zero(3))), std::invalid_argument);
}

TEST_CASE("names with commas, quotation marks or ends of lines are quoted, and their marks doubled") {
  std::ostringstream out;
  const auto one = [](double, const auto&) { return 1; };
  auto columns = csv(out, column("the \"true\" energy", one), column("\"", one), column("a\nb", one), column("c", one));
  columns(0.5, Eigen::Vector2d(1, 2));
  CHECK(out.str() == "t,\"the \"\"true\"\" energy\",\"\"\"\",\"a\nb\",c\n0.5,1,1,1,1\n");
}

TEST_CASE("a table that can't be written says so") {
  Recorder<Eigen::Vector2d> recorder;
  recorder(0.0, Eigen::Vector2d(1, 2));
  CHECK_THROWS_AS(write_csv(std::string("/no/such/folder/x.csv"), recorder), std::runtime_error);
  std::ostringstream out;
  out.setstate(std::ios::badbit);
  CHECK_THROWS_AS(write_csv(out, recorder), std::runtime_error);
  auto observer = csv(out);
  CHECK_THROWS_AS(observer(0.0, Eigen::Vector2d(1, 2)), std::runtime_error);
  if (std::ofstream full("/dev/full"); full)
    CHECK_THROWS_AS(write_csv(std::string("/dev/full"), recorder), std::runtime_error);
}

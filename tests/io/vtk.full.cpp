// The files as bytes: structure, counts, every number as it was; tests/io/read_vtk.py reads them with VTK itself.
#include <phistep/integrate.hpp>
#include <phistep/io/vtk.hpp>
#include <phistep/particles.hpp>
#include <phistep/run/observers/at_times.hpp>

#include <Eigen/Core>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <functional>
#include <initializer_list>
#include <iterator>
#include <limits>
#include <locale>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <vector>

#include "support/catch.hpp"

using namespace phistep;
namespace fs = std::filesystem;

namespace {

/// A folder of this test's own, gone afterwards.
struct Folder {
  fs::path path;
  explicit Folder(const std::string& name) : path{fs::temp_directory_path() / ("phistep_vtk_" + name)} {
    fs::remove_all(path);
    fs::create_directories(path);
  }
  ~Folder() {
    std::error_code ignored;
    fs::remove_all(path, ignored);
  }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;
};

std::string text_of(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  REQUIRE(in);
  return {std::istreambuf_iterator<char>(in), {}};
}

/// The count numbers behind a line that begins so and names their type.
template <class Number>
std::vector<Number> numbers_behind(const std::string& file, const std::string& line, std::size_t count) {
  const std::size_t at = file.find('\n' + line + '\n');
  INFO(line);
  REQUIRE(at != file.npos);
  const std::size_t begin = at + line.size() + 2;
  REQUIRE(begin + count * sizeof(Number) < file.size());
  CHECK(file[begin + count * sizeof(Number)] == '\n');
  std::vector<Number> numbers;
  for (std::size_t k = 0; k < count; ++k) {
    std::array<char, sizeof(Number)> bytes;
    std::copy_n(file.begin() + static_cast<std::ptrdiff_t>(begin + k * sizeof(Number)), sizeof(Number), bytes.begin());
    if constexpr (std::endian::native == std::endian::little) std::reverse(bytes.begin(), bytes.end());
    numbers.push_back(std::bit_cast<Number>(bytes));
  }
  return numbers;
}
template <class Number>
std::vector<Number> array_of(const std::string& file, const std::string& name, int components, int n) {
  const std::string type = std::is_integral_v<Number> ? " vtktypeint64" : sizeof(Number) == 4 ? " float" : " double";
  const std::string line = name + ' ' + std::to_string(components) + ' ' + std::to_string(n) + type;
  return numbers_behind<Number>(file, line, static_cast<std::size_t>(components * n));
}
std::vector<double> points_of(const std::string& file, int n) {
  return numbers_behind<double>(file, "POINTS " + std::to_string(n) + " double", static_cast<std::size_t>(3 * n));
}
using Doubles = std::vector<double>;
using Ints = std::vector<std::int64_t>;
using Ints32 = std::vector<std::int32_t>;

std::string times_in(const std::string& list) {
  std::string times;
  for (std::size_t at = 0; (at = list.find("\"time\": ", at)) != list.npos;) {
    at += 8;
    times += list.substr(at, list.find(',', at) - at) + ' ';
  }
  return times;
}
void check_is_whole(const std::string& list) {
  CHECK(list.starts_with("{\"file-series-version\": \"1.0\", \"files\": [\n{"));
  CHECK(list.ends_with("}\n]}\n"));
}

Motion<Eigen::Matrix2Xd> pair() {
  Motion<Eigen::Matrix2Xd> y{Eigen::Matrix2Xd(2, 2), Eigen::Matrix2Xd(2, 2)};
  y.r << 1, 3, 2, 4;
  y.v << 5, 7, 6, 8;
  return y;
}

}  // namespace

TEST_CASE("a motion: points with their velocities, the third coordinate 0, a vertex each") {
  const Folder folder("motion");
  write_vtk(folder.path / "pair.vtk", pair());
  const std::string file = text_of(folder.path / "pair.vtk");
  CHECK(file.starts_with("# vtk DataFile Version 3.0\nphistep\nBINARY\nDATASET UNSTRUCTURED_GRID\nPOINTS 2 double\n"));
  CHECK(points_of(file, 2) == Doubles{1, 2, 0, 3, 4, 0});
  CHECK(numbers_behind<std::int32_t>(file, "CELLS 2 4", 4) == Ints32{1, 0, 1, 1});
  CHECK(numbers_behind<std::int32_t>(file, "CELL_TYPES 2", 2) == Ints32{1, 1});
  CHECK_THAT(file, contains("\nPOINT_DATA 2\nFIELD data 1\nvelocity 3 2 double\n"));
  CHECK(array_of<double>(file, "velocity", 3, 2) == Doubles{5, 6, 0, 7, 8, 0});
  CHECK_FALSE(fs::exists(folder.path / "pair.vtk.part"));
}

TEST_CASE("particles: everything that they have, under plain names, integers as integers") {
  const Folder folder("particles");
  Particles<double, 3, Spin, Temperature> grains{Eigen::Matrix3Xd(Eigen::Matrix3Xd::Constant(3, 2, 0.1))};
  grains.set_mass(Eigen::Vector2d(2, 3)).set_radius(0.5).set_type(Eigen::Vector2i(4, 1)).set_charge(-1.5);
  grains.set_heat_capacity(7.0).set_id({11, 5}).set_still({0, 1});
  grains.omega << 1, 4, 2, 5, 3, 6;
  grains.temperature << 300, 400;
  write_vtk(folder.path / "grains.vtk", grains);
  const std::string file = text_of(folder.path / "grains.vtk");
  CHECK(points_of(file, 2) == Doubles(6, 0.1));
  CHECK(array_of<double>(file, "velocity", 3, 2) == Doubles(6, 0));
  CHECK(array_of<std::int64_t>(file, "id", 1, 2) == Ints{11, 5});
  CHECK(array_of<double>(file, "mass", 1, 2) == Doubles{2, 3});
  CHECK(array_of<double>(file, "radius", 1, 2) == Doubles{0.5, 0.5});
  CHECK(array_of<std::int64_t>(file, "type", 1, 2) == Ints{4, 1});
  CHECK(array_of<double>(file, "charge", 1, 2) == Doubles{-1.5, -1.5});
  CHECK(array_of<double>(file, "heat_capacity", 1, 2) == Doubles{7, 7});
  CHECK(array_of<std::int64_t>(file, "still", 1, 2) == Ints{0, 1});
  CHECK(array_of<double>(file, "omega", 3, 2) == Doubles{1, 2, 3, 4, 5, 6});
  CHECK(array_of<double>(file, "temperature", 1, 2) == Doubles{300, 400});
}

TEST_CASE(
    "particles in a plane turn about one axis; without properties there are no arrays of them; positions wrapped") {
  const Folder folder("plane");
  Particles<float, 2, Spin> discs{Eigen::Matrix2Xf(Eigen::Matrix2Xf::Constant(2, 1, 2.25f))};
  discs.set_box(Box<float, 2>::periodic({0, 0}, {1, 1}));
  discs.omega << 9;
  write_vtk(folder.path / "discs.vtk", discs, {.wrapped = true, .single = true});
  const std::string file = text_of(folder.path / "discs.vtk");
  CHECK(array_of<float>(file, "omega", 1, 1) == std::vector<float>{9});
  CHECK(numbers_behind<float>(file, "POINTS 1 float", 3) == std::vector<float>{0.25f, 0.25f, 0});
  CHECK_THAT(file, !contains("radius") && !contains("double"));
}

TEST_CASE("no particles, one particle, and numbers that are none") {
  const Folder folder("sizes");
  write_vtk(folder.path / "none.vtk", Particles<double, 3>{});
  CHECK_THAT(text_of(folder.path / "none.vtk"), contains("POINTS 0 double\n\nCELLS 0 0\n\nCELL_TYPES 0\n\n"));
  const double nan = std::nan(""), infinity = std::numeric_limits<double>::infinity();
  write_vtk(folder.path / "one.vtk",
            Motion{Eigen::Vector3d(nan, -infinity, -0.0), Eigen::Vector3d(1.0 / 3, 5e-324, 1e308)});
  const std::string one = text_of(folder.path / "one.vtk");
  const Doubles r = points_of(one, 1);
  CHECK(std::isnan(r[0]));
  CHECK((r[1] == -infinity && std::signbit(r[2])));
  CHECK(array_of<double>(one, "velocity", 3, 1) == Doubles{1.0 / 3, 5e-324, 1e308});
}

TEST_CASE("flat vectors: dimensions say what a particle is") {
  const Folder folder("flat");
  const Motion<Eigen::VectorXd> y{Eigen::VectorXd::LinSpaced(6, 0, 5), Eigen::VectorXd::Zero(6)};
  write_vtk(folder.path / "flat.vtk", y, {.dimensions = 2});
  CHECK(points_of(text_of(folder.path / "flat.vtk"), 3) == Doubles{0, 1, 0, 2, 3, 0, 4, 5, 0});
  write_vtk(folder.path / "line.vtk", y, {.dimensions = 1});
  CHECK(points_of(text_of(folder.path / "line.vtk"), 6).size() == 18);
  CHECK_THROWS_AS(write_vtk(folder.path / "x.vtk", y), std::invalid_argument);
  CHECK_THROWS_AS(write_vtk(folder.path / "x.vtk", y, {.dimensions = 4}), std::invalid_argument);
  const Motion<Eigen::VectorXd> odd{Eigen::VectorXd::Zero(5), Eigen::VectorXd::Zero(5)};
  CHECK_THROWS_AS(write_vtk(folder.path / "x.vtk", odd, {.dimensions = 2}), std::invalid_argument);
  CHECK_FALSE(fs::exists(folder.path / "x.vtk"));
}

TEST_CASE("fields on a grid: size, origin, spacing; on points and on cells; one, two, three dimensions") {
  const Folder folder("grid");
  const Eigen::VectorXd six = Eigen::VectorXd::LinSpaced(6, 0, 5), u = six.head(3);
  const auto written = [&](const auto& y, const VtkGrid& grid) {
    write_vtk(folder.path / "a.vtk", y, grid);
    return text_of(folder.path / "a.vtk");
  };
  const std::string line = written(u, {.size = {3}, .spacing = {0.5}, .origin = {-1}});
  CHECK_THAT(line, contains("STRUCTURED_POINTS\nDIMENSIONS 3 1 1\nORIGIN -1 0 0\nSPACING 0.5 1 1\nPOINT_DATA 3\n"));
  CHECK(array_of<double>(line, "y", 1, 3) == Doubles{0, 1, 2});
  const std::string plane = written(six, {.size = {3, 2}, .spacing = {1, 2}, .on_cells = true, .names = {"theta"}});
  CHECK_THAT(plane, contains("DIMENSIONS 4 3 1\nORIGIN 0 0 0\nSPACING 1 2 1\nCELL_DATA 6\n"));
  CHECK(array_of<double>(plane, "theta", 1, 6) == Doubles{0, 1, 2, 3, 4, 5});
  CHECK_THAT(written(six, {.size = {1, 2, 3}, .spacing = {0, 1, 1}}), contains("DIMENSIONS 1 2 3\n"));
  CHECK_THAT(written(Eigen::VectorXd(six.head(1)), {}), contains("DIMENSIONS 1 1 1\n"));
  // A matrix is the plane: its rows lie along x.
  CHECK(array_of<double>(written(Eigen::MatrixXd(six.reshaped(2, 3)), {.size = {2, 3}}), "y", 1, 6) ==
        Doubles{0, 1, 2, 3, 4, 5});
}

TEST_CASE("several fields: one after the other, a column a point, blocks of a motion") {
  const Folder folder("fields");
  const Eigen::VectorXd six = Eigen::VectorXd::LinSpaced(6, 0, 5);
  const auto written = [&](const auto& y, const VtkGrid& grid) {
    write_vtk(folder.path / "a.vtk", y, grid);
    return text_of(folder.path / "a.vtk");
  };
  CHECK(array_of<double>(written(six, {.size = {3}}), "y", 2, 3) == Doubles{0, 3, 1, 4, 2, 5});
  CHECK(array_of<double>(written(Eigen::MatrixXd(six.reshaped(2, 3)), {.size = {3}, .names = {"u"}}), "u", 2, 3) ==
        Doubles{0, 1, 2, 3, 4, 5});
  const Motion<Eigen::VectorXd> wave{six.head(3), six.tail(3)};
  CHECK(array_of<double>(written(wave, {.size = {3}, .names = {"u", "w"}}), "w", 1, 3) == Doubles{3, 4, 5});
  CHECK(array_of<double>(written(wave, {.size = {3}}), "r", 1, 3) == Doubles{0, 1, 2});
}

TEST_CASE("sizes that don't fit are refused, and leave no file") {
  const Folder folder("misfits");
  const Eigen::VectorXd six = Eigen::VectorXd::Zero(6);
  const auto path = folder.path / "a.vtk";
  CHECK_THROWS_AS(write_vtk(path, six, VtkGrid{.size = {4}}), std::invalid_argument);
  CHECK_THROWS_AS(write_vtk(path, six, VtkGrid{.size = {7}}), std::invalid_argument);
  CHECK_THROWS_WITH(write_vtk(path, six, VtkGrid{.size = {6}}, column("p", Eigen::VectorXd(six.head(5)))),
                    contains("6 points or cells has an array p of 5"));
  CHECK_THROWS_WITH(write_vtk(path, six, VtkGrid{.size = {6}}, column("", six)), contains("without a name"));
  const Motion<Eigen::Matrix3Xd> net{Eigen::Matrix3Xd::Zero(3, 4), Eigen::Matrix3Xd::Zero(3, 4)};
  CHECK_THROWS_WITH(write_vtk(path, net, {.triangles = {{0, 1, 2}, {1, 2, 4}}}),
                    contains("4 points or cells has a cell with the point 4"));
  CHECK_THROWS_AS(write_vtk(path, net, {.lines = {{-1, 0}}}), std::invalid_argument);
  CHECK(fs::is_empty(folder.path));
}

TEST_CASE("meshes: all kinds of cells, points that move") {
  const Folder folder("mesh");
  const VtkMesh mesh{
      .lines = {{0, 1}}, .triangles = {{0, 1, 2}}, .quads = {{3, 2, 1, 0}}, .tetrahedra = {{0, 1, 2, 3}}};
  const Motion<Eigen::Matrix3Xd> cloth{Eigen::Matrix3Xd::Constant(3, 4, 2), Eigen::Matrix3Xd::Constant(3, 4, -1)};
  write_vtk(folder.path / "a.vtk", cloth, mesh, column("strain", Eigen::Vector4d(1, 2, 3, 4)));
  const std::string file = text_of(folder.path / "a.vtk");
  CHECK(numbers_behind<std::int32_t>(file, "CELLS 4 17", 17) ==
        Ints32{2, 0, 1, 3, 0, 1, 2, 4, 3, 2, 1, 0, 4, 0, 1, 2, 3});
  CHECK(numbers_behind<std::int32_t>(file, "CELL_TYPES 4", 4) == Ints32{3, 5, 9, 10});
  CHECK(points_of(file, 4) == Doubles(12, 2));
  CHECK(array_of<double>(file, "velocity", 3, 4) == Doubles(12, -1));
  CHECK(array_of<double>(file, "strain", 1, 4) == Doubles{1, 2, 3, 4});
}

TEST_CASE("names of arrays and of files may have any letters") {
  const Folder folder("names");
  const fs::path base = folder.path / fs::path(u8"Übung \"größer\" 粒子");
  auto series = vtk_series(base, {}, column("a % \"ä\"", Eigen::Vector2d(1, 2)));
  series(0.0, pair());
  CHECK_THAT(text_of(fs::path(base) += ".vtk.series"), contains("\"name\": \"Übung \\\"größer\\\" 粒子/00000.vtk\""));
  CHECK(array_of<double>(text_of(base / "00000.vtk"), "a%20%25%20%22%c3%a4%22", 1, 2) == Doubles{1, 2});
}

TEST_CASE("a series: numbered frames with their times, a complete list after each") {
  const Folder folder("series");
  auto series =
      vtk_series(folder.path / "run", {},
                 column("speed", [](double, const auto& y) -> Eigen::VectorXd { return y.v.colwise().norm(); }));
  std::string before;
  for (int n = 0; n < 3; ++n) {
    series(n / 4.0, pair());
    const std::string list = text_of(folder.path / "run.vtk.series");
    check_is_whole(list);
    CHECK(list.size() > before.size());
    before = list;
  }
  CHECK(before ==
        "{\"file-series-version\": \"1.0\", \"files\": [\n{\"time\": 0, \"name\": \"run/00000.vtk\"},\n"
        "{\"time\": 0.25, \"name\": \"run/00001.vtk\"},\n{\"time\": 0.5, \"name\": \"run/00002.vtk\"}\n]}\n");
  CHECK(array_of<double>(text_of(folder.path / "run" / "00002.vtk"), "speed", 1, 2) ==
        Doubles{std::hypot(5, 6), std::hypot(7, 8)});
}

TEST_CASE("a series that runs again starts anew, one that goes on has each time once, and time may run backward") {
  const Folder folder("again");
  const auto list = folder.path / "run.vtk.series";
  auto series = vtk_series(folder.path / "run");
  const auto run = [&](std::initializer_list<double> times) {
    for (const double t : times) series(t, pair());
    check_is_whole(text_of(list));
    return times_in(text_of(list));
  };
  CHECK(run({0, 1, 2}) == "0 1 2 ");
  CHECK(run({2, 3}) == "0 1 2 3 ");
  CHECK(run({0, 1}) == "0 1 ");
  CHECK(run({-1, -0.5}) == "-1 -0.5 ");
  auto back = vtk_series(folder.path / "run");
  for (const double t : {1.0, 0.5, 0.0, 0.25}) back(t, pair());
  CHECK(times_in(text_of(list)) == "1 0.5 0.25 ");
  fs::remove(list);
  back(-1.0, pair());
  CHECK(times_in(text_of(list)) == "1 0.5 0.25 -1 ");
}

TEST_CASE("a series resumes: frames before the first new one stay, later ones are written again") {
  const Folder folder("resume");
  const auto list = folder.path / "run.vtk.series";
  const auto write = [&](VtkMesh layout, std::initializer_list<double> times) {
    auto series = vtk_series(folder.path / "run", layout);
    for (const double t : times) series(t, pair());
    check_is_whole(text_of(list));
    return times_in(text_of(list));
  };
  CHECK(write({.resume = true}, {0, 0.125}) == "0 0.125 ");  // nothing there: a first start
  CHECK(write({.resume = true}, {0.25, 1 / 3.0, 0.5}) == "0 0.125 0.25 0.33333333333333331 0.5 ");
  CHECK(write({.resume = true}, {1 / 3.0, 0.75}) ==
        "0 0.125 0.25 0.33333333333333331 0.75 ");  // from a checkpoint at 0.3
  CHECK_THAT(text_of(list), contains("{\"time\": 0.75, \"name\": \"run/00004.vtk\"}"));
  CHECK(write({}, {0.25}) == "0.25 ");
}

TEST_CASE("what fails names the file and the reason, and leaves the older file") {
  const Folder folder("fails");
  CHECK_THROWS_WITH(write_vtk(folder.path / "missing" / "a.vtk", pair()),
                    contains("phistep: cannot write ") && contains("missing/a.vtk: No such file or directory"));
  auto series = vtk_series(folder.path / "missing" / "run");
  CHECK_THROWS_WITH(series(0.0, pair()), contains("missing/run/00000.vtk: No such file or directory"));
  std::ofstream(folder.path / "taken") << "a file where the folder should be";
  auto blocked = vtk_series(folder.path / "taken");
  CHECK_THROWS_WITH(blocked(0.0, pair()), contains("taken/00000.vtk: Not a directory"));
#ifdef __linux__
  if (fs::exists("/dev/full")) {
    write_vtk(folder.path / "a.vtk", pair());
    const std::string good = text_of(folder.path / "a.vtk");
    fs::create_symlink("/dev/full", folder.path / "a.vtk.part");
    CHECK_THROWS_WITH(write_vtk(folder.path / "a.vtk", pair()), contains("a.vtk: No space left on device"));
    CHECK(text_of(folder.path / "a.vtk") == good);
  }
#endif
}

TEST_CASE("numbers look the same in every locale") {
  struct Comma : std::numpunct<char> {
    char do_decimal_point() const override { return ','; }
    char do_thousands_sep() const override { return '.'; }
    std::string do_grouping() const override { return "\3"; }
  };
  const Folder folder("locale");
  const std::locale before = std::locale::global(std::locale(std::locale::classic(), new Comma));
  auto series = vtk_series(folder.path / "run", VtkGrid{.size = {2000}, .spacing = {0.5}});
  series(1234.5, Eigen::VectorXd(Eigen::VectorXd::Zero(2000)));
  auto resumed = vtk_series(folder.path / "run", VtkGrid{.size = {2000}, .spacing = {0.5}, .resume = true});
  resumed(1235.5, Eigen::VectorXd(Eigen::VectorXd::Zero(2000)));
  std::locale::global(before);
  CHECK(times_in(text_of(folder.path / "run.vtk.series")) == "1234.5 1235.5 ");
  CHECK_THAT(text_of(folder.path / "run" / "00000.vtk"), contains("SPACING 0.5 1 1\nPOINT_DATA 2000\n"));
}

TEST_CASE("sampled writes frames at exact times, whatever the steps") {
  const Folder folder("sampled");
  auto oscillator = [](const Eigen::Matrix3Xd& r) -> Eigen::Matrix3Xd { return -r; };
  Motion<Eigen::Matrix3Xd> y{Eigen::Matrix3Xd::Ones(3, 2), Eigen::Matrix3Xd::Zero(3, 2)};
  PhiStepper stepper{y, oscillator, velocity_verlet};
  auto series = vtk_series(folder.path / "run");
  REQUIRE(integrate(stepper, y, {0.0, 1.0}, fixed(0.013), sampled(0.25, std::ref(series))));
  CHECK(times_in(text_of(folder.path / "run.vtk.series")) == "0 0.25 0.5 0.75 1 ");
  for (const double x : points_of(text_of(folder.path / "run" / "00002.vtk"), 2))
    CHECK(std::abs(x - std::cos(0.5)) < 1e-4);  // the phase is off by t Δt²/24, 4e-6
}

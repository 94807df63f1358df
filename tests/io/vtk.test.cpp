// The files as bytes: structure, counts, offsets, every number as it was; tests/io/read_vtk.py reads them with VTK itself.
#include <phistep/integrate.hpp>
#include <phistep/io/vtk.hpp>
#include <phistep/observe/at_times.hpp>
#include <phistep/particles.hpp>

#include <Eigen/Core>

#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>
#include <stdexcept>
#include <string>
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

/// The numbers of an array, of the type that it must have.
template <class Number>
std::vector<Number> array_of(const std::string& file, const std::string& name, int components) {
  const std::string type = detail::vtk_type<Number>();
  const std::string start = "<DataArray type=\"" + type + "\" Name=\"" + name + "\" NumberOfComponents=\"" +
                            std::to_string(components) + "\" ";
  const std::size_t at = file.find(start);
  INFO(start);
  REQUIRE(at != file.npos);
  const std::string mark = "format=\"appended\" offset=\"";
  const std::size_t offset = std::stoul(file.substr(file.find(mark, at) + mark.size(), 20));
  const std::string begin = "<AppendedData encoding=\"raw\">\n_";
  const std::size_t block = file.find(begin) + begin.size() + offset;
  std::uint64_t bytes = 0;
  REQUIRE(block + sizeof bytes <= file.size());
  std::memcpy(&bytes, file.data() + block, sizeof bytes);
  REQUIRE(bytes % sizeof(Number) == 0);
  REQUIRE(block + sizeof bytes + bytes <= file.size());
  std::vector<Number> numbers(bytes / sizeof(Number));
  if (bytes > 0) std::memcpy(numbers.data(), file.data() + block + sizeof bytes, bytes);
  return numbers;
}
using Doubles = std::vector<double>;
using Ints = std::vector<std::int64_t>;

std::string times_in(const std::string& pvd) {
  std::string times;
  for (std::size_t at = 0; (at = pvd.find("timestep=\"", at)) != pvd.npos;) {
    at += 10;
    times += pvd.substr(at, pvd.find('"', at) - at) + ' ';
  }
  return times;
}
void check_is_whole(const std::string& pvd) {
  CHECK_THAT(pvd, contains("<VTKFile type=\"Collection\" version=\"0.1\">\n  <Collection>\n"));
  const std::string closing = "  </Collection>\n</VTKFile>\n";
  CHECK(pvd.size() > closing.size());
  CHECK(pvd.find(closing) == pvd.size() - closing.size());
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
  write_vtk(folder.path / "pair.vtp", pair());
  const std::string file = text_of(folder.path / "pair.vtp");
  CHECK_THAT(file, contains("<VTKFile type=\"PolyData\" version=\"1.0\" byte_order=\"") &&
                       contains("header_type=\"UInt64\">\n  <PolyData>\n    <Piece NumberOfPoints=\"2\" "
                                "NumberOfVerts=\"2\" NumberOfLines=\"0\" NumberOfStrips=\"0\" NumberOfPolys=\"0\">") &&
                       contains("\n  </AppendedData>\n</VTKFile>\n"));
  CHECK(array_of<double>(file, "Points", 3) == Doubles{1, 2, 0, 3, 4, 0});
  CHECK(array_of<double>(file, "velocity", 3) == Doubles{5, 6, 0, 7, 8, 0});
  CHECK(array_of<std::int64_t>(file, "connectivity", 1) == Ints{0, 1});
  CHECK(array_of<std::int64_t>(file, "offsets", 1) == Ints{1, 2});
  CHECK_FALSE(fs::exists(folder.path / "pair.vtp.part"));
}

TEST_CASE("particles: everything that they have, under plain names, integers as integers") {
  const Folder folder("particles");
  Particles<double, 3, Spin, Temperature> grains{Eigen::Matrix3Xd(Eigen::Matrix3Xd::Constant(3, 2, 0.1))};
  grains.set_mass(Eigen::Vector2d(2, 3)).set_radius(0.5).set_type(Eigen::Vector2i(4, 1)).set_charge(-1.5);
  grains.set_heat_capacity(7.0).set_id({11, 5}).set_still({0, 1});
  grains.omega << 1, 4, 2, 5, 3, 6;
  grains.temperature << 300, 400;
  write_vtk(folder.path / "grains.vtp", grains);
  const std::string file = text_of(folder.path / "grains.vtp");
  CHECK(array_of<double>(file, "Points", 3) == Doubles(6, 0.1));
  CHECK(array_of<double>(file, "velocity", 3) == Doubles(6, 0));
  CHECK(array_of<std::int64_t>(file, "id", 1) == Ints{11, 5});
  CHECK(array_of<double>(file, "mass", 1) == Doubles{2, 3});
  CHECK(array_of<double>(file, "radius", 1) == Doubles{0.5, 0.5});
  CHECK(array_of<std::int32_t>(file, "type", 1) == std::vector<std::int32_t>{4, 1});
  CHECK(array_of<double>(file, "charge", 1) == Doubles{-1.5, -1.5});
  CHECK(array_of<double>(file, "heat_capacity", 1) == Doubles{7, 7});
  CHECK(array_of<std::uint8_t>(file, "still", 1) == std::vector<std::uint8_t>{0, 1});
  CHECK(array_of<double>(file, "omega", 3) == Doubles{1, 2, 3, 4, 5, 6});
  CHECK(array_of<double>(file, "temperature", 1) == Doubles{300, 400});
}

TEST_CASE(
    "particles in a plane turn about one axis; without properties there are no arrays of them; positions wrapped") {
  const Folder folder("plane");
  Particles<float, 2, Spin> discs{Eigen::Matrix2Xf(Eigen::Matrix2Xf::Constant(2, 1, 2.25f))};
  discs.set_box(Box<float, 2>::periodic({0, 0}, {1, 1}));
  discs.omega << 9;
  write_vtk(folder.path / "discs.vtp", VtkPoints{.wrapped = true}, discs, {.single = true});
  const std::string file = text_of(folder.path / "discs.vtp");
  CHECK(array_of<float>(file, "omega", 1) == std::vector<float>{9});
  CHECK(array_of<float>(file, "Points", 3) == std::vector<float>{0.25f, 0.25f, 0});
  CHECK_THAT(file, !contains("radius") && !contains("Float64"));
}

TEST_CASE("no particles, one particle, and numbers that are none") {
  const Folder folder("sizes");
  write_vtk(folder.path / "none.vtp", Particles<double, 3>{});
  const std::string none = text_of(folder.path / "none.vtp");
  CHECK_THAT(none, contains("NumberOfPoints=\"0\" NumberOfVerts=\"0\""));
  CHECK(array_of<double>(none, "Points", 3).empty());
  CHECK(array_of<std::int64_t>(none, "offsets", 1).empty());
  const double nan = std::nan(""), infinity = std::numeric_limits<double>::infinity();
  write_vtk(folder.path / "one.vtp",
            Motion{Eigen::Vector3d(nan, -infinity, -0.0), Eigen::Vector3d(1.0 / 3, 5e-324, 1e308)});
  const std::string one = text_of(folder.path / "one.vtp");
  const Doubles r = array_of<double>(one, "Points", 3);
  CHECK(std::isnan(r[0]));
  CHECK((r[1] == -infinity && std::signbit(r[2])));
  CHECK(array_of<double>(one, "velocity", 3) == Doubles{1.0 / 3, 5e-324, 1e308});
}

TEST_CASE("flat vectors: dimensions say what a particle is") {
  const Folder folder("flat");
  const Motion<Eigen::VectorXd> y{Eigen::VectorXd::LinSpaced(6, 0, 5), Eigen::VectorXd::Zero(6)};
  write_vtk(folder.path / "flat.vtp", VtkPoints{.dimensions = 2}, y);
  CHECK(array_of<double>(text_of(folder.path / "flat.vtp"), "Points", 3) == Doubles{0, 1, 0, 2, 3, 0, 4, 5, 0});
  write_vtk(folder.path / "line.vtp", VtkPoints{.dimensions = 1}, y);
  CHECK(array_of<double>(text_of(folder.path / "line.vtp"), "Points", 3).size() == 18);
  CHECK_THROWS_AS(write_vtk(folder.path / "x.vtp", y), std::invalid_argument);
  CHECK_THROWS_AS(write_vtk(folder.path / "x.vtp", VtkPoints{.dimensions = 4}, y), std::invalid_argument);
  const Motion<Eigen::VectorXd> odd{Eigen::VectorXd::Zero(5), Eigen::VectorXd::Zero(5)};
  CHECK_THROWS_AS(write_vtk(folder.path / "x.vtp", VtkPoints{.dimensions = 2}, odd), std::invalid_argument);
  CHECK_FALSE(fs::exists(folder.path / "x.vtp"));
}

TEST_CASE("fields on a grid: extent, origin, spacing; on points and on cells; one, two, three dimensions") {
  const Folder folder("grid");
  const Eigen::VectorXd six = Eigen::VectorXd::LinSpaced(6, 0, 5), u = six.head(3);
  const auto written = [&](const VtkGrid& grid, const auto& y) {
    write_vtk(folder.path / "a.vti", grid, y);
    return text_of(folder.path / "a.vti");
  };
  const std::string line = written({.size = {3}, .spacing = {0.5}, .origin = {-1}}, u);
  CHECK_THAT(line, contains("<ImageData WholeExtent=\"0 2 0 0 0 0\" Origin=\"-1 0 0\" Spacing=\"0.5 1 1\">\n") &&
                       contains("    <Piece Extent=\"0 2 0 0 0 0\">\n      <PointData>\n"));
  CHECK(array_of<double>(line, "y", 1) == Doubles{0, 1, 2});
  const std::string plane = written({.size = {3, 2}, .spacing = {1, 2}, .on_cells = true, .names = {"theta"}}, six);
  CHECK_THAT(plane, contains("WholeExtent=\"0 3 0 2 0 0\" Origin=\"0 0 0\" Spacing=\"1 2 1\"") &&
                        contains("<CellData>") && !contains("<PointData>"));
  CHECK(array_of<double>(plane, "theta", 1) == Doubles{0, 1, 2, 3, 4, 5});
  CHECK_THAT(written({.size = {1, 2, 3}, .spacing = {0, 1, 1}}, six), contains("WholeExtent=\"0 0 0 1 0 2\""));
  CHECK_THAT(written({}, Eigen::VectorXd(six.head(1))), contains("WholeExtent=\"0 0 0 0 0 0\""));
  // A matrix is the plane: its rows lie along x.
  CHECK(array_of<double>(written({.size = {2, 3}, .spacing = {1, 1}}, Eigen::MatrixXd(six.reshaped(2, 3))), "y", 1) ==
        Doubles{0, 1, 2, 3, 4, 5});
}

TEST_CASE("several fields: one after the other, a column a point, blocks of a motion") {
  const Folder folder("fields");
  const Eigen::VectorXd six = Eigen::VectorXd::LinSpaced(6, 0, 5);
  const VtkGrid grid{.size = {3}, .spacing = {1}, .names = {"u", "v"}};
  const auto written = [&](const VtkGrid& on, const auto& y) {
    write_vtk(folder.path / "a.vti", on, y);
    return text_of(folder.path / "a.vti");
  };
  const std::string stacked = written(grid, six);
  CHECK(array_of<double>(stacked, "u", 1) == Doubles{0, 1, 2});
  CHECK(array_of<double>(stacked, "v", 1) == Doubles{3, 4, 5});
  const std::string columns = written(grid, Eigen::MatrixXd(six.reshaped(2, 3)));
  CHECK(array_of<double>(columns, "u", 1) == Doubles{0, 2, 4});
  CHECK(array_of<double>(columns, "v", 1) == Doubles{1, 3, 5});
  VtkGrid unnamed = grid;
  unnamed.names.clear();
  CHECK(array_of<double>(written(unnamed, six), "y", 2) == Doubles{0, 3, 1, 4, 2, 5});
  const Motion<Eigen::VectorXd> wave{six.head(3), six.tail(3)};
  CHECK(array_of<double>(written(grid, wave), "v", 1) == Doubles{3, 4, 5});
  CHECK(array_of<double>(written(unnamed, wave), "r", 1) == Doubles{0, 1, 2});
}

TEST_CASE("grids that don't fit are refused, and leave no file") {
  const Folder folder("misfits");
  const Eigen::VectorXd six = Eigen::VectorXd::Zero(6);
  const auto path = folder.path / "a.vti";
  const auto refused = [&](const VtkGrid& grid) { CHECK_THROWS_AS(write_vtk(path, grid, six), std::invalid_argument); };
  refused({.size = {4}, .spacing = {1}});
  refused({.size = {6}});  // no spacing
  refused({.size = {6}, .spacing = {-1}});
  refused({.size = {6}, .spacing = {std::nan("")}});
  refused({.size = {-6, -1}, .spacing = {1, 1}});
  refused({.size = {6}, .spacing = {1}, .names = {"a", "b"}});
  refused({.size = {2}, .spacing = {1}, .names = {"a", "b"}});  // three fields
  CHECK_THROWS_WITH(write_vtk(folder.path / "a.vtp", VtkGrid{.size = {6}, .spacing = {1}}, six),
                    contains("must end in .vti") && contains("a.vtp"));
  CHECK_THROWS_AS(write_vtk(path, VtkGrid{.size = {6}, .spacing = {1}}, six, column("p", Eigen::VectorXd(six.head(5)))),
                  std::invalid_argument);
  CHECK(fs::is_empty(folder.path));
}

TEST_CASE("meshes: all kinds of cells, points that move, values on points of their own") {
  const Folder folder("mesh");
  const VtkMesh cells{
      .lines = {{0, 1}}, .triangles = {{0, 1, 2}}, .quads = {{3, 2, 1, 0}}, .tetrahedra = {{0, 1, 2, 3}}};
  const Motion<Eigen::Matrix3Xd> cloth{Eigen::Matrix3Xd::Constant(3, 4, 2), Eigen::Matrix3Xd::Constant(3, 4, -1)};
  write_vtk(folder.path / "a.vtu", cells, cloth, column("strain", Eigen::Vector4d(1, 2, 3, 4)));
  const std::string file = text_of(folder.path / "a.vtu");
  CHECK_THAT(file, contains("<VTKFile type=\"UnstructuredGrid\"") &&
                       contains("<Piece NumberOfPoints=\"4\" NumberOfCells=\"4\">"));
  CHECK(array_of<std::int64_t>(file, "connectivity", 1) == Ints{0, 1, 0, 1, 2, 3, 2, 1, 0, 0, 1, 2, 3});
  CHECK(array_of<std::int64_t>(file, "offsets", 1) == Ints{2, 5, 9, 13});
  CHECK(array_of<std::uint8_t>(file, "types", 1) == std::vector<std::uint8_t>{3, 5, 9, 10});
  CHECK(array_of<double>(file, "Points", 3) == Doubles(12, 2));
  CHECK(array_of<double>(file, "velocity", 3) == Doubles(12, -1));
  CHECK(array_of<double>(file, "strain", 1) == Doubles{1, 2, 3, 4});

  VtkMesh fixed = cells;
  fixed.points = cloth.r;
  fixed.names = {"temperature"};
  write_vtk(folder.path / "a.vtu", fixed, Eigen::VectorXd(Eigen::Vector4d(5, 6, 7, 8)));
  CHECK(array_of<double>(text_of(folder.path / "a.vtu"), "temperature", 1) == Doubles{5, 6, 7, 8});

  write_vtk(folder.path / "b.vtu", VtkMesh{}, cloth);  // no cells: each point is one
  CHECK(array_of<std::uint8_t>(text_of(folder.path / "b.vtu"), "types", 1) == std::vector<std::uint8_t>(4, 1));
  CHECK_THROWS_WITH(write_vtk(folder.path / "c.vtu", VtkMesh{.triangles = {{0, 1, 2}, {1, 2, 4}}}, cloth),
                    contains("triangle 1 of a VtkMesh has the point 4, there are 4"));
  CHECK_THROWS_AS(write_vtk(folder.path / "c.vtu", VtkMesh{.lines = {{-1, 0}}}, cloth), std::invalid_argument);
  CHECK_THROWS_AS(write_vtk(folder.path / "c.vtu", VtkMesh{}, Eigen::VectorXd(4)), std::invalid_argument);
}

TEST_CASE("names in attributes are escaped, and paths may have any letters") {
  const Folder folder("names");
  const fs::path base = folder.path / fs::path(u8"Übung & \"größer\" 粒子");
  auto series = vtk_series(base, column("a<b>&\"c\"", Eigen::Vector2d(1, 2)));
  series(0.0, pair());
  const std::string pvd = text_of(series.frames().path());
  CHECK_THAT(pvd, contains("file=\"Übung &amp; &quot;größer&quot; 粒子/00000.vtp\""));
  const std::string frame = text_of(base / "00000.vtp");
  CHECK(array_of<double>(frame, "a&lt;b&gt;&amp;&quot;c&quot;", 1) == Doubles{1, 2});
}

TEST_CASE("a series: numbered frames with their times, a complete list after each") {
  const Folder folder("series");
  auto series =
      vtk_series(folder.path / "run",
                 column("speed", [](double, const auto& y) -> Eigen::VectorXd { return y.v.colwise().norm(); }));
  std::string before;
  for (int n = 0; n < 3; ++n) {
    series(n / 3.0, pair());
    const std::string pvd = text_of(folder.path / "run.pvd");
    check_is_whole(pvd);
    CHECK(pvd.size() > before.size());
    before = pvd;
  }
  CHECK(times_in(before) == "0 0.3333333333333333 0.6666666666666666 ");
  CHECK_THAT(before, contains("<DataSet timestep=\"0.6666666666666666\" part=\"0\" file=\"run/00002.vtp\"/>\n"));
  const std::string frame = text_of(folder.path / "run" / "00002.vtp");
  CHECK(array_of<double>(frame, "TimeValue", 1) == Doubles{2 / 3.0});
  CHECK(array_of<double>(frame, "speed", 1) == Doubles{std::hypot(5, 6), std::hypot(7, 8)});
  CHECK(series.frames().size() == 3);
}

TEST_CASE("a series that runs again starts anew, one that goes on has each time once, and time may run backward") {
  const Folder folder("again");
  auto series = vtk_series(folder.path / "run.pvd");
  const auto run = [&](std::initializer_list<double> times) {
    for (const double t : times) series(t, pair());
    const std::string pvd = text_of(folder.path / "run.pvd");
    check_is_whole(pvd);
    return times_in(pvd);
  };
  CHECK(run({0, 1, 2}) == "0 1 2 ");
  CHECK(run({2, 3}) == "0 1 2 3 ");
  CHECK(run({0, 1}) == "0 1 ");
  CHECK(run({-1, -0.5}) == "-1 -0.5 ");
  auto back = vtk_series(folder.path / "run");
  for (const double t : {1.0, 0.5, 0.0, 0.25}) back(t, pair());
  CHECK(times_in(text_of(folder.path / "run.pvd")) == "1 0.5 0.25 ");
}

TEST_CASE("a series resumes: frames before the first new one stay, later ones are written again") {
  const Folder folder("resume");
  const auto write = [&](VtkOptions options, std::initializer_list<double> times) {
    auto series = vtk_series(folder.path / "run", options);
    for (const double t : times) series(t, pair());
    const std::string pvd = text_of(folder.path / "run.pvd");
    check_is_whole(pvd);
    return times_in(pvd);
  };
  CHECK(write({.resume = true}, {0, 0.1}) == "0 0.1 ");  // nothing there: a first start
  CHECK(write({.resume = true}, {0.2, 0.3, 0.4}) == "0 0.1 0.2 0.3 0.4 ");
  CHECK(write({.resume = true}, {0.3, 0.45}) == "0 0.1 0.2 0.3 0.45 ");  // from a checkpoint at 0.25
  CHECK_THAT(text_of(folder.path / "run.pvd"), contains("timestep=\"0.45\" part=\"0\" file=\"run/00004.vtp\""));
  CHECK(write({}, {0.3}) == "0.3 ");

  {  // cut off in the middle of an entry, as by a lack of power: what is whole is kept
    write({}, {0, 0.1});
    const std::string pvd = text_of(folder.path / "run.pvd");
    std::ofstream(folder.path / "run.pvd", std::ios::binary)
        << pvd.substr(0, pvd.find("part=", pvd.find("timestep=\"0.1")));
    CHECK(write({.resume = true}, {0.5}) == "0 0.5 ");
  }
  // Another program's list, or frames of another kind.
  auto fields = vtk_series(folder.path / "run", VtkGrid{.size = {2}, .spacing = {1}}, {.resume = true});
  CHECK_THROWS_WITH(fields(1.0, Eigen::VectorXd(Eigen::Vector2d(1, 2))), contains("run.pvd lists other files"));
  std::ofstream(folder.path / "run.pvd", std::ios::binary) << "no list";
  auto series = vtk_series(folder.path / "run", {.resume = true});
  CHECK_THROWS_WITH(series(1.0, pair()), contains("run.pvd is no ParaView collection"));
}

TEST_CASE("a list that somebody has changed or removed meanwhile is written again") {
  const Folder folder("changed");
  auto series = vtk_series(folder.path / "run");
  series(0.0, pair());
  fs::remove(folder.path / "run.pvd");
  series(1.0, pair());
  std::ofstream(folder.path / "run.pvd") << "something else";
  series(2.0, pair());
  const std::string pvd = text_of(folder.path / "run.pvd");
  check_is_whole(pvd);
  CHECK(times_in(pvd) == "0 1 2 ");
}

TEST_CASE("what fails names the file and the reason, and leaves the older file") {
  const Folder folder("fails");
  CHECK_THROWS_WITH(write_vtk(folder.path / "missing" / "a.vtp", pair()),
                    contains("phistep: cannot write ") && contains("missing/a.vtp: No such file or directory"));
  auto series = vtk_series(folder.path / "missing" / "run");
  CHECK_THROWS_WITH(series(0.0, pair()), contains("missing/run.pvd: No such file or directory"));
  CHECK_THROWS_AS(vtk_series(""), std::invalid_argument);

  std::ofstream(folder.path / "taken") << "a file where the folder should be";
  auto blocked = vtk_series(folder.path / "taken");
  CHECK_THROWS_WITH(blocked(0.0, pair()), contains("cannot make the folder") && contains("taken"));
#ifdef __linux__
  if (fs::exists("/dev/full")) {
    write_vtk(folder.path / "a.vtp", pair());
    const std::string good = text_of(folder.path / "a.vtp");
    fs::create_symlink("/dev/full", folder.path / "a.vtp.part");
    CHECK_THROWS_WITH(write_vtk(folder.path / "a.vtp", pair()),
                      contains("writing failed: ") && contains("a.vtp: No space left on device"));
    CHECK(text_of(folder.path / "a.vtp") == good);
  }
#endif
}

TEST_CASE("sampled writes frames at exact times, whatever the steps") {
  const Folder folder("sampled");
  auto oscillator = [](const Eigen::Matrix3Xd& r) -> Eigen::Matrix3Xd { return -r; };
  Motion<Eigen::Matrix3Xd> y{Eigen::Matrix3Xd::Ones(3, 2), Eigen::Matrix3Xd::Zero(3, 2)};
  PhiStepper stepper{y, oscillator, velocity_verlet};
  auto series = vtk_series(folder.path / "run");
  REQUIRE(integrate(stepper, y, {0.0, 1.0}, fixed(0.013), sampled(0.25, std::ref(series))));
  CHECK(times_in(text_of(folder.path / "run.pvd")) == "0 0.25 0.5 0.75 1 ");
  const Doubles r = array_of<double>(text_of(folder.path / "run" / "00002.vtp"), "Points", 3);
  for (const double x : r) CHECK(std::abs(x - std::cos(0.5)) < 1e-4);  // the phase is off by t Δt²/24, 4e-6
}

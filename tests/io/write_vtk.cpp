// Writes VTK files of all kinds into the folder argv[1], and prints what is in them, for read_vtk.py to compare with what
// VTK's own readers find: a line for each array, "file where name values…", and others in words. Numbers in hexadecimal.
#include <phistep/integrate.hpp>
#include <phistep/io/vtk.hpp>
#include <phistep/particles.hpp>
#include <phistep/run/observers/at_times.hpp>

#include <Eigen/Core>

#include <cmath>
#include <cstdio>
#include <filesystem>
#include <limits>
#include <string>
#include <vector>

using namespace phistep;

namespace {

void print(const std::string& file, const char* where, const char* name, const auto& values) {
  std::printf("%s %s %s", file.c_str(), where, name);
  for (const auto x : values) std::printf(" %a", static_cast<double>(x));
  std::printf("\n");
}
std::vector<double> list(const Eigen::MatrixXd& x) {  // column by column
  std::vector<double> values(static_cast<std::size_t>(x.size()));
  for (Index k = 0; k < x.size(); ++k) values[static_cast<std::size_t>(k)] = x.data()[k];
  return values;
}
Eigen::MatrixXd in_space(const Eigen::MatrixXd& x) {
  Eigen::MatrixXd padded = Eigen::MatrixXd::Zero(3, x.cols());
  padded.topRows(x.rows()) = x;
  return padded;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) return 2;
  const std::filesystem::path folder = argv[1];
  std::filesystem::remove_all(folder);
  std::filesystem::create_directories(folder);
  const double nan = std::nan(""), infinity = std::numeric_limits<double>::infinity();

  Particles<double, 3, Spin, Temperature> grains{Eigen::Matrix3Xd(Eigen::Matrix3Xd::Random(3, 7))};
  grains.v = Eigen::Matrix3Xd::Random(3, 7);
  grains.v(0, 3) = nan, grains.v(1, 3) = infinity, grains.v(2, 3) = 5e-324;
  grains.omega = Eigen::Matrix3Xd::Random(3, 7);
  grains.temperature.setLinSpaced(7, 300, 301);
  grains.set_mass(Eigen::VectorXd(Eigen::VectorXd::LinSpaced(7, 1, 2))).set_radius(0.1).set_charge(-1.0 / 3);
  grains.set_type(Eigen::VectorXi(Eigen::VectorXi::LinSpaced(7, 0, 6))).set_heat_capacity(2.5);
  grains.set_id({9, 8, 7, 6, 5, 4, 3000000000}).set_still({0, 1, 0, 0, 1, 0, 0});
  const auto print_grains = [&](const std::string& file) {
    print(file, "points", "-", list(grains.r));
    print(file, "point", "velocity", list(grains.v)), print(file, "point", "omega", list(grains.omega));
    print(file, "point", "temperature", list(grains.temperature)), print(file, "point", "id", grains.id());
    print(file, "point", "mass", grains.mass()), print(file, "point", "radius", grains.radius());
    print(file, "point", "charge", grains.charge()), print(file, "point", "type", grains.type());
    print(file, "point", "heat_capacity", grains.body().heat_capacity);
    print(file, "point", "still", grains.body().still);
    std::printf("%s cells - 7\n", file.c_str());
  };
  write_vtk(folder / "grains.vtk", grains);
  print_grains("grains.vtk");
  write_vtk(folder / std::filesystem::path(u8"Körner.vtk"), grains);
  print_grains("Körner.vtk");

  const Motion<Eigen::Matrix2Xf> discs{Eigen::Matrix2Xf::Random(2, 5), Eigen::Matrix2Xf::Random(2, 5)};
  write_vtk(folder / "discs.vtk", discs, {.single = true});
  print("discs.vtk", "points", "-", list(in_space(discs.r.cast<double>())));
  print("discs.vtk", "point", "velocity", list(in_space(discs.v.cast<double>())));
  write_vtk(folder / "none.vtk", Particles<double, 3>{});
  print("none.vtk", "points", "-", std::vector<double>{});
  print("none.vtk", "point", "velocity", std::vector<double>{});
  std::printf("none.vtk cells - 0\n");
  const Motion ball{Eigen::Vector3d(1, 2, 3), Eigen::Vector3d(4, 5, 6)};
  write_vtk(folder / "one.vtk", ball);
  print("one.vtk", "points", "-", list(ball.r)), print("one.vtk", "point", "velocity", list(ball.v));

  const Eigen::VectorXd u = Eigen::VectorXd::Random(48);
  write_vtk(folder / "line.vtk", u, VtkGrid{.size = {48}, .spacing = {0.1}, .origin = {-2}});
  print("line.vtk", "image", "48 1 1", std::vector<double>{-2, 0, 0, 0.1, 1, 1});
  print("line.vtk", "point", "y", u);
  const VtkGrid plate{.size = {6, 8}, .spacing = {0.25, 0.5}, .on_cells = true, .names = {"theta"}};
  write_vtk(folder / "plate.vtk", u, plate, column("two words%", Eigen::VectorXd(2 * u)));
  print("plate.vtk", "image", "7 9 1", std::vector<double>{0, 0, 0, 0.25, 0.5, 1});
  print("plate.vtk", "cell", "theta", u), print("plate.vtk", "cell", "two%20words%25", Eigen::VectorXd(2 * u));
  const VtkGrid block{.size = {2, 3, 4}, .spacing = {1, 2, 3}, .origin = {4, 5, 6}, .names = {"u"}};
  write_vtk(folder / "block.vtk", u, block);
  print("block.vtk", "image", "2 3 4", std::vector<double>{4, 5, 6, 1, 2, 3});
  print("block.vtk", "point", "u", list(u.reshaped(24, 2).transpose()));

  const VtkMesh mesh{
      .lines = {{0, 1}}, .triangles = {{0, 1, 2}, {2, 1, 4}}, .quads = {{0, 1, 4, 3}}, .tetrahedra = {{0, 1, 2, 4}}};
  const Motion<Eigen::Matrix3Xd> net{Eigen::Matrix3Xd::Random(3, 5), Eigen::Matrix3Xd::Random(3, 5)};
  write_vtk(folder / "net.vtk", net, mesh, column("strain", Eigen::Matrix<float, 5, 1>(1, 2, 3, 4, 5)));
  print("net.vtk", "points", "-", list(net.r)), print("net.vtk", "point", "velocity", list(net.v));
  print("net.vtk", "point", "strain", std::vector<double>{1, 2, 3, 4, 5});
  std::printf("net.vtk mesh - 3:0,1 5:0,1,2 5:2,1,4 9:0,1,4,3 10:0,1,2,4\n");

  Motion<Eigen::Matrix3Xd> moving = net;
  PhiStepper stepper{moving, [](const Eigen::Matrix3Xd& r) -> Eigen::Matrix3Xd { return -r; }, velocity_verlet};
  std::vector<double> times;
  const auto note = [&](double t, const auto& y) {
    char name[40];
    std::snprintf(name, sizeof name, "run/%05zu.vtk", times.size());
    times.push_back(t);
    print(name, "points", "-", list(y.r)), print(name, "point", "velocity", list(y.v));
  };
  const auto report =
      integrate(stepper, moving, {0.0, 1.0}, fixed(0.03), sampled(0.2, vtk_series(folder / "run")), sampled(0.2, note));
  print("run.vtk.series", "series", "-", times);
  return report ? 0 : 1;
}

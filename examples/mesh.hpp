// The cloth example's triangle mesh: made as a grid or read from an OFF file, and turned into springs and masses.
#pragma once

#include <phistep/particles/springs/springs.hpp>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <fstream>
#include <map>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "command_line.hpp"

struct Mesh {
  Eigen::Matrix3Xd vertices;                           // [m], one column a vertex
  std::vector<std::array<Eigen::Index, 3>> triangles;  // indices of vertices
};

/// A square of side 1 m with n × n vertices, lying flat but for a ripple of 1 mm that decides which way it folds.
inline Mesh grid(Eigen::Index n) {
  Mesh mesh{Eigen::Matrix3Xd(3, n * n), {}};
  for (Eigen::Index i = 0; i < n * n; ++i) {
    const double x = static_cast<double>(i % n) / static_cast<double>(n - 1),
                 y = static_cast<double>(i / n) / static_cast<double>(n - 1);
    mesh.vertices.col(i) << x, y, 1e-3 * std::sin(17 * x + 5 * y) * std::cos(11 * y);
    if (i % n + 1 == n || i / n + 1 == n) continue;
    mesh.triangles.push_back({i, i + 1, i + n + 1});
    mesh.triangles.push_back({i, i + n + 1, i + n});
  }
  return mesh;
}

/// The n × n square in at most some 60 × 60 cells, for a picture.
inline std::vector<std::array<Eigen::Index, 3>> coarse_triangles(Eigen::Index n) {
  std::vector<std::array<Eigen::Index, 3>> triangles;
  const Eigen::Index cells = std::min<Eigen::Index>(n - 1, 60);
  const auto at = [&](Eigen::Index x, Eigen::Index y) { return (n - 1) * y / cells * n + (n - 1) * x / cells; };
  for (Eigen::Index y = 0; y < cells; ++y)
    for (Eigen::Index x = 0; x < cells; ++x) {
      triangles.push_back({at(x, y), at(x + 1, y), at(x + 1, y + 1)});
      triangles.push_back({at(x, y), at(x + 1, y + 1), at(x, y + 1)});
    }
  return triangles;
}

/// An OFF file in metres; faces of more than three corners are cut into triangles.
inline Mesh read_off(const std::string& path) {
  std::ifstream file(path);
  std::stringstream in;
  for (std::string line; std::getline(file, line);) in << line.substr(0, line.find('#')) << '\n';
  std::string word;
  Eigen::Index vertices = 0, faces = 0, edges = 0;
  if (!(in >> word >> vertices >> faces >> edges) || word != "OFF" || vertices < 3)
    CommandLine::stop(path + " is no OFF file of a mesh");
  Mesh mesh{Eigen::Matrix3Xd(3, vertices), {}};
  for (double& x : mesh.vertices.reshaped()) in >> x;
  for (Eigen::Index f = 0; f < faces; ++f) {
    std::size_t corners = 0;
    in >> corners;
    std::vector<Eigen::Index> face(in && corners < 100 ? corners : 0);
    for (Eigen::Index& i : face) {
      in >> i;
      if (!in || i < 0 || i >= vertices) CommandLine::stop(path + ": face " + std::to_string(f) + " names no vertex");
    }
    std::getline(in, word);  // a colour, perhaps
    for (std::size_t k = 2; k < face.size(); ++k) mesh.triangles.push_back({face[0], face[k - 1], face[k]});
  }
  if (!in && !in.eof()) CommandLine::stop(path + " ends too soon");
  return mesh;
}

/// Every edge a spring; and, against bending and shear, a softer one between the corners that face each other across it.
inline std::vector<phistep::Spring> springs_of(const Mesh& mesh, double stretch, double bend) {
  std::vector<phistep::Spring> springs;
  const auto join = [&](Eigen::Index a, Eigen::Index b, double stiffness) {
    springs.push_back({a, b, stiffness, (mesh.vertices.col(a) - mesh.vertices.col(b)).norm()});
  };
  std::map<std::pair<Eigen::Index, Eigen::Index>, Eigen::Index> corner_at_edge;
  for (const auto& t : mesh.triangles)
    for (std::size_t k = 0; k < 3; ++k) {
      const Eigen::Index a = t[k], b = t[(k + 1) % 3], corner = t[(k + 2) % 3];
      const auto [edge, is_new] = corner_at_edge.try_emplace(std::minmax({a, b}), corner);
      if (is_new) join(a, b, stretch);
      else if (edge->second != corner) join(corner, edge->second, bend);
    }
  return springs;
}

/// A third of each triangle's mass at each of its corners. [kg]
inline Eigen::VectorXd masses_of(const Mesh& mesh, double kg_per_m2) {
  Eigen::VectorXd mass = Eigen::VectorXd::Zero(mesh.vertices.cols());
  for (const auto& t : mesh.triangles) {
    const Eigen::Vector3d a = mesh.vertices.col(t[1]) - mesh.vertices.col(t[0]),
                          b = mesh.vertices.col(t[2]) - mesh.vertices.col(t[0]);
    for (const Eigen::Index i : t) mass[i] += kg_per_m2 * a.cross(b).norm() / 6;
  }
  if (!(mass.minCoeff() > 0))
    CommandLine::stop("the mesh has vertices without a triangle, or triangles without an area");
  return mass;
}

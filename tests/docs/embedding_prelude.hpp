#pragma once

// The existing code that the snippets of docs/embedding.md speak of.
#include <phistep/in_place.hpp>
#include <phistep/io.hpp>
#include <phistep/sparse.hpp>

#include <cstdio>
#include <functional>
#include <tuple>
#include <utility>
#include <vector>

struct Bead {
  double x[3], v[3], f[3];
  double m;
  int type;
};

/// A force with a table inside.
struct Cloth {
  std::vector<double> stiffness{1.0};
  Eigen::VectorXd operator()(const Eigen::VectorXd& r) const { return -stiffness[0] * r; }
};
Eigen::VectorXd decay(const Eigen::VectorXd& y);

extern std::vector<Bead> beads;
extern int n;
extern double (*x)[3], (*w)[3], (*f)[3];           // positions, velocities, forces
extern double *positions, *velocities, *u, *dudt;  // plain arrays

void compute_forces_with_drag(double t);
void compute_rates();
void write_frame(double t, const double* numbers);

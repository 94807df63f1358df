#pragma once

// What preflight computes with dense and sparse matrices of doubles is the same in every test: compiled once, in
// spectrum.cpp and bounds.cpp beside this, and linked. It would cost each test 30 s and 1.4 GB. Same functions, same flags.

#include <phistep/study/stability/stable_step.hpp>

#include <complex>
#include <vector>

namespace phistep { inline namespace PHISTEP_ABI {

// spectrum.cpp
extern template bool is_symmetric<void>(const SparseRows&, double);
extern template DenseSystemMatrices divided<void>(const Tangent&, const PreflightMasses&);
extern template Eigen::VectorXd symmetric_eigenvalues<void>(const SparseRows&, const PreflightMasses&, Eigen::Index&);
extern template bool is_positive_definite<void>(const Eigen::MatrixXd&, double);
extern template std::vector<std::complex<double>> eigenvalues_of<void>(const Eigen::MatrixXd&);
extern template Spectrum exact_spectrum<void>(const Tangent&, const PreflightMasses&, double);

// bounds.cpp
extern template EigenvalueBound largest_eigenvalue_bound<void>(const SparseRows&, const Eigen::VectorXd&, int);
extern template EigenvalueBound spectral_radius_bound<void>(const SparseRows&);
extern template SparseRows divided_by_rows<void>(const SparseRows&, const Eigen::VectorXd&);
extern template Spectrum bound_spectrum<void>(const Tangent&, const PreflightMasses&, int, double);
extern template Spectrum spectrum_of<void>(const Tangent&, const PreflightMasses&, int, double);
extern template Eigen::MatrixXd step_matrix<void>(const Method&, const DenseSystemMatrices&, double);
extern template Eigen::MatrixXd kick_matrix<void>(const DenseSystemMatrices&, double);
extern template double scan_for_stable_step<void>(const Method&, const LinearizedProblem&, const Spectrum&);
extern template double stable_step_of<void>(const Method&, const LinearizedProblem&, const Spectrum&);
extern template double stable_step<void>(const Method&, const LinearizedProblem&, const Spectrum&);

}}  // namespace phistep::PHISTEP_ABI

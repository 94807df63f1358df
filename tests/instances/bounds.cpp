// Bounds of spectra and stable steps, for preflight.hpp beside this.
#include "instances/preflight.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

template EigenvalueBound largest_eigenvalue_bound<void>(const SparseRows&, const Eigen::VectorXd&, int);
template EigenvalueBound spectral_radius_bound<void>(const SparseRows&);
template SparseRows divided_by_rows<void>(const SparseRows&, const Eigen::VectorXd&);
template Spectrum bound_spectrum<void>(const Tangent&, const PreflightMasses&, int, double);
template Spectrum spectrum_of<void>(const Tangent&, const PreflightMasses&, int, double);
template Eigen::MatrixXd step_matrix<void>(const Method&, const DenseSystemMatrices&, double);
template Eigen::MatrixXd kick_matrix<void>(const DenseSystemMatrices&, double);
template double scan_for_stable_step<void>(const Method&, const LinearizedProblem&, const Spectrum&);
template double stable_step_of<void>(const Method&, const LinearizedProblem&, const Spectrum&);
template double stable_step<void>(const Method&, const LinearizedProblem&, const Spectrum&);

}}  // namespace phistep::PHISTEP_ABI

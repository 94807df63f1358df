// Eigenvalues, for preflight.hpp beside this.
#include "instances/preflight.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

template bool is_symmetric<void>(const SparseRows&, double);
template DenseSystemMatrices divided<void>(const Tangent&, const PreflightMasses&);
template Eigen::VectorXd symmetric_eigenvalues<void>(const SparseRows&, const PreflightMasses&, Eigen::Index&);
template bool is_positive_definite<void>(const Eigen::MatrixXd&, double);
template std::vector<std::complex<double>> eigenvalues_of<void>(const Eigen::MatrixXd&);
template Spectrum exact_spectrum<void>(const Tangent&, const PreflightMasses&, double);

}}  // namespace phistep::PHISTEP_ABI

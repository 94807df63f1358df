/// @file
/// phistep: the φ-method for ODEs and motion. Needs Eigen and nothing else.
/// Sparse Jacobians: phistep/sparse.hpp; automatic differentiation: phistep/autodiff.hpp; files, progress: phistep/io.hpp.
#pragma once

// IWYU pragma: begin_exports
#include "phistep/control/fixed_step.hpp"
#include "phistep/core/outcome.hpp"
#include "phistep/core/phi.hpp"
#include "phistep/core/statistics.hpp"
#include "phistep/core/step_report.hpp"
#include "phistep/core/version.hpp"
#include "phistep/force/annotate.hpp"
#include "phistep/force/at.hpp"
#include "phistep/force/drag.hpp"
#include "phistep/force/energy.hpp"
#include "phistep/force/gravity.hpp"
#include "phistep/force/linear.hpp"
#include "phistep/force/local.hpp"
#include "phistep/force/springs.hpp"
#include "phistep/force/sum.hpp"
#include "phistep/force/uniform_force.hpp"
#include "phistep/integrate.hpp"
#include "phistep/jacobian/check_jacobian.hpp"
#include "phistep/linear/mass.hpp"
#include "phistep/observe/energy_ledger.hpp"
#include "phistep/observe/every.hpp"
#include "phistep/observe/recorder.hpp"
#include "phistep/resolve/banded_system.hpp"
#include "phistep/resolve/block_tridiagonal_system.hpp"
#include "phistep/resolve/fixed_point.hpp"
#include "phistep/resolve/newton.hpp"
#include "phistep/state/blocks.hpp"
#include "phistep/state/motion.hpp"
#include "phistep/stepper/halving.hpp"
#include "phistep/stepper/phi_stepper.hpp"
#include "phistep/stepper/rannacher.hpp"
#include "phistep/stepper/tr_bdf2.hpp"
// IWYU pragma: end_exports

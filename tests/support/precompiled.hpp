#pragma once

// What nearly all tests include, compiled once for all of them. Nothing of phistep: whoever edits one of its headers
// compiles what includes it, and no more.

#include <Eigen/Dense>
#include <Eigen/Sparse>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <iomanip>
#include <limits>
#include <memory>
#include <numeric>
#include <random>
#include <sstream>
#include <string>
#include <tuple>
#include <vector>

#include "support/catch.hpp"

#!/bin/sh
# sh scripts/test.sh [ctest options]
# Installs what is missing, builds the tests and runs them. CXX chooses the compiler; the build is in build/test.
set -eu
cd "$(dirname "$0")/.."
. scripts/setup.sh

phistep_setup libeigen3-dev catch2 libsundials-dev

# Optimised, but with Eigen's assertions on: Release would define NDEBUG. -O1 takes a quarter less time to compile than -O2,
# at which stress.sh, and -O3, at which the preset `release` compiles.
phistep_configure build/test -DCMAKE_BUILD_TYPE=Release -DCMAKE_CXX_FLAGS_RELEASE=-O1 -DPHISTEP_BUILD_BENCH=OFF
cmake --build build/test -j "$jobs" || phistep_die "the build failed; the first error above is the one to look at."
ctest --test-dir build/test -j "$jobs" --output-on-failure --no-tests=error "$@"

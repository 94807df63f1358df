#!/bin/sh
# sh scripts/test.sh [ctest options]
# Installs what is missing, builds the quick tests and runs them: about 11 minutes on two slow cores, wanted eight. What takes longer is in
# full.sh (CI runs both) and stress.sh. CXX chooses the compiler; the build is in build/test.
set -eu
cd "$(dirname "$0")/.."
. scripts/setup.sh

phistep_setup libeigen3-dev catch2 libsundials-dev python3
phistep_configure_tests build/test -DPHISTEP_FULL=OFF -DPHISTEP_BUILD_EXAMPLES=OFF
phistep_build_and_run quick "$@"

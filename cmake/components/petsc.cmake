# phistep::petsc is phistep::phistep with <phistep/petsc.hpp>: states spread over ranks as Vecs of PETSc, found by pkg-config,
# and MPI. (What a component is: openmp.cmake.)

find_package(PkgConfig QUIET)
if(PkgConfig_FOUND AND NOT TARGET PkgConfig::PHISTEP_PETSC)
  pkg_search_module(PHISTEP_PETSC QUIET IMPORTED_TARGET GLOBAL PETSc petsc)
endif()

if(TARGET PkgConfig::PHISTEP_PETSC)
  include("${CMAKE_CURRENT_LIST_DIR}/shared/on_mpi.cmake")
  phistep_component_on_mpi(petsc PkgConfig::PHISTEP_PETSC)
else()
  set(phistep_petsc_MISSING "pkg-config finds no PETSc (Debian, Ubuntu: apt install petsc-dev pkg-config; one of your own: set \
PKG_CONFIG_PATH to $PETSC_DIR/$PETSC_ARCH/lib/pkgconfig)")
endif()

# phistep::petsc is phistep::phistep with <phistep/petsc.hpp>: states spread over ranks as Vecs of PETSc, found by pkg-config,
# and MPI. (What a component is: openmp.cmake.)

find_package(PkgConfig QUIET)
if(PkgConfig_FOUND AND NOT TARGET PkgConfig::PHISTEP_PETSC)
  pkg_search_module(PHISTEP_PETSC QUIET IMPORTED_TARGET GLOBAL PETSc petsc)
endif()
if(NOT TARGET MPI::MPI_CXX)
  find_package(MPI QUIET COMPONENTS CXX)
  if(TARGET MPI::MPI_CXX)
    set_target_properties(MPI::MPI_CXX PROPERTIES IMPORTED_GLOBAL TRUE)
  endif()
endif()

if(NOT TARGET PkgConfig::PHISTEP_PETSC)
  set(phistep_petsc_MISSING "pkg-config finds no PETSc (Debian, Ubuntu: apt install petsc-dev pkg-config; one of your own: set \
PKG_CONFIG_PATH to $PETSC_DIR/$PETSC_ARCH/lib/pkgconfig)")
elseif(NOT TARGET MPI::MPI_CXX)
  set(phistep_petsc_MISSING "CMake finds no MPI for C++ (Debian, Ubuntu: apt install mpi-default-dev mpi-default-bin)")
elseif(NOT TARGET phistep::petsc)
  add_library(phistep::petsc INTERFACE IMPORTED GLOBAL)
  target_link_libraries(phistep::petsc INTERFACE phistep::phistep PkgConfig::PHISTEP_PETSC MPI::MPI_CXX)
  # Where phistep is installed, the header lies beside the others.
  if(EXISTS "${CMAKE_CURRENT_LIST_DIR}/../../adapters/petsc")
    cmake_path(SET phistep_petsc_dir NORMALIZE "${CMAKE_CURRENT_LIST_DIR}/../../adapters/petsc")
    target_include_directories(phistep::petsc INTERFACE "${phistep_petsc_dir}")
  endif()
endif()

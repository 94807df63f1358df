# phistep::sundials is phistep::phistep with <phistep/sundials.hpp>: N_Vectors of SUNDIALS 6 as states, and MPI. The libraries of
# the vectors, matrices and solvers that a program makes are the program's to name: target_link_libraries(program PRIVATE
# phistep::sundials sundials_nvecparallel sundials_sunlinsolspgmr). (What a component is: openmp.cmake.)

# By header and library: SUNDIALSConfig.cmake asks for all that the distribution built SUNDIALS with.
find_path(PHISTEP_SUNDIALS_ON_MPI nvector/nvector_mpimanyvector.h HINTS ${SUNDIALS_ROOT} $ENV{SUNDIALS_ROOT} PATH_SUFFIXES include)
find_library(PHISTEP_SUNDIALS_GENERIC sundials_generic HINTS ${SUNDIALS_ROOT} $ENV{SUNDIALS_ROOT} PATH_SUFFIXES lib lib64)
if(PHISTEP_SUNDIALS_ON_MPI AND PHISTEP_SUNDIALS_GENERIC)
  include("${CMAKE_CURRENT_LIST_DIR}/shared/on_mpi.cmake")
  phistep_component_on_mpi(sundials "${PHISTEP_SUNDIALS_GENERIC}")
  if(TARGET phistep::sundials)
    target_include_directories(phistep::sundials SYSTEM INTERFACE "${PHISTEP_SUNDIALS_ON_MPI}")
  endif()
else()
  set(phistep_sundials_MISSING "CMake finds no SUNDIALS 6 with MPI (Debian, Ubuntu: apt install libsundials-dev mpi-default-dev; \
one of your own: set SUNDIALS_ROOT)")
endif()

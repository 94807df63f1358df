# phistep_sundials: CVODE and ARKODE with serial vectors and dense matrices, for the reference tests. Not defined if there
# is none.
#
# Found by header and library rather than by SUNDIALSConfig.cmake: that file asks for MPI, PETSc, hypre and OpenMP
# wherever the distribution built SUNDIALS with them, and nothing of it is needed here.

find_path(PHISTEP_SUNDIALS_INCLUDE cvode/cvode.h HINTS ${SUNDIALS_ROOT} $ENV{SUNDIALS_ROOT} PATH_SUFFIXES include)
set(sundials_libraries)
set(sundials_complete TRUE)
foreach(part cvode arkode nvecserial sunmatrixdense sunlinsoldense)
  find_library(PHISTEP_SUNDIALS_${part} sundials_${part} HINTS ${SUNDIALS_ROOT} $ENV{SUNDIALS_ROOT} PATH_SUFFIXES lib lib64)
  if(NOT PHISTEP_SUNDIALS_${part})
    set(sundials_complete FALSE)
  endif()
  list(APPEND sundials_libraries "${PHISTEP_SUNDIALS_${part}}")
endforeach()

if(PHISTEP_SUNDIALS_INCLUDE AND sundials_complete)
  file(STRINGS "${PHISTEP_SUNDIALS_INCLUDE}/sundials/sundials_config.h" sundials_config REGEX "^#define SUNDIALS_")
  string(REGEX MATCH "SUNDIALS_VERSION \"([0-9.]+)" _ "${sundials_config}")
  set(sundials_version "${CMAKE_MATCH_1}")
  add_library(phistep_sundials INTERFACE)
  target_include_directories(phistep_sundials SYSTEM INTERFACE "${PHISTEP_SUNDIALS_INCLUDE}")
  if(sundials_version VERSION_GREATER_EQUAL 7)
    find_library(PHISTEP_SUNDIALS_core sundials_core HINTS ${SUNDIALS_ROOT} $ENV{SUNDIALS_ROOT} PATH_SUFFIXES lib lib64 REQUIRED)
    list(APPEND sundials_libraries "${PHISTEP_SUNDIALS_core}")
    if(sundials_config MATCHES "SUNDIALS_MPI_ENABLED 1")  # its headers then include mpi.h
      find_package(MPI REQUIRED COMPONENTS CXX)
      target_link_libraries(phistep_sundials INTERFACE MPI::MPI_CXX)
    endif()
  endif()
  target_link_libraries(phistep_sundials INTERFACE ${sundials_libraries} ${CMAKE_DL_LIBS})
  if(UNIX)
    target_link_libraries(phistep_sundials INTERFACE m)
  endif()
  message(STATUS "phistep: SUNDIALS ${sundials_version} (${PHISTEP_SUNDIALS_cvode})")
  return()
endif()

if(NOT PHISTEP_FETCH)
  message(STATUS "phistep: no SUNDIALS, the reference tests are skipped (Debian, Ubuntu: apt install libsundials-dev)")
  return()
endif()

include(CheckLanguage)
check_language(C)
if(NOT CMAKE_C_COMPILER)
  message(STATUS "phistep: no C compiler to build SUNDIALS with, the reference tests are skipped")
  return()
endif()
enable_language(C)

include(phistep_fetch)
set(BUILD_SHARED_LIBS OFF)
set(BUILD_STATIC_LIBS ON)
foreach(part CVODES IDA IDAS KINSOL)
  set(BUILD_${part} OFF)
endforeach()
foreach(part C CXX)
  set(EXAMPLES_ENABLE_${part} OFF)
endforeach()
set(EXAMPLES_INSTALL OFF)
set(CMAKE_POLICY_DEFAULT_CMP0077 NEW)  # so that SUNDIALS takes these as its options
phistep_fetch(phistep_sundials_source
  URL https://github.com/LLNL/sundials/releases/download/v6.7.0/sundials-6.7.0.tar.gz
  SHA256 5f113a1564a9d2d98ff95249f4871a4c815a05dbb9b8866a82b13ab158c37adb
  CURE "The reference tests are skipped; install SUNDIALS for them (Debian, Ubuntu: apt install libsundials-dev)"
  RUN_CMAKELISTS OPTIONAL)
if(NOT phistep_sundials_source_FOUND)
  return()
endif()
add_library(phistep_sundials INTERFACE)
foreach(part cvode arkode nvecserial sunmatrixdense sunlinsoldense)
  foreach(candidate sundials_${part}_static SUNDIALS::${part}_static SUNDIALS::${part})
    if(TARGET ${candidate})
      target_link_libraries(phistep_sundials INTERFACE ${candidate})
      break()
    endif()
  endforeach()
endforeach()
message(STATUS "phistep: SUNDIALS 6.7.0, downloaded")

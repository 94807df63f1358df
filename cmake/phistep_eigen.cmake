# Eigen3::Eigen, the only public dependency: the caller's target, else the installed one, else the pinned download.
# IMPORTED_GLOBAL, because a project that adds this one as a folder links to it from outside (GLOBAL is known from CMake 3.24 on).

if(TARGET Eigen3::Eigen)
  return()
endif()

foreach(major 3.4 5)
  find_package(Eigen3 ${major} CONFIG QUIET)
  if(Eigen3_FOUND)
    set_target_properties(Eigen3::Eigen PROPERTIES IMPORTED_GLOBAL TRUE)
    message(STATUS "phistep: Eigen ${Eigen3_VERSION} (${Eigen3_DIR})")
    return()
  endif()
endforeach()

string(CONCAT eigen_cure
  "Install it (Debian, Ubuntu: apt install libeigen3-dev), or set Eigen3_DIR to the folder of Eigen3Config.cmake, "
  "or set FETCHCONTENT_SOURCE_DIR_PHISTEP_EIGEN to an unpacked Eigen 3.4.0")
if(NOT PHISTEP_FETCH)
  message(FATAL_ERROR "phistep needs Eigen 3.4 or later. ${eigen_cure}, or set PHISTEP_FETCH=ON to download it.")
endif()

include(phistep_fetch)
phistep_fetch(phistep_eigen
  URL https://gitlab.com/libeigen/eigen/-/archive/3.4.0/eigen-3.4.0.tar.gz
  SHA256 8586084f71f9bde545ee7fa6d00288b264a2b7ac3607b974e54d13e7162c1c72
  CURE "${eigen_cure}")

# Eigen's own CMakeLists adds hundreds of targets and options. A small package over its headers is all that is needed,
# and the test of the installed copy can be pointed at it too.
set(eigen_package "${CMAKE_CURRENT_BINARY_DIR}/eigen-package")
file(WRITE "${eigen_package}/Eigen3Config.cmake"
  "if(NOT TARGET Eigen3::Eigen)\n"
  "  add_library(Eigen3::Eigen INTERFACE IMPORTED)\n"
  "  target_include_directories(Eigen3::Eigen SYSTEM INTERFACE \"${phistep_eigen_SOURCE_DIR}\")\n"
  "endif()\n"
  "set(Eigen3_VERSION 3.4.0)\n")
file(WRITE "${eigen_package}/Eigen3ConfigVersion.cmake"
  "set(PACKAGE_VERSION 3.4.0)\n"
  "if(NOT PACKAGE_FIND_VERSION VERSION_GREATER 3.4.0)\n"
  "  set(PACKAGE_VERSION_COMPATIBLE TRUE)\n"
  "endif()\n")
set(Eigen3_DIR "${eigen_package}" CACHE PATH "Eigen, downloaded" FORCE)
find_package(Eigen3 3.4 CONFIG REQUIRED)
set_target_properties(Eigen3::Eigen PROPERTIES IMPORTED_GLOBAL TRUE)

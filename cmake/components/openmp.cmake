# phistep::openmp is phistep::phistep with OpenMP: sums over many particles and long states share threads.
#
# A component is a file <name>.cmake in this folder. It makes the target phistep::<name>, or says in phistep_<name>_MISSING
# what is missing and how to get it. find_package reads it where phistep is installed, CMakeLists.txt (PHISTEP_COMPONENTS)
# where it is a folder of the project.

if(NOT TARGET OpenMP::OpenMP_CXX)
  find_package(OpenMP QUIET COMPONENTS CXX)
  if(TARGET OpenMP::OpenMP_CXX)
    set_target_properties(OpenMP::OpenMP_CXX PROPERTIES IMPORTED_GLOBAL TRUE)
  endif()
endif()

if(NOT TARGET OpenMP::OpenMP_CXX)
  set(phistep_openmp_MISSING "CMake finds no OpenMP for this compiler (clang on Debian, Ubuntu: apt install libomp-dev; \
macOS: brew install libomp, and set OpenMP_ROOT to its folder; the language CXX must be enabled)")
elseif(NOT TARGET phistep::openmp)
  add_library(phistep::openmp INTERFACE IMPORTED GLOBAL)
  target_link_libraries(phistep::openmp INTERFACE phistep::phistep OpenMP::OpenMP_CXX)
endif()

# phistep_catch2: Catch2 with its main, compiled once. Version 3 or 2.13, installed or else downloaded.

find_package(Catch2 3 CONFIG QUIET)
if(NOT Catch2_FOUND)
  find_package(Catch2 2.13 CONFIG QUIET)
endif()

if(NOT Catch2_FOUND)
  include(phistep_fetch)
  phistep_fetch(phistep_catch2_source
    URL https://github.com/catchorg/Catch2/archive/refs/tags/v3.8.1.tar.gz
    SHA256 18b3f70ac80fccc340d8c6ff0f339b2ae64944782f8d2fca2bd705cf47cadb79
    CURE "Install it (Debian, Ubuntu: apt install catch2), or switch the tests off with PHISTEP_BUILD_TESTS=OFF, \
or set FETCHCONTENT_SOURCE_DIR_PHISTEP_CATCH2_SOURCE to an unpacked Catch2 3.8.1"
    RUN_CMAKELISTS)
  set(Catch2_VERSION 3.8.1)
  if(PHISTEP_SANITIZE)
    # One vector checked on one side of a call and not on the other makes AddressSanitizer report a false overflow.
    target_compile_options(Catch2 PRIVATE -fsanitize=${PHISTEP_SANITIZE})
    target_compile_options(Catch2WithMain PRIVATE -fsanitize=${PHISTEP_SANITIZE})
  endif()
endif()
message(STATUS "phistep: Catch2 ${Catch2_VERSION}")

if(Catch2_VERSION VERSION_LESS 3)
  add_library(phistep_catch2 STATIC main.cpp)
  if(NOT MSVC)
    set_source_files_properties(main.cpp PROPERTIES COMPILE_OPTIONS -O0)  # reports; half the time to compile
  endif()
  target_compile_features(phistep_catch2 PUBLIC cxx_std_20)
  target_link_libraries(phistep_catch2 PUBLIC Catch2::Catch2)
else()
  add_library(phistep_catch2 INTERFACE)
  target_link_libraries(phistep_catch2 INTERFACE Catch2::Catch2WithMain)
endif()

# cmake [-D UMBRELLA=all.hpp] [-D OUT=phistep.hpp] -P scripts/single_header.cmake
#
# Writes one header that holds include/phistep/<UMBRELLA> and all of phistep that it includes, each header once, in the order in
# which a compiler meets them. Eigen and the standard library stay outside. It is written in CMake's language, because that is
# what any platform that builds phistep has.

cmake_minimum_required(VERSION 3.22)

if(NOT UMBRELLA)
  set(UMBRELLA all.hpp)
endif()
if(NOT OUT)
  set(OUT phistep.hpp)
endif()
get_filename_component(OUT "${OUT}" ABSOLUTE BASE_DIR "${CMAKE_CURRENT_BINARY_DIR}")
get_filename_component(root "${CMAKE_CURRENT_LIST_DIR}/.." ABSOLUTE)
if(NOT EXISTS "${root}/include/phistep/${UMBRELLA}")
  message(FATAL_ERROR "there is no header phistep/${UMBRELLA} (UMBRELLA)")
endif()

set(inclusion "\n#include \"(phistep/[^\"]+)\"")

# Appends a header to the file OUT, what it includes first. Quotes keep every ";" and "[" of the text as it is.
function(add_header name)
  get_property(added GLOBAL PROPERTY added)
  if(name IN_LIST added)
    return()
  endif()
  set_property(GLOBAL APPEND PROPERTY added "${name}")
  file(READ "${root}/include/${name}" text)
  string(PREPEND text "\n")
  string(REPLACE "\n#pragma once\n" "\n" text "${text}")
  if(text MATCHES "\n[ \t]+#[ \t]*include \"phistep|\n#[ \t]+include \"phistep|\n#include <phistep")
    message(FATAL_ERROR "${name}: an include of phistep that is not written #include \"phistep/...\" at the line's start")
  endif()
  file(APPEND "${OUT}" "\n// ---- ${name}\n")
  while(text MATCHES "${inclusion}")
    set(line "${CMAKE_MATCH_0}")
    set(included "${CMAKE_MATCH_1}")
    string(FIND "${text}" "${line}" start)
    string(LENGTH "${line}" length)
    string(SUBSTRING "${text}" 0 ${start} before)
    math(EXPR start "${start} + ${length}")
    string(SUBSTRING "${text}" ${start} -1 text)
    # What is included within #if would be missing for who includes it outside of it.
    string(REGEX MATCHALL "\n#[ \t]*if" opened "${before}")
    string(REGEX MATCHALL "\n#[ \t]*endif" closed "${before}")
    list(LENGTH opened opened)
    list(LENGTH closed closed)
    if(NOT opened EQUAL closed)
      message(FATAL_ERROR "${name}: #include \"${included}\" stands within #if")
    endif()
    file(APPEND "${OUT}" "${before}\n")
    add_header("${included}")
  endwhile()
  file(APPEND "${OUT}" "${text}")
endfunction()

file(STRINGS "${root}/include/phistep/base/version.hpp" version REGEX "^#define PHISTEP_VERSION_(MAJOR|MINOR|PATCH) [0-9]+$")
string(REGEX REPLACE "#define PHISTEP_VERSION_[A-Z]+ " "" version "${version}")
list(JOIN version "." version)
file(READ "${root}/LICENSE" licence)
string(REGEX REPLACE "\n+$" "" licence "${licence}")
string(REPLACE "\n" "\n// " licence "${licence}")
string(REPLACE "// \n" "//\n" licence "${licence}")
file(WRITE "${OUT}" "// phistep ${version}: phistep/${UMBRELLA} as one header, made by scripts/single_header.cmake. Needs Eigen and C++20.\n//\n"
  "// ${licence}\n#pragma once\n")
add_header("phistep/${UMBRELLA}")

get_property(added GLOBAL PROPERTY added)
list(LENGTH added count)
message(STATUS "${OUT}: ${count} headers of phistep ${version}")

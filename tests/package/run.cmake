# Configures, builds and runs a small project outside this one that uses phistep in one of three ways (HOW):
# an installed copy, add_subdirectory, or nothing but -isystem include. No network is needed for any. Warnings that the
# headers don't avoid must not reach those who turn them on for their own code.

cmake_minimum_required(VERSION 3.25)

function(run what)
  execute_process(COMMAND ${ARGN} RESULT_VARIABLE result OUTPUT_VARIABLE output ERROR_VARIABLE output)
  if(NOT result EQUAL 0)
    list(JOIN ARGN " " command)
    message(NOTICE "${output}")
    message(FATAL_ERROR "${what} failed (${result}): ${command}")
  endif()
  message(STATUS "${what}: done")
endfunction()

set(warnings -Wno-unknown-warning-option -Wall -Wextra -Weffc++ -Wfloat-equal -Wuseless-cast -Wdouble-promotion -Wconversion
  -Wshadow -Werror)
set(work "${WORK_DIR}/${HOW}")
file(REMOVE_RECURSE "${work}")
file(MAKE_DIRECTORY "${work}")

if(HOW STREQUAL "plain_include")
  set(flags ${warnings} -isystem "${PHISTEP_DIR}/include")
  foreach(dir ${SYSTEM_DIRS})
    list(APPEND flags -isystem "${dir}")
  endforeach()
  run("compile" "${COMPILER}" -std=c++20 ${flags} "${CMAKE_CURRENT_LIST_DIR}/main.cpp" -o "${work}/consumer")
  run("run" "${work}/consumer")
  # g++ 12 takes its own AVX-512 functions for uninitialised wherever they end up, system headers or not.
  execute_process(COMMAND "${COMPILER}" -dumpmachine OUTPUT_VARIABLE machine)
  if(machine MATCHES "^x86_64")
    run("compile for AVX-512" "${COMPILER}" -std=c++20 ${flags} -O3 -march=skylake-avx512 -c
      "${CMAKE_CURRENT_LIST_DIR}/implicit.cpp" -o "${work}/implicit.o")
  endif()
  return()
endif()

set(options -G "${GENERATOR}" "-DCMAKE_MAKE_PROGRAM=${MAKE_PROGRAM}" "-DCMAKE_CXX_COMPILER=${COMPILER}"
  -DCMAKE_BUILD_TYPE=Debug -DFETCHCONTENT_FULLY_DISCONNECTED=ON)
list(JOIN warnings " " flags)
list(APPEND options "-DCMAKE_CXX_FLAGS=${flags}")
if(EIGEN_DIR)
  list(APPEND options "-DEigen3_DIR=${EIGEN_DIR}")
endif()

if(HOW STREQUAL "find_package")
  run("configure phistep" "${CMAKE_COMMAND}" -S "${PHISTEP_DIR}" -B "${work}/phistep" ${options}
    -DPHISTEP_BUILD_TESTS=OFF -DPHISTEP_BUILD_EXAMPLES=OFF -DPHISTEP_BUILD_BENCH=OFF
    "-DCMAKE_INSTALL_PREFIX=${work}/prefix")
  run("install phistep" "${CMAKE_COMMAND}" --install "${work}/phistep")
  list(APPEND options "-DCMAKE_PREFIX_PATH=${work}/prefix" -DCMAKE_FIND_USE_PACKAGE_REGISTRY=OFF)
else()
  list(APPEND options "-DPHISTEP_DIR=${PHISTEP_DIR}")
endif()

run("configure" "${CMAKE_COMMAND}" -S "${CMAKE_CURRENT_LIST_DIR}/${HOW}" -B "${work}/build" ${options})
run("build" "${CMAKE_COMMAND}" --build "${work}/build")
run("run" "${CMAKE_CTEST_COMMAND}" --test-dir "${work}/build" --output-on-failure --no-tests=error)

# cmake -DSOURCE_DIR=<project> -P check_mutations.cmake
#
# Every patch of tests/mutations/ says what it breaks and applies (where `patch` is installed), and each folder of
# include/phistep has two at least.

cmake_minimum_required(VERSION 3.25)

include("${CMAKE_CURRENT_LIST_DIR}/../support/problems.cmake")

find_program(patch patch)
file(GLOB patches "${SOURCE_DIR}/tests/mutations/*.patch")
foreach(file ${patches})
  cmake_path(GET file STEM name)
  file(READ "${file}" text)
  if(NOT text MATCHES "^[^\n]+\\.\n\n--- a/include/phistep/([^\n]+)\n")
    problem("${name}: begins with a sentence, an empty line and the patch of a header")
    continue()
  endif()
  set(header "${CMAKE_MATCH_1}")
  if(header MATCHES "^([^/]+)/")
    list(APPEND broken_in_${CMAKE_MATCH_1} ${name})
  endif()
  if(patch)
    execute_process(COMMAND "${patch}" --dry-run -s -p1 -i "${file}" WORKING_DIRECTORY "${SOURCE_DIR}"
      RESULT_VARIABLE result OUTPUT_QUIET ERROR_QUIET)
    if(NOT result EQUAL 0)
      problem("${name} no longer applies to ${header}")
    endif()
  endif()
endforeach()

file(GLOB rooms LIST_DIRECTORIES true RELATIVE "${SOURCE_DIR}/include/phistep" "${SOURCE_DIR}/include/phistep/*")
foreach(room ${rooms})
  if(IS_DIRECTORY "${SOURCE_DIR}/include/phistep/${room}")
    list(LENGTH broken_in_${room} count)
    if(count LESS 2)
      problem("${room}/: ${count} break(s) in tests/mutations, two at least are wanted")
    endif()
  endif()
endforeach()

list(LENGTH patches count)
if(problems GREATER 0)
  message(FATAL_ERROR "mutations: ${problems} problem(s) in ${count} patches")
endif()
message(STATUS "${count} breaks, each with its sentence")

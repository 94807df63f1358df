# cmake -DCOMPILER=... -DSOURCE=... -DINCLUDE_DIR=... -DSYSTEM_DIRS=... -DWARNINGS=... [-DPRECOMPILED_DIR=...] [-DQUICK=ON] -P check.cmake
#
# Compiles SOURCE as it stands, which must succeed, and with MUST_FAIL defined, which must fail. The first line of the
# file says what the first error has to contain; a second may allow more errors than three:
#   // expect: a regular expression
#   // errors: 5
# QUICK looks at the first error alone, which is where the compiler then stops: neither at the number of errors nor at the
# source without MUST_FAIL.

cmake_minimum_required(VERSION 3.25)

file(READ "${SOURCE}" text)
if(NOT text MATCHES "^// expect: ([^\n]+)\n")
  message(FATAL_ERROR "${SOURCE}: the first line must read \"// expect: <regular expression>\"")
endif()
set(expect "${CMAKE_MATCH_1}")
set(allowed 3)
if(text MATCHES "\n// errors: ([0-9]+)\n")
  set(allowed "${CMAKE_MATCH_1}")
endif()
if(NOT text MATCHES "MUST_FAIL")
  message(FATAL_ERROR "${SOURCE}: has no part under #ifdef MUST_FAIL")
endif()

set(command "${COMPILER}" -std=c++20 -fsyntax-only ${WARNINGS} -Werror=unused-result)
if(QUICK)
  list(APPEND command -Wfatal-errors)
endif()
foreach(dir ${PRECOMPILED_DIR} ${INCLUDE_DIR})
  list(APPEND command "-I${dir}")
endforeach()
foreach(dir ${SYSTEM_DIRS})
  list(APPEND command -isystem "${dir}")
endforeach()

set(ENV{LC_ALL} C)  # untranslated messages

if(NOT QUICK)
  execute_process(COMMAND ${command} "${SOURCE}" RESULT_VARIABLE result OUTPUT_VARIABLE output ERROR_VARIABLE output)
  if(NOT result EQUAL 0)
    message(NOTICE "${output}")
    message(FATAL_ERROR "${SOURCE} must compile without MUST_FAIL")
  endif()
endif()

execute_process(COMMAND ${command} -DMUST_FAIL "${SOURCE}"
  RESULT_VARIABLE result OUTPUT_VARIABLE output ERROR_VARIABLE output)
if(result EQUAL 0)
  message(FATAL_ERROR "${SOURCE} compiles with MUST_FAIL")
endif()

# Semicolons and brackets would be read as list syntax.
string(REPLACE ";" "," lines "${output}")
string(REPLACE "[" "(" lines "${lines}")
string(REPLACE "]" ")" lines "${lines}")
string(REPLACE "\n" ";" lines "${lines}")
list(LENGTH lines line_count)
list(FILTER lines INCLUDE REGEX "error: ")  # "fatal error: ", too
list(LENGTH lines error_count)
list(GET lines 0 first)

if(NOT first MATCHES "${expect}")
  message(NOTICE "${output}")
  message(FATAL_ERROR "${SOURCE}: the first error should contain\n  ${expect}\nbut is\n  ${first}")
endif()
if(error_count GREATER allowed)
  message(NOTICE "${output}")
  message(FATAL_ERROR "${SOURCE}: ${error_count} errors, at most ${allowed} wanted")
endif()
message(STATUS "${error_count} error(s), ${line_count} lines; the first: ${first}")

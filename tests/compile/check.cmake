# cmake -DCOMPILER=... -DSOURCE=... -DINCLUDE_DIR=... -DSYSTEM_DIRS=... -DWARNINGS=... [-DPRECOMPILED_DIR=...] [-DQUICK=ON] -P check.cmake
#
# Compiles SOURCE as it stands, which must succeed, and with MUST_FAIL defined, which must fail. The first line of the
# file says what the first error has to contain; others may allow more errors than three, and limit the lines of output
# (those that say who includes whom not counted):
#   // expect: a regular expression (a semicolon in the message reads as a comma)
#   // errors: 5
#   // lines: 20
# or add flags: to both compilations, or to the one that must fail alone:
#   // flags: -fno-rtti
#   // failing flags: -fno-exceptions
# QUICK looks at the first error alone, which is where the compiler then stops: neither at the number of errors nor at the
# source without MUST_FAIL, unless that is where the news is:
#   // quick: as it stands, too

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
set(allowed_lines 1000000)
if(text MATCHES "\n// lines: ([0-9]+)\n")
  set(allowed_lines "${CMAKE_MATCH_1}")
endif()
if(NOT text MATCHES "MUST_FAIL|failing flags")
  message(FATAL_ERROR "${SOURCE}: has no part under #ifdef MUST_FAIL")
endif()

set(command "${COMPILER}" -std=c++20 -O1 -fsyntax-only ${WARNINGS} -Werror=unused-result)
if(QUICK)
  list(APPEND command -Wfatal-errors)
endif()
foreach(dir ${PRECOMPILED_DIR} ${INCLUDE_DIR})
  list(APPEND command "-I${dir}")
endforeach()
foreach(dir ${SYSTEM_DIRS})
  list(APPEND command -isystem "${dir}")
endforeach()

set(failing_flags)
if(text MATCHES "\n// flags: ([^\n]+)\n")
  list(APPEND command "${CMAKE_MATCH_1}")
endif()
if(text MATCHES "\n// failing flags: ([^\n]+)\n")
  set(failing_flags "${CMAKE_MATCH_1}")
endif()

set(ENV{LC_ALL} C)  # untranslated messages

if(NOT QUICK OR text MATCHES "\n// quick: as it stands, too\n")
  execute_process(COMMAND ${command} "${SOURCE}" RESULT_VARIABLE result OUTPUT_VARIABLE output ERROR_VARIABLE output)
  if(NOT result EQUAL 0)
    message(NOTICE "${output}")
    message(FATAL_ERROR "${SOURCE} must compile without MUST_FAIL")
  endif()
endif()

execute_process(COMMAND ${command} ${failing_flags} -DMUST_FAIL "${SOURCE}"
  RESULT_VARIABLE result OUTPUT_VARIABLE output ERROR_VARIABLE output)
if(result EQUAL 0)
  message(FATAL_ERROR "${SOURCE} compiles with MUST_FAIL")
endif()

# Semicolons and brackets would be read as list syntax.
string(REPLACE ";" "," lines "${output}")
string(REPLACE "[" "(" lines "${lines}")
string(REPLACE "]" ")" lines "${lines}")
string(REPLACE "\n" ";" lines "${lines}")
list(FILTER lines EXCLUDE REGEX "^(In file included| +from )")  # as many as the way to the header has stations
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
if(line_count GREATER allowed_lines)
  message(NOTICE "${output}")
  message(FATAL_ERROR "${SOURCE}: ${line_count} lines, at most ${allowed_lines} wanted")
endif()
message(STATUS "${error_count} error(s), ${line_count} lines; the first: ${first}")

# cmake -DPAGE=<docs/errors.md> -DHEADER=<base/outcome/outcome.hpp> -P check_outcomes.cmake
#
# Every value of the enum Outcome has a section of the page, headed ### `name`, in the order of the enum, and its words, as
# describe(Outcome) has them, stand in one of the page's outputs. No section is about another name.

cmake_minimum_required(VERSION 3.25)

include("${CMAKE_CURRENT_LIST_DIR}/../support/problems.cmake")

read_plain("${HEADER}" header)
read_plain("${PAGE}" page)
if(NOT header MATCHES "enum class Outcome[^{]*{([^}]*)}")
  message(FATAL_ERROR "${HEADER}: no enum class Outcome")
endif()
string(REGEX REPLACE "//[^\n]*" "" names "${CMAKE_MATCH_1}")
string(REGEX MATCHALL "[a-z_0-9]+" names "${names}")

string(REGEX MATCHALL "\n### `[a-z_0-9]+`\n" headings "${page}")
list(TRANSFORM headings REPLACE "[^a-z_0-9]" "")

foreach(name IN LISTS names)
  if(NOT name IN_LIST headings)
    problem("${PAGE}: no section ### `${name}`")
  endif()
  if(NOT header MATCHES "{${name},[ \n]*\"([^\"]*)\"")
    problem("${HEADER}: describe() has no words for ${name}")
  else()
    string(FIND "${page}" "${CMAKE_MATCH_1}" at)
    if(at EQUAL -1)
      problem("${PAGE}: nowhere the words of ${name}, \"${CMAKE_MATCH_1}\"")
    endif()
  endif()
endforeach()
foreach(name IN LISTS headings)
  if(NOT name IN_LIST names)
    problem("${PAGE}: ### `${name}` is no Outcome")
  endif()
endforeach()
if(problems EQUAL 0 AND NOT "${names}" STREQUAL "${headings}")
  problem("${PAGE}: the sections are not in the order of the enum, ${names}")
endif()

if(problems GREATER 0)
  message(FATAL_ERROR "${problems} faults among the outcomes")
endif()
list(LENGTH names count)
message(STATUS "${count} outcomes, each with its section")

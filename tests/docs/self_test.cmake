# cmake -DWORK_DIR=<scratch> -P self_test.cmake
#
# Plants one fault at a time in a small sound page and demands that check_promises.cmake names it; likewise for
# check_outcomes.cmake, in the page of errors.

cmake_minimum_required(VERSION 3.25)
set(check "${CMAKE_CURRENT_LIST_DIR}/check_promises.cmake")

function(plant name row expect)
  set(root "${WORK_DIR}/${name}")
  file(REMOVE_RECURSE "${root}")
  file(WRITE "${root}/tests/room/a.test.cpp" "TEST_CASE(\"a [tagged]; case\") {}\n")
  file(WRITE "${root}/tests/room/b.stress.cpp" "TEST_CASE(\"long\") {}\nTEST_CASE(\"long too\") {}\n")
  file(WRITE "${root}/page.md" "# Page\n\n| promise | proved by |\n|---|---|\n"
    "| sound | `room/a` \"a [tagged]; case\", `room/b` \"long\", `room/b` \"long t …\" |\n${row}\n\n| other |\n|---|\n| free |\n")
  execute_process(COMMAND "${CMAKE_COMMAND}" "-DPAGE=${root}/page.md" "-DTESTS_DIR=${root}/tests" -P "${check}"
    RESULT_VARIABLE result OUTPUT_VARIABLE output ERROR_VARIABLE output)
  if(NOT output MATCHES "${expect}" OR (row AND result EQUAL 0) OR (NOT row AND NOT result EQUAL 0))
    message(FATAL_ERROR "${name}: expected \"${expect}\", got exit ${result} and\n${output}")
  endif()
  message(STATUS "${name}: ${CMAKE_MATCH_0}")
endfunction()

plant(sound "" "1 promises, 3 references to tests, all there")
plant(bare "| nothing proves this | trust us |" "no test proves: . nothing proves this")
plant(missing_file "| x | `room/c` |" "room/c: there is no such test")
plant(missing_case "| x | `room/a` \"another case\" |" "room/a: it has no case \"another case\"")
plant(missing_start "| x | `room/a` \"another …\" |" "room/a: it has no case \"another …\"")
plant(two_starts "| x | `room/b` \"long …\" |" "room/b: 2 cases begin with \"long …\"")

# Replaces `from` by `to` in a page of two outcomes.
function(plant_outcome name from to expect)
  set(root "${WORK_DIR}/outcomes_${name}")
  file(REMOVE_RECURSE "${root}")
  file(WRITE "${root}/outcome.hpp" "enum class Outcome : std::uint8_t {\n  fine,\n  torn,  ///< in [two]; apart\n};\n"
    "      {fine, \"well\", \"\"},\n      {torn,\n       \"is torn\", \"mend it\"},\n")
  set(page "# Page\n\n### `fine`\n\nphistep: well.\n\n### `torn`\n\nphistep: it is torn [a; b].\n")
  if(from)
    string(REPLACE "${from}" "${to}" page "${page}")
  endif()
  file(WRITE "${root}/page.md" "${page}")
  execute_process(COMMAND "${CMAKE_COMMAND}" "-DPAGE=${root}/page.md" "-DHEADER=${root}/outcome.hpp"
      -P "${CMAKE_CURRENT_LIST_DIR}/check_outcomes.cmake"
    RESULT_VARIABLE result OUTPUT_VARIABLE output ERROR_VARIABLE output)
  if(NOT output MATCHES "${expect}" OR (from AND result EQUAL 0) OR (NOT from AND NOT result EQUAL 0))
    message(FATAL_ERROR "${name}: expected \"${expect}\", got exit ${result} and\n${output}")
  endif()
  message(STATUS "${name}: ${CMAKE_MATCH_0}")
endfunction()

plant_outcome(sound "" "" "2 outcomes, each with its section")
plant_outcome(missing "### `torn`" "### torn" "no section ### `torn`")
plant_outcome(unknown "### `torn`" "### `worn`" "### `worn` is no Outcome")
plant_outcome(silent "is torn" "is whole" "nowhere the words of torn")

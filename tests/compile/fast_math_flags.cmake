# cmake -DCOMPILER=... -DCOMPILER_ID=... -DINCLUDE_DIR=... -P fast_math_flags.cmake
#
# Each flag that would take the NaN checks or the compensated sums away is refused, with a message that names flags which are
# safe; those compile.
cmake_minimum_required(VERSION 3.25)

function(compile out flags)
  separate_arguments(flags UNIX_COMMAND "${flags}")
  execute_process(COMMAND "${COMPILER}" -std=c++20 ${flags} -fsyntax-only -w -x c++ "${INCLUDE_DIR}/phistep/base/version.hpp"
    RESULT_VARIABLE result ERROR_VARIABLE errors OUTPUT_QUIET)
  if(result EQUAL 0)
    set(errors "")
  endif()
  set(${out} "${errors}" PARENT_SCOPE)
endfunction()

set(safe "-O3 -march=native -fno-math-errno -fno-trapping-math")
set(refused -ffast-math -Ofast -ffinite-math-only)
if(COMPILER_ID STREQUAL "GNU")
  list(APPEND refused "-ffast-math -fno-finite-math-only" -funsafe-math-optimizations -freciprocal-math
    "-fassociative-math -fno-signed-zeros -fno-trapping-math")
else()
  list(APPEND refused -ffp-model=fast)
endif()
foreach(flags ${refused})
  compile(errors "${flags}")
  if(NOT errors MATCHES "error: (#error )?\"?phistep: [^\n]*Use ${safe}\"")
    message(NOTICE "${errors}")
    message(SEND_ERROR "${flags} should be refused by a message that names ${safe}")
  endif()
endforeach()

foreach(flags IN ITEMS -O2 "${safe}" -ffp-contract=off -ffp-contract=fast -frounding-math)
  compile(errors "${flags}")
  if(errors)
    message(NOTICE "${errors}")
    message(SEND_ERROR "${flags} should compile")
  endif()
endforeach()

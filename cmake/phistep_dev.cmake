# phistep_dev: what the project's own tests, examples and benchmarks are compiled with; never exported.
# phistep_warnings is the part of it that a compile-only check needs.

# g++ 12 and clang 14 are the compilers that the project keeps silent; a warning that a later one invents must not stop
# somebody who only wants to run the tests.
set(werror OFF)
if((CMAKE_CXX_COMPILER_ID STREQUAL "GNU" AND CMAKE_CXX_COMPILER_VERSION MATCHES "^12\\.")
    OR (CMAKE_CXX_COMPILER_ID STREQUAL "Clang" AND CMAKE_CXX_COMPILER_VERSION MATCHES "^14\\."))
  set(werror ON)
endif()
option(PHISTEP_WARNINGS_AS_ERRORS "Let a warning stop the build of tests, examples and benchmarks" ${werror})

add_library(phistep_warnings INTERFACE)
if(MSVC)
  target_compile_options(phistep_warnings INTERFACE /W4 /permissive- /utf-8 /bigobj)
  if(PHISTEP_WARNINGS_AS_ERRORS)
    target_compile_options(phistep_warnings INTERFACE /WX)
  endif()
else()
  target_compile_options(phistep_warnings INTERFACE -Wall -Wextra -Wpedantic -Wconversion -Wshadow)
  if(PHISTEP_WARNINGS_AS_ERRORS)
    target_compile_options(phistep_warnings INTERFACE -Werror)
  endif()
  if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU" AND CMAKE_CXX_FLAGS_RELEASE MATCHES "-O1")
    # At -O1 g++ 12 proves less than at -O2, and believes that Eigen uses what it has freed or never filled.
    target_compile_options(phistep_warnings INTERFACE -Wno-use-after-free -Wno-maybe-uninitialized)
  endif()
  if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU" AND CMAKE_CXX_FLAGS_RELEASE MATCHES "-O2")
    # At -O2 g++ 12 folds the same stage of two schemes into one function, and takes the one's stages for the other's.
    target_compile_options(phistep_warnings INTERFACE -Wno-array-bounds)
  endif()
  if(PHISTEP_SANITIZE AND CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
    # Instrumentation hides from g++ what it otherwise proves: the first two then fire inside Eigen, the third where a
    # test replaces operator new. They come after -Wall, which would switch them on again.
    target_compile_options(phistep_warnings INTERFACE
      -Wno-maybe-uninitialized -Wno-array-bounds -Wno-mismatched-new-delete)
  endif()
endif()

add_library(phistep_dev INTERFACE)
target_link_libraries(phistep_dev INTERFACE phistep::phistep phistep_warnings)

if(PHISTEP_SANITIZE)
  # -O1 and -g come from the preset; without frame pointers the reports lose their callers.
  target_compile_options(phistep_dev INTERFACE
    -fsanitize=${PHISTEP_SANITIZE} -fno-sanitize-recover=all -fno-omit-frame-pointer)
  target_link_options(phistep_dev INTERFACE -fsanitize=${PHISTEP_SANITIZE})
endif()

set(CMAKE_CXX_EXTENSIONS OFF)

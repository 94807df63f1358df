#!/bin/sh
# sh scripts/touched.sh [header...]
# Builds and runs the tests of these headers (include/phistep/... or force/drag.hpp) that tests/tests_of.txt lists: about a
# minute a header. Without arguments: of the headers that differ from HEAD.
set -eu
cd "$(dirname "$0")/.."
. scripts/setup.sh

# shellcheck disable=SC2046  # no header has a space in its name
[ $# -gt 0 ] || set -- $(git diff --name-only HEAD -- include)
[ $# -gt 0 ] || phistep_die "no header differs from HEAD; name one, such as force/drag.hpp"
tests=
for header in "$@"; do
  header=${header#*include/phistep/}
  found=$(phistep_tests_of "$header")
  [ -n "$found" ] || phistep_die "tests/tests_of.txt has no line for $header"
  tests="$tests $found"
done
tests=$(printf '%s\n' $tests | awk '!seen[$0]++')
echo "phistep: $(echo $tests)"

phistep_setup libeigen3-dev catch2 libsundials-dev
case $tests in *full/*) phistep_configure_tests build/test -DPHISTEP_FULL=ON ;; *) phistep_configure_tests build/test ;; esac
# shellcheck disable=SC2046,SC2086
cmake --build build/test -j "$jobs" --target $(phistep_targets_of $tests) || phistep_die "the build failed"
ctest --test-dir build/test -j "$jobs" --output-on-failure --no-tests=error \
  -R "^($(echo $tests | tr ' ' '|')|build/floors|build/tests_of)\$"

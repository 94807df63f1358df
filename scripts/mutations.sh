#!/bin/sh
# sh scripts/mutations.sh [--near] [patch...]
# Breaks a copy of the library on purpose, one patch of tests/mutations/ at a time (all of them, or those named), and says
# which tier of the tests notices: first the tests of the broken header (tests/tests_of.txt), then the rest of the quick
# tier, then what CI adds. Ends with an error if a break escapes. The copy and its build are in build/mutations; half a
# minute a break where the header's own tests notice, and ccache helps. --near asks the header's own
# quick and full tests alone, and calls what they miss "farther".
set -eu
cd "$(dirname "$0")/.."
. scripts/setup.sh
near_only=
if [ "${1:-}" = --near ]; then near_only=yes && shift; fi
[ $# -gt 0 ] || set -- tests/mutations/*.patch

phistep_setup libeigen3-dev catch2 libsundials-dev patch
here=$PWD
root=$here/build/mutations
rm -rf "$root/source"
mkdir -p "$root/source"
git ls-files --cached --others --exclude-standard | while read -r file; do [ ! -f "$file" ] || echo "$file"; done |
  tar -cf - -T - | tar -C "$root/source" -xf -
cd "$root/source"
phistep_configure_tests "$root/build" -DPHISTEP_FULL=ON -DPHISTEP_BUILD_EXAMPLES=ON
go_on="-k"
[ "$generator" != Ninja ] || go_on="-k 0"

# notices <ctest selection> <build target...>: builds and runs; those that fail are in $caught, or that one does not compile.
notices() {
  selection=$1
  shift
  # shellcheck disable=SC2086
  if ! cmake --build "$root/build" -j "$jobs" --target "$@" -- $go_on >"$root/build.log" 2>&1; then
    caught="the compiler"  # what was built before would still pass
    return 0
  fi
  # shellcheck disable=SC2086
  if ctest --test-dir "$root/build" -j "$jobs" $selection --timeout 300 --no-tests=error >"$root/test.log" 2>&1; then return 1; fi
  caught=$(sed -n 's/^[[:space:]]*[0-9]* - \([^ ]*\) (\(.*\))$/\1 (\2)/p; /No tests were found/p' "$root/test.log" | head -n 4 |
    sed 's/ (Failed)//' | tr '\n' ' ')
}
# The same for the tests named.
these_notice() {
  names=$*
  # shellcheck disable=SC2046,SC2086
  notices "-R ^($(echo $names | tr ' ' '|'))\$" $(phistep_targets_of $names)
}

quick=0 full=0 escaped=0
for patch in "$@"; do
  name=$(basename "$patch" .patch)
  file=$here/tests/mutations/$name.patch
  started=$(date +%s)
  patch -s -p1 --no-backup-if-mismatch <"$file" || phistep_die "$name does not apply"
  headers=$(sed -n 's|^+++ b/include/phistep/\([^[:space:]]*\).*|\1|p' "$file")
  near=
  near_full=
  for test in $(for header in $headers; do phistep_tests_of "$header"; done); do
    case $test in full/*) near_full="$near_full $test" && continue ;; esac
    near="$near $test"
    for candidate in tests/"$test".test.cpp tests/"$test".full.cpp tests/"$test"_*.full.cpp; do
      case $candidate in *.test.cpp) grep -q '^#.*if PHISTEP_FULL$' "$candidate" || continue ;; esac
      [ ! -f "$candidate" ] || near_full="$near_full full/$(echo "$candidate" | sed 's|^tests/||; s|\.[a-z]*\.cpp$||')"
    done
  done
  caught=
  # shellcheck disable=SC2086
  if { [ -n "$near" ] && these_notice $near; } || { [ -z "$near_only" ] && notices "-L ^quick\$" phistep_quick_tests; }; then
    tier=quick quick=$((quick + 1))
  elif { [ -n "$near_full" ] && these_notice $near_full; } ||
    { [ -z "$near_only" ] && notices "-L ^full\$" all; }; then
    tier=full full=$((full + 1))
  else
    tier=${near_only:+farther} escaped=$((escaped + 1))
    tier=${tier:-ESCAPED}
  fi
  patch -s -R -p1 --no-backup-if-mismatch <"$file"
  printf '%-8s %-46s %4d s  %s\n' "$tier" "$name" $(($(date +%s) - started)) "$caught"
done
printf '%d breaks: %d noticed by the quick tier, %d by what CI adds, %d by neither%s\n' $((quick + full + escaped)) $quick $full $escaped \
  "${near_only:+ (of those near)}"
[ $escaped -eq 0 ]

#!/bin/sh
# sh scripts/tidy.sh [header...]
# clang-tidy on the headers, each compiled alone (all of them, or those named, as include/phistep/...).
set -eu
cd "$(dirname "$0")/.."
tool=${CLANG_TIDY:-clang-tidy}
command -v "$tool" >/dev/null 2>&1 || {
  echo "phistep: $tool not found (Debian, Ubuntu: apt install clang-tidy), or set CLANG_TIDY" >&2
  exit 1
}
eigen=
for dir in ${EIGEN_INCLUDE:-} /usr/include/eigen3 /usr/local/include/eigen3; do
  if [ -f "$dir/Eigen/Core" ]; then eigen=$dir; break; fi
done
[ -n "$eigen" ] || {
  echo "phistep: Eigen not found; set EIGEN_INCLUDE to the folder that holds Eigen/Core" >&2
  exit 1
}
# shellcheck disable=SC2046  # no header has a space in its name
[ $# -gt 0 ] || set -- $(find include/phistep -name '*.hpp' | sort)
units=$(mktemp -d)
trap 'rm -rf "$units"' EXIT
for header in "$@"; do
  unit=$(printf '%s' "${header#include/}" | tr / _).cpp
  printf '#include <%s>\n' "${header#include/}" >"$units/$unit"
done
root=$PWD
export tool eigen root
# shellcheck disable=SC2016  # the inner shell expands these
find "$units" -name '*.cpp' -print0 | sort -z | xargs -0 -n 4 -P "$(nproc 2>/dev/null || echo 2)" sh -c '
  "$tool" --quiet --config-file="$root/.clang-tidy" --header-filter="$root/include/phistep/.*" "$@" -- \
    -std=c++20 -I"$root/include" -isystem "$eigen"' sh

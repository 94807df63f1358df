#!/bin/sh
# sh scripts/step_calls.sh [source folder]
# How much of the library one step runs through: calls, functions, depth and headers of one trapezoidal step of a
# Motion<Vector2d>, compiled with -O0 and nothing inlined; Eigen's and the standard library's functions are not counted.
set -eu
cd "$(dirname "$0")/.."
root=${1:-$PWD}
eigen=
for folder in /usr/include/eigen3 /usr/local/include/eigen3; do
  if [ -d "$folder/Eigen" ]; then eigen=$folder; fi
done
[ -n "$eigen" ] || { echo "Eigen was not found"; exit 1; }
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
${CXX:-g++} -std=c++20 -O0 -g -no-pie -fno-inline -finstrument-functions \
  -finstrument-functions-exclude-file-list=/usr/include,/usr/lib,/usr/local,scripts/ \
  -I"$root/include" -isystem "$eigen" scripts/step_calls.cpp -o "$work/step"
"$work/step" >"$work/out"
head -n 3 "$work/out"
sed 1,3d "$work/out" | sort -u >"$work/functions"
echo "functions $(wc -l <"$work/functions")"
addr2line -e "$work/step" <"$work/functions" | sed 's/:.*//; s/ .*//' | sort | uniq -c | sort -rn >"$work/headers"
awk '{ print $2 }' "$work/headers" | grep include/phistep >"$work/files"
echo "headers $(wc -l <"$work/files"), lines $(xargs cat <"$work/files" | wc -l)"
sed "s|$root/||" "$work/headers"

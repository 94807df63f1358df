#!/bin/sh
# sh scripts/compile_time.sh [--save] [-n TIMES]
# What including phistep costs a user: compiles each program of bench/compile_time/ (as a user would: -O2, no warnings asked
# for), TIMES times (3), and prints CPU seconds (the median), memory, and the ratio to <Eigen/Dense> alone, which other
# machines share; beside them the figures kept in bench/compile_time/figures.txt. --save writes that file anew.
# CXX chooses the compiler, CXXFLAGS the flags.
set -eu
cd "$(dirname "$0")/.."
. scripts/setup.sh
times=3 save=
while [ $# -gt 0 ]; do
  case $1 in
    --save) save=yes ;;
    -n) times=$2 && shift ;;
    *) phistep_die "compile_time.sh doesn't know $1" ;;
  esac
  shift
done
phistep_setup libeigen3-dev time
eigen=
for dir in ${EIGEN_INCLUDE:-} /usr/include/eigen3 /usr/local/include/eigen3; do
  if [ -f "$dir/Eigen/Core" ]; then eigen=$dir && break; fi
done
[ -n "$eigen" ] || phistep_die "Eigen not found; set EIGEN_INCLUDE to the folder that holds Eigen/Core"
figures=bench/compile_time/figures.txt
out=build/compile_time
mkdir -p "$out"

# measure <program>: "seconds MB"
measure() {
  : >"$out/times"
  n=0
  while [ $((n += 1)) -le "$times" ]; do
    # shellcheck disable=SC2086
    command time -a -o "$out/times" -f '%U %S %M' "$CXX" -std=c++20 ${CXXFLAGS:--O2} -Iinclude -isystem "$eigen" \
      -c "bench/compile_time/$1.cpp" -o "$out/$1.o" || phistep_die "bench/compile_time/$1.cpp does not compile"
  done
  sort -n "$out/times" | awk '{ s[NR] = $1 + $2; m[NR] = $3 } END { k = int((NR + 1) / 2); printf "%.2f %d\n", s[k], m[k] / 1024 }'
}

table=$out/table
: >"$table"
format='%-16s %8s %8s %10s   %s\n'
# shellcheck disable=SC2059
printf "$format" program CPU-s MB 'x Eigen' 'kept: CPU-s, MB, x Eigen'
base=
for program in eigen phistep implicit automatic sparse_rodas4 eight_schemes grains; do
  result=$(measure $program)
  seconds=${result% *} megabytes=${result#* }
  [ -n "$base" ] || base=$seconds
  ratio=$(awk -v a="$seconds" -v b="$base" 'BEGIN { printf "%.2f", a / b }')
  kept=$(awk -v p=$program '$1 == p { print $2, $3, $4 }' "$figures" 2>/dev/null || true)
  # shellcheck disable=SC2059
  printf "$format" $program "$seconds" "$megabytes" "$ratio" "$kept"
  echo "$program $seconds $megabytes $ratio" >>"$table"
done
if [ -n "$save" ]; then
  {
    echo "# $(date -u +%Y-%m-%d), $("$CXX" --version | head -n 1), ${CXXFLAGS:--O2}, $(sed -n 's/^model name[^:]*: //p' /proc/cpuinfo | head -n 1)"
    echo "# program, CPU seconds (median of $times), MB, ratio to <Eigen/Dense>; written by scripts/compile_time.sh --save"
    cat "$table"
  } >$figures
  echo "phistep: kept in $figures"
fi

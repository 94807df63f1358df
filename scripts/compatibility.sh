#!/bin/sh
# sh scripts/compatibility.sh [--quick] [-j JOBS] [-o FOLDER]
# Compiles tests/compatibility/answers.cpp (and answers_solvers.cpp, where the cell says +) with each compiler, standard library,
# standard, level and instruction set that is here, warnings being errors, runs it (arm64 under an emulator), and prints what was
# right and what had the same bits: equal letters, equal bits. Builds marked
#     portable:   -ffp-contract=off -fno-tree-vectorize -DPHISTEP_NO_SIMD -DEIGEN_DONT_VECTORIZE
# must all have the same ones (Radau apart, between x86-64 and arm64). --quick: six builds. What is missing is skipped, and named. If PHISTEP_FIGURES names a file, it
# gets a row a build, as from the long tests. The builds are left in FOLDER, build/compatibility.
set -eu
root=$(cd "$(dirname "$0")/.." && pwd)
folder=$root/build/compatibility
jobs=$(nproc 2>/dev/null || echo 2)
quick=no
only=

die() {
  echo "phistep: $*" >&2
  exit 1
}
while [ $# -gt 0 ]; do
  case $1 in
    --quick) quick=yes ;;
    -j) jobs=$2 && shift ;;
    -o) folder=$2 && shift ;;
    --cell) only=$2 && shift ;;
    *) die "compatibility.sh doesn't know $1" ;;
  esac
  shift
done

eigen=
for dir in ${EIGEN_INCLUDE:-} /usr/include/eigen3 /usr/local/include/eigen3; do
  if [ -f "$dir/Eigen/Core" ]; then eigen=$dir && break; fi
done
[ -n "$eigen" ] || die "Eigen not found; set EIGEN_INCLUDE to the folder that holds Eigen/Core"

# compiler  library  standard  level  machine  OpenMP  arithmetic  programs  in --quick
cells='
g++      libstdc++  c++20  -O0  sse2    no   -         answers   -
g++      libstdc++  c++20  -O3  sse2    no   -         answers+  -
g++      libstdc++  c++23  -O0  avx2    no   -         answers+  -
g++      libstdc++  c++20  -O3  avx2    no   -         answers   -
g++      libstdc++  c++20  -O3  avx512  no   -         answers+  quick
g++      libstdc++  c++23  -O2  avx2    yes  -         answers   -
clang++  libstdc++  c++20  -O0  sse2    no   -         answers   -
clang++  libstdc++  c++20  -O3  sse2    no   -         answers+  -
clang++  libstdc++  c++2b  -O3  avx2    no   -         answers   -
clang++  libstdc++  c++20  -O3  avx512  no   -         answers   -
clang++  libstdc++  c++20  -O2  avx2    yes  -         answers   -
clang++  libc++     c++20  -O0  sse2    no   -         answers   quick
clang++  libc++     c++20  -O3  avx2    no   -         answers+  -
clang++  libc++     c++2b  -O2  avx512  no   -         answers   -
g++      libstdc++  c++20  -O0  arm64   no   -         answers   -
g++      libstdc++  c++20  -O3  arm64   no   -         answers+  quick
g++      libstdc++  c++23  -O2  arm64   yes  -         answers   -
clang++  libstdc++  c++20  -O2  arm64   no   -         answers   -
g++      libstdc++  c++20  -O0  sse2    no   portable  answers+  -
g++      libstdc++  c++20  -O3  avx512  no   portable  answers   quick
clang++  libstdc++  c++20  -O1  sse2    no   portable  answers   quick
clang++  libstdc++  c++20  -O3  avx2    no   portable  answers+  -
g++      libstdc++  c++20  -O2  arm64   no   portable  answers+  quick
clang++  libstdc++  c++20  -O2  arm64   no   portable  answers   -
'
if [ $quick = yes ]; then cells=$(printf '%s\n' "$cells" | sed -n '/quick$/p'); fi
cells=$(printf '%s\n' "$cells" | sed '/^$/d')
of_cell() { printf '%s\n' "$cells" | sed -n "$1p"; }

# What a cell needs and isn't here, with Debian's name for it; empty where all is.
missing() {
  command -v "$1" >/dev/null 2>&1 || { echo "$1 (Debian: $2)" && return; }
  [ $# -eq 3 ] || return 0
  printf '#include <vector>\nint main() {}\n' >"$here/probe.cpp"
  # shellcheck disable=SC2086
  "$1" -std=c++20 $3 "$here/probe.cpp" -o "$here/probe" >/dev/null 2>&1 || echo "what $1 $3 needs (Debian: $2)"
}

# Compiles and runs cell $1; its folder then has `result`, one line, and `bits`, the answers.
one_cell() {
  here=$folder/$1
  rm -rf "$here"
  mkdir -p "$here"
  # shellcheck disable=SC2046
  set -- $(of_cell "$1")
  compiler=$1 library=$2 standard=$3 level=$4 machine=$5 openmp=$6 arithmetic=$7 programs=$8
  case $compiler in
    *clang*) lacks=$(missing "$compiler" clang) ;;
    *) lacks=$(missing "$compiler" g++) ;;
  esac
  flags='' emulator=''
  if [ "$library" = libc++ ]; then
    flags="$flags -stdlib=libc++"
    [ -n "$lacks" ] || lacks=$(missing "$compiler" "libc++-dev libc++abi-dev" "$flags")
  fi
  if [ "$openmp" = yes ]; then
    flags="$flags -fopenmp"
    [ -n "$lacks" ] || [ "$machine" = arm64 ] || lacks=$(missing "$compiler" libomp-dev "$flags")
  fi
  case $machine in
    sse2) flags="$flags -march=x86-64" needs=sse2 ;;
    avx2) flags="$flags -march=haswell" needs=avx2 ;;
    avx512)
      flags="$flags -march=skylake-avx512" needs=avx512vl
      # g++ 12 warns of its own avx512fintrin.h (bug 105593).
      case $compiler in *clang*) ;; *) flags="$flags -Wno-maybe-uninitialized" ;; esac
      ;;
    arm64)
      needs="" emulator="qemu-aarch64 -L /usr/aarch64-linux-gnu"
      [ -n "$lacks" ] || lacks=$(missing aarch64-linux-gnu-g++ g++-aarch64-linux-gnu)
      [ -n "$lacks" ] || lacks=$(missing qemu-aarch64 qemu-user)
      case $compiler in
        *clang*) flags="$flags --target=aarch64-linux-gnu" ;;
        # A note on older versions' binaries; and at -O3 g++ 12 takes a state for uninitialized that a step has written.
        *) compiler=aarch64-linux-gnu-$compiler flags="$flags -Wno-psabi -Wno-maybe-uninitialized" ;;
      esac
      ;;
  esac
  if [ -n "$lacks" ]; then echo "skipped: no $lacks" >"$here/result" && return; fi
  if [ -n "$needs" ] && ! grep -qw "$needs" /proc/cpuinfo; then
    echo "skipped: this machine lacks $needs" >"$here/result" && return
  fi
  if [ "$arithmetic" = portable ]; then flags="$flags -ffp-contract=off -fno-tree-vectorize -DPHISTEP_NO_SIMD -DEIGEN_DONT_VECTORIZE"; fi
  [ "$programs" = answers ] || programs="answers answers_solvers"
  : >"$here/bits"
  for program in $programs; do
    # shellcheck disable=SC2086
    "$compiler" -std="$standard" "$level" $flags -Wall -Wextra -Wpedantic -Wconversion -Wshadow -Werror -I"$root/include" \
      -I"$root/tests" -isystem "$eigen" "$root/tests/compatibility/$program.cpp" -o "$here/$program" >"$here/$program.log" 2>&1 ||
      { echo "BROKEN: does not compile, see $here/$program.log" >"$here/result" && return; }
    save=
    if [ "$program" = answers ]; then save="--save $here/checkpoint"; fi
    # shellcheck disable=SC2086
    OMP_NUM_THREADS=2 $emulator "$here/$program" $save >"$here/$program.bits" 2>"$here/$program.log" ||
      { echo "BROKEN: wrong answers, see $here/$program.log" >"$here/result" && return; }
    cat "$here/$program.bits" >>"$here/bits"
  done
  # One run of each scheme and scene, with the bits that tests/pinned/hashes.txt has (arm64 computes Radau's coefficients otherwise).
  if [ "$arithmetic" = portable ] && [ "$machine" != arm64 ]; then
    # shellcheck disable=SC2086
    "$compiler" -std="$standard" "$level" $flags -I"$root/include" -I"$root/tests" -isystem "$eigen" "$root"/tests/pinned/*.cpp \
      -o "$here/pinned" >"$here/pinned.log" 2>&1 || { echo "BROKEN: does not compile, see $here/pinned.log" >"$here/result" && return; }
    "$here/pinned" | LC_ALL=C sort >"$here/pinned.bits"
    LC_ALL=C sort "$root/tests/pinned/hashes.txt" | diff - "$here/pinned.bits" >"$here/pinned.log" ||
      { echo "BROKEN: other bits than tests/pinned/hashes.txt, see $here/pinned.log" >"$here/result" && return; }
  fi
  echo "$(($(wc -l <"$here/bits"))) answers, all right" >"$here/result"
}
if [ -n "$only" ]; then one_cell "$only" && exit 0; fi

mkdir -p "$folder"
count=$(printf '%s\n' "$cells" | wc -l)
echo "phistep: $((count)) builds, $jobs at a time"
quick_flag=
if [ $quick = yes ]; then quick_flag=--quick; fi
n=0
# shellcheck disable=SC2016  # the inner shell expands these
while [ $((n += 1)) -le "$count" ]; do echo "$n"; done |
  xargs -n 1 -P "$jobs" sh -c '
    sh "$0" $1 -o "$2" --cell "$3"
    echo "  ... $3: $(cat "$2/$3/result")"' "$0" "$quick_flag" "$folder"

row() {
  if [ -n "${PHISTEP_FIGURES:-}" ]; then echo "$1 | $2 | $3 | $4 | $5" >>"$PHISTEP_FIGURES"; fi
}
verdict() { if [ "$1" -le 0 ]; then echo holds; else echo BROKEN; fi; }

# A letter for the bits of cell $1: that of the first cell with the same, else the next one.
letter() {
  k=0
  used=0
  while [ $((k += 1)) -lt "$1" ]; do
    [ -f "$folder/$k/letter" ] || continue
    if cmp -s "$folder/$k/answers.bits" "$folder/$1/answers.bits"; then cat "$folder/$k/letter" && return; fi
    if [ -f "$folder/$k/first" ]; then used=$((used + 1)); fi
  done
  touch "$folder/$1/first"
  awk -v n="$used" 'BEGIN { printf "%c\n", 65 + n }'
}

echo
format='%-8s  %-9s  %-5s  %-3s  %-6s  %-6s  %-8s  %-4s  %s\n'
# shellcheck disable=SC2059
printf "$format" compiler library std -O machine OpenMP "" bits result
broken=0 skipped=0 right=0
n=0
while [ $((n += 1)) -le "$count" ]; do
  # shellcheck disable=SC2046
  set -- $(of_cell "$n")
  result=$(cat "$folder/$n/result")
  mark=-
  case $result in
    BROKEN*) broken=$((broken + 1)) ;;
    skipped*) skipped=$((skipped + 1)) ;;
    *)
      right=$((right + 1))
      mark=$(letter "$n" answers)
      echo "$mark" >"$folder/$n/letter"
      ;;
  esac
  # shellcheck disable=SC2059
  printf "$format" "$1" "$2" "$3" "$4" "$5" "$6" "$7" "$mark" "$result"
  case $result in
    skipped*) row "$1 $2 $3 $4 $5 $7" "skipped" "-" "-" holds ;;
    BROKEN*) row "$1 $2 $3 $4 $5 $7 OpenMP $6" "wrong builds" 1 "<= 0" BROKEN ;;
    *) row "$1 $2 $3 $4 $5 $7 OpenMP $6" "wrong answers" 0 "<= 0" holds ;;
  esac
done

# All portable builds, bit for bit, both programs; but for Radau's coefficients, which are computed as long double: 64 bits of
# mantissa on x86, 113 on arm64.
different=0
n=0
while [ $((n += 1)) -le "$count" ]; do
  case $(of_cell "$n") in *portable*) ;; *) continue ;; esac
  for program in answers answers_solvers; do
    [ -s "$folder/$n/$program.bits" ] || continue
    grep -v radau "$folder/$n/$program.bits" >"$folder/$n/$program.compared"
    m=0
    while [ $((m += 1)) -lt "$n" ]; do
      [ -f "$folder/$m/$program.compared" ] || continue
      cmp -s "$folder/$m/$program.compared" "$folder/$n/$program.compared" && break
      different=$((different + 1))
      echo "  portable builds $m and $n have other bits:"
      diff "$folder/$m/$program.compared" "$folder/$n/$program.compared" | sed 's/^/  /'
      break
    done
  done
done
row "portable flags: the same bits by every build" "builds with other bits" "$different" "<= 0" "$(verdict $different)"

# Checkpoints go from any build to any other, and give the same bits where the build is the same but for its library.
# From each build to the next, and from the first to all.
taken=0 astray=0 first='' before=''
n=0
while [ $((n += 1)) -le "$count" ]; do
  [ -f "$folder/$n/checkpoint" ] || continue
  for m in $first $before; do
    from=$folder/$m/checkpoint
    to=$folder/$n/answers
    emulator=''
    case $(of_cell "$n") in *arm64*) emulator="qemu-aarch64 -L /usr/aarch64-linux-gnu" ;; esac
    # shellcheck disable=SC2086
    said=$($emulator "$to" --load "$from" 2>&1 >/dev/null | sed -n '/^loaded\|^refused/p')
    case $said in
      loaded*) taken=$((taken + 1)) ;;
      *) astray=$((astray + 1)) && echo "  checkpoint of $m for $n: $said" ;;
    esac
  done
  if [ -n "$first" ]; then before=$n; else first=$n; fi
done
echo
echo "checkpoints: $taken taken by another build, $astray refused"
row "checkpoints: taken by every other build and machine" "pairs otherwise" "$astray" "<= 0" "$(verdict $astray)"
echo "phistep: $right builds right, $broken broken, $skipped skipped; $different portable builds with other bits"
[ $((broken + different + astray)) -eq 0 ] || exit 1

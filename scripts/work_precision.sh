#!/bin/sh
# sh scripts/work_precision.sh [options of bench_work_precision, such as --quick or --problem hires]
# Builds phistep and its rivals, measures run time against error, and leaves table, diagrams and summary in out/; a run of
# everything (no options) puts the summary into docs/speed.md, between its two work_precision marks. For figures that mean
# something, on a quiet machine.
set -eu
cd "$(dirname "$0")/.."
. scripts/setup.sh

phistep_setup libeigen3-dev libbenchmark-dev libsundials-dev libsuitesparse-dev libboost-dev libgsl-dev petsc-dev pkg-config \
  python3 python3-matplotlib
phistep_configure build/bench -DCMAKE_BUILD_TYPE=Release -DPHISTEP_BUILD_TESTS=OFF -DPHISTEP_BUILD_EXAMPLES=OFF
cmake --build build/bench -j "$jobs" --target bench_work_precision ||
  phistep_die "the build failed; the first error above is the one to look at."

commit=$(git describe --always --dirty 2>/dev/null || echo "an unknown commit")
build/bench/bench/bench_work_precision --commit "$commit" --out out "$@" || phistep_die "the benchmark failed"

for candidate in "${PYTHON:-python3}" /usr/bin/python3; do
  if MPLBACKEND=Agg "$candidate" -c 'import matplotlib.pyplot' >/dev/null 2>&1; then
    PYTHONDONTWRITEBYTECODE=1 "$candidate" bench/work_precision/plot.py out
    break
  fi
done

if [ $# -eq 0 ]; then
  grep -q '<!-- work_precision begins -->' docs/speed.md || phistep_die "docs/speed.md has no work_precision marks"
  awk '/<!-- work_precision begins -->/ { print; print ""; while ((getline line < "out/work_precision.md") > 0) print line; print ""; inside = 1 }
       /<!-- work_precision ends -->/ { inside = 0 }
       !inside' docs/speed.md >out/speed.md
  mv out/speed.md docs/speed.md
  echo "phistep: docs/speed.md has the new figures"
fi

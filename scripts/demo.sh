#!/bin/sh
# sh scripts/demo.sh
# Installs what is missing, builds and runs the solar system, a controlled orbit, a cloth, an argon crystal that melts and
# sand in a hopper, and leaves tables, frames and pictures in out/. CXX chooses the compiler; the build is in build/demo.
set -eu
cd "$(dirname "$0")/.."
. scripts/setup.sh

phistep_setup libeigen3-dev python3 python3-matplotlib
phistep_configure build/demo -DCMAKE_BUILD_TYPE=Release -DPHISTEP_BUILD_TESTS=OFF -DPHISTEP_BUILD_BENCH=OFF \
  -DPHISTEP_WARNINGS_AS_ERRORS=OFF
cmake --build build/demo -j "$jobs" --target solar_system arenstorf cloth argon_melt hopper ||
  phistep_die "the build failed; the first error above is the one to look at."

# The python3 that comes first may be another than the one that has the distribution's matplotlib.
pictures="no pictures: no python3 with matplotlib was found (Debian, Ubuntu: apt install python3-matplotlib)"
python=
for candidate in "${PYTHON:-python3}" /usr/bin/python3; do
  if MPLBACKEND=Agg "$candidate" -c 'import matplotlib.pyplot' >/dev/null 2>&1; then
    python=$candidate
    pictures=
    break
  fi
done

for demo in solar_system arenstorf cloth argon_melt hopper; do
  echo
  echo "== $demo"
  "build/demo/examples/$demo" --out out || phistep_die "$demo failed; its last line above says why."
  for script in examples/plot/*"$demo"*.py; do
    if [ -f "$script" ] && [ -n "$python" ]; then
      PYTHONDONTWRITEBYTECODE=1 "$python" "$script" out || pictures="some pictures are missing: $script failed, see above"
    fi
  done
done

echo
if [ -n "$pictures" ]; then echo "phistep: $pictures"; fi
echo "phistep: in $PWD/out"
find out -type f | sort | while read -r file; do
  printf '  %-40s %s\n' "$file" "$(du -h "$file" | cut -f 1)"
done
echo "Frames (*.xyz) open in OVITO and ASE, tables in any editor."

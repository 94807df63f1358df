#!/bin/sh
# sh scripts/packages.sh [find_package deb ...]
# Tries docs/install.md on a bare Debian or Ubuntu, as root: each way of tests/package/, by the page's own commands; then the Debian
# package on the machine as it was before, by apt alone. It installs and REMOVES packages: take a container or a fresh machine.
# All ways take some minutes; `find_package deb` are the two that the last part needs. By hand, before a release; the ways themselves
# are in CI too (scripts/full.sh).
set -eu
cd "$(dirname "$0")/.."
root=$PWD
work=$root/build/packages
die() {
  printf '\npackages: %s\n' "$*" >&2
  exit 1
}
apt() {
  DEBIAN_FRONTEND=noninteractive apt-get -qq -o DPkg::Lock::Timeout=300 "$@" >>"$work/apt.log" 2>&1 ||
    { tail -n 20 "$work/apt.log"; die "apt-get $*"; }
}
packages() { dpkg-query -W -f '${Package}\n' | sort; }

[ "$(id -u)" -eq 0 ] && command -v apt-get >/dev/null || die "this needs root and apt"
for command in g++ cmake; do
  ! command -v "$command" >/dev/null || die "$command is here: this is no bare machine, and what is installed would be removed"
done
rm -rf "$work"
mkdir -p "$work"
began=$(date +%s)
took() { echo "packages: $1 ($(($(date +%s) - began)) s)"; }

# ---- each way --------------------------------------------------------------------------------------------------------

packages >"$work/before"
apt update
apt install -y --no-install-recommends g++ cmake make git pkg-config libeigen3-dev
took "installed g++, CMake, git, pkg-config, Eigen"
ways=${*:-$(sed -n 's/^foreach(how \(.*\))$/\1/p' tests/CMakeLists.txt)}
[ -n "$ways" ] || die "no ways are listed in tests/CMakeLists.txt"
for way in $ways; do
  cmake -DHOW="$way" -DPHISTEP_DIR="$root" -DWORK_DIR="$work" -DGENERATOR="Unix Makefiles" -DMAKE_PROGRAM="$(command -v make)" \
    -DCOMPILER="$(command -v g++)" -DEIGEN_DIR= -DSYSTEM_DIRS=/usr/include/eigen3 -P tests/package/run.cmake >"$work/$way.log" 2>&1 ||
    { tail -n 40 "$work/$way.log"; die "$way failed"; }
  ! grep '^skipped' "$work/$way.log" || die "$way was skipped"
  took "$way"
done

# ---- the Debian package, where there is only apt ---------------------------------------------------------------------

mkdir "$work/user"
cp "$work"/deb/phistep-build/phistep_*_all.deb "$work"/deb/ball.cpp "$work/user"
cp "$work/find_package/CMakeLists.txt" "$work/user"
packages >"$work/after"
# shellcheck disable=SC2046
apt purge -y $(comm -13 "$work/before" "$work/after")
for path in /usr/include/eigen3/Eigen/Core /usr/bin/g++ /usr/bin/cmake /usr/bin/pkg-config; do
  [ ! -e "$path" ] || die "$path is still here"
done
hash -r
took "all of that removed"

cd "$work/user"
chmod 755 "$work" "$work/user"  # apt reads the file as a user without rights, and only says so if it can't
apt install -y --no-install-recommends ./phistep_*_all.deb g++
took "apt install ./$(echo phistep_*_all.deb) g++"
g++ -std=c++20 -O2 -isystem /usr/include/eigen3 ball.cpp -o ball
./ball >printed
grep -q '^phi = 0.5: 200 J$' printed || die "the ball's program prints $(cat printed)"
took "the first program, with g++ alone"
apt install -y --no-install-recommends cmake make pkg-config
g++ -std=c++20 -O2 $(pkg-config --cflags phistep) ball.cpp -o ball
./ball | cmp - printed || die "pkg-config"
took "pkg-config --cflags phistep: $(pkg-config --cflags phistep)"
cmake -S . -B build -D CMAKE_BUILD_TYPE=Release >cmake.log && cmake --build build >>cmake.log || { cat cmake.log; die "find_package"; }
./build/ball | cmp - printed || die "find_package"
took "find_package(phistep)"
apt remove -y phistep
[ -z "$(find /usr -path '*phistep*' -not -path "$root/*")" ] || die "left behind: $(find /usr -path '*phistep*')"
took "apt remove phistep leaves nothing"

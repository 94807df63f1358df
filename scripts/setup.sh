# Sourced by the other scripts: phistep_setup <package...> makes compiler, CMake and libraries available, and sets CXX, jobs,
# generator and faster (what shortens a build, where it is there: ccache, mold or lld). On Debian and Ubuntu, as root or with sudo that asks no password, it installs what is
# missing. Elsewhere CMake downloads Eigen, Catch2 and SUNDIALS, and a compiler and CMake must be there already.
# PHISTEP_NO_INSTALL=1 keeps it from installing anything.

phistep_die() {
  printf '\nphistep: %s\n' "$*" >&2
  exit 1
}

# Several scripts may run at once on one machine; apt then waits for its lock instead of failing.
phistep_apt() {
  if [ "$(id -u)" -eq 0 ]; then
    DEBIAN_FRONTEND=noninteractive apt-get -o DPkg::Lock::Timeout=300 -qq "$@"
  else
    sudo -n env DEBIAN_FRONTEND=noninteractive apt-get -o DPkg::Lock::Timeout=300 -qq "$@"
  fi >>"$phistep_log" 2>&1
}

phistep_can_install() {
  [ -z "${PHISTEP_NO_INSTALL:-}" ] && command -v apt-get >/dev/null 2>&1 || return 1
  [ "$(id -u)" -eq 0 ] || sudo -n true >/dev/null 2>&1
}

phistep_has_package() {
  dpkg-query -W -f '${Status}' "$1" 2>/dev/null | grep -q 'install ok installed'
}

# version_at_least <have> <want>
phistep_at_least() {
  [ "$(printf '%s\n%s\n' "$2" "$1" | sort -V | head -n 1)" = "$2" ]
}

phistep_install() {
  missing=
  for package in "$@"; do
    phistep_has_package "$package" || missing="$missing $package"
  done
  [ -n "$missing" ] || return 0
  if ! phistep_can_install; then
    echo "phistep: not installing$missing (no apt, or no rights to use it); CMake downloads the libraries it can"
    return 0
  fi
  echo "phistep: installing$missing"
  phistep_apt update || echo "phistep: apt-get update failed, trying with the lists that are here"
  # shellcheck disable=SC2086
  if ! phistep_apt install -y --no-install-recommends $missing; then
    tail -n 15 "$phistep_log" >&2
    echo "phistep: apt-get install failed (all of it: $phistep_log); going on with what is here" >&2
  fi
}

phistep_setup() {
  mkdir -p build
  phistep_log=$PWD/build/setup.log
  : >"$phistep_log"

  compiler_package=g++
  case ${CXX:-} in
    *clang*) compiler_package=$(basename "$CXX" | sed 's/clang++/clang/') ;;
    *g++-[0-9]*) compiler_package=$(basename "$CXX") ;;
  esac
  if [ -n "${CXX:-}" ] && command -v "$CXX" >/dev/null 2>&1; then compiler_package=; fi
  # shellcheck disable=SC2086
  phistep_install $compiler_package cmake ninja-build "$@"

  CXX=${CXX:-g++}
  command -v "$CXX" >/dev/null 2>&1 || CXX=c++
  command -v "$CXX" >/dev/null 2>&1 ||
    phistep_die "no C++ compiler. Install g++ 12 or clang 14 or later (Debian, Ubuntu: apt install g++), or set CXX."
  version=$("$CXX" -dumpfullversion 2>/dev/null || "$CXX" -dumpversion)
  if "$CXX" --version | head -n 1 | grep -qi clang; then
    phistep_at_least "$version" 14 || phistep_die "$CXX is clang $version, phistep needs 14 or later. Set CXX to a newer one."
  elif ! phistep_at_least "$version" 12; then
    # Ubuntu 22.04 has 11 as its default and 12 beside it.
    phistep_install g++-12
    command -v g++-12 >/dev/null 2>&1 || phistep_die "$CXX is g++ $version, phistep needs 12 or later. Set CXX to a newer one."
    CXX=g++-12
  fi

  cmake_version=$(cmake --version 2>/dev/null | sed -n '1s/[^0-9]*//p')
  if ! phistep_at_least "${cmake_version:-0}" 3.25; then
    phistep_cmake_from_pip
  fi

  generator="Unix Makefiles"
  if command -v ninja >/dev/null 2>&1; then generator=Ninja; fi

  faster=
  if command -v ccache >/dev/null 2>&1; then
    faster="-DCMAKE_CXX_COMPILER_LAUNCHER=ccache"
    CCACHE_SLOPPINESS=pch_defines,time_macros,include_file_mtime,include_file_ctime
    export CCACHE_SLOPPINESS
  fi
  for linker in mold lld; do
    if command -v "ld.$linker" >/dev/null 2>&1; then
      faster="$faster -DCMAKE_EXE_LINKER_FLAGS=-fuse-ld=$linker"
      break
    fi
  done

  # A unit that instantiates Eigen takes about 1 GB.
  jobs=$(nproc 2>/dev/null || echo 2)
  gigabytes=$(awk '/MemAvailable/ { print int($2 / 1048576) }' /proc/meminfo 2>/dev/null || echo "$jobs")
  if [ "${gigabytes:-0}" -lt "$jobs" ]; then jobs=$gigabytes; fi
  if [ "$jobs" -lt 1 ]; then jobs=1; fi

  export CXX
  echo "phistep: $CXX $version, CMake $(cmake --version | sed -n '1s/[^0-9]*//p'), $generator, $jobs jobs"
}

# A distribution whose CMake is too old: the same CMake from PyPI, inside build/.
phistep_cmake_from_pip() {
  if [ ! -x build/tools/bin/cmake ]; then
    phistep_install python3-venv
    echo "phistep: CMake 3.25 or later is needed, found ${cmake_version:-none}; fetching it into build/tools"
    if ! { python3 -m venv build/tools && build/tools/bin/pip install -q 'cmake>=3.25,<4' ninja; } >>"$phistep_log" 2>&1; then
      rm -rf build/tools
      phistep_die "could not get CMake 3.25 or later: see $phistep_log. Install it from https://cmake.org/download or with
  python3 -m pip install cmake, put it on PATH, and run this again."
    fi
  fi
  PATH=$PWD/build/tools/bin:$PATH
  export PATH
}

# phistep_from_pip <module> <packages> <test>: of PyPI, for a test, inside build/. Without them the test is skipped, visibly.
phistep_from_pip() {
  for python in build/tools/bin/python python3; do
    if "$python" -c "import $1" >/dev/null 2>&1; then return 0; fi
  done
  [ -z "${PHISTEP_NO_INSTALL:-}" ] || return 0
  phistep_install python3-venv
  echo "phistep: fetching $2 from PyPI into build/tools"
  # shellcheck disable=SC2086
  if ! {
    { [ -x build/tools/bin/python ] || python3 -m venv build/tools; } &&
      build/tools/bin/python -m pip install -q --no-deps --retries 1 --timeout 20 $2
  } >>"$phistep_log" 2>&1; then
    echo "phistep: no $2 from PyPI (why: $phistep_log); $3 is skipped"
  fi
}

# phistep_configure <folder> <cmake options...>; another compiler or generator than last time starts afresh, because
# CMake cannot change either in place.
phistep_configure() {
  folder=$1
  shift
  if [ -f "$folder/.made-with" ] && [ "$(cat "$folder/.made-with")" != "$CXX $generator" ]; then rm -rf "$folder"; fi
  mkdir -p "$folder"
  echo "$CXX $generator" >"$folder/.made-with"
  cmake -S . -B "$folder" -G "$generator" -DCMAKE_CXX_COMPILER="$CXX" "$@" >"$folder/configure.log" 2>&1 || {
    cat "$folder/configure.log" >&2
    phistep_die "CMake stopped; its last message above says what is missing and how to get it."
  }
  grep -- '-- phistep: ' "$folder/configure.log" | sed 's/^-- //' || true
}

# phistep_configure_tests <folder> <cmake options...>; build/test is what quick and full tests share.
phistep_configure_tests() {
  tests_folder=$1
  shift
  # Optimised, but with Eigen's assertions on: Release would define NDEBUG. -O1 takes a quarter less time to compile than
  # -O2, at which stress.sh, and -O3, at which the preset `release` compiles.
  # shellcheck disable=SC2086
  phistep_configure "$tests_folder" -DCMAKE_BUILD_TYPE=Release -DCMAKE_CXX_FLAGS_RELEASE=-O1 -DPHISTEP_BUILD_BENCH=OFF $faster "$@"
}

# phistep_build_and_run <label> <ctest options...>: all that is configured in build/test, then the tests of that label.
phistep_build_and_run() {
  label=$1
  shift
  cmake --build build/test -j "$jobs" || phistep_die "the build failed; the first error above is the one to look at."
  ctest --test-dir build/test -j "$jobs" -L "^$label\$" --output-on-failure --no-tests=error "$@"
}

# phistep_tests_of <header>: its line in tests/tests_of.txt, empty if there is none. phistep_targets_of <tests...>: what builds them.
phistep_tests_of() {
  sed -n "s|^$1: *||p" tests/tests_of.txt
}
phistep_targets_of() {
  printf 'test_%s\n' "$@" | tr -c 'a-zA-Z0-9_\n' _
}

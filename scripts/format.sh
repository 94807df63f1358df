#!/bin/sh
# sh scripts/format.sh [--check]
# Formats every C++ file of the project with clang-format 14; --check only says which differ, and fails if one does.
set -eu
cd "$(dirname "$0")/.."
tool=${CLANG_FORMAT:-clang-format}
command -v "$tool" >/dev/null 2>&1 || {
  echo "phistep: $tool not found (Debian, Ubuntu: apt install clang-format), or set CLANG_FORMAT" >&2
  exit 1
}
mode=-i
if [ "${1:-}" = --check ]; then mode='--dry-run --Werror'; fi
# shellcheck disable=SC2086
find include tests examples bench \( -name '*.hpp' -o -name '*.cpp' \) -print0 | xargs -0 "$tool" --style=file $mode

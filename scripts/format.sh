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
export tool
# --dry-run --Werror of clang-format 14 complains of the ends of our namespaces, which it then leaves as they are: so compare.
# shellcheck disable=SC2016  # the inner shell expands these
if [ "${1:-}" = --check ]; then
  each='status=0; for file; do
    "$tool" --style=file "$file" | cmp -s - "$file" || { echo "phistep: $file is not formatted" >&2; status=1; }
  done; exit $status'
else
  each='"$tool" --style=file -i "$@"'
fi
find include tests examples bench \( -name '*.hpp' -o -name '*.cpp' \) -print0 | xargs -0 sh -c "$each" sh

#!/bin/sh
# sh scripts/docs.sh [--write]
# Checks the pages' links and the reference, and builds the site: build/docs/site/index.html. What the pages' code prints is compared by
# scripts/full.sh. --write first renews docs/reference/names.md and signatures.txt: the public names, whose changes CHANGELOG.md names.
set -eu
cd "$(dirname "$0")/.."
. scripts/setup.sh

phistep_log=$PWD/build/setup.log
mkdir -p build/docs
: >"$phistep_log"
phistep_install doxygen mkdocs mkdocs-material python3
for tool in doxygen mkdocs python3; do
  command -v $tool >/dev/null 2>&1 || phistep_die "$tool is missing (Debian, Ubuntu: apt install doxygen mkdocs mkdocs-material)"
done

echo "phistep: reading the headers"
doxygen docs/Doxyfile >build/docs/doxygen.log 2>&1 || phistep_die "doxygen failed: see build/docs/doxygen.log"
if [ -s build/docs/doxygen.log ]; then
  cat build/docs/doxygen.log >&2
  phistep_die "doxygen can't read these docstrings"
fi
if [ "${1:-}" = --write ]; then python3 scripts/reference.py --xml build/docs/doxygen/xml --write; fi

python3 tests/docs/check_links.py .
python3 scripts/gather_pages.py build/docs/pages
python3 scripts/reference.py --xml build/docs/doxygen/xml --site build/docs/pages/reference
rm -rf build/docs/site
cp docs/mkdocs.yml build/docs/mkdocs.yml
cp docs/site.css build/docs/pages/site.css
NO_MKDOCS_2_WARNING=1 mkdocs build --quiet --strict --config-file build/docs/mkdocs.yml
cp -R build/docs/doxygen/html build/docs/site/headers
echo "phistep: the site is in $PWD/build/docs/site/index.html"

#!/bin/sh
# sh scripts/cases.sh [revision]
# Lists all test cases, one a line: the case, its test, its tier; of a revision, or of the working tree. Two lists compare
# with `comm`: sh scripts/cases.sh v1 | cut -f 1,2 | sort -u
set -eu
cd "$(dirname "$0")/.."
if [ $# -gt 0 ]; then
  files=$(git ls-tree -r --name-only "$1" tests)
  show() { git show "$revision:$1"; }
  revision=$1
else
  files=$(git ls-files --cached --others --exclude-standard tests)
  show() { cat "$1"; }
fi
for file in $files; do
  case $file in
    *.test.cpp) tier=quick ;;
    *.full.cpp) tier=full ;;
    *.stress.cpp) tier=stress ;;
    *) continue ;;
  esac
  [ $# -gt 0 ] || [ -f "$file" ] || continue
  name=${file#tests/}
  # A section #if PHISTEP_FULL is of the tier full; what stands before a file's sections is of all of them, and holds no cases.
  show "$file" | NAME=${name%.*.cpp} TIER=$tier perl -0777 -ne '
    while (/^(?:#(?:el)?if PHISTEP_(QUICK|FULL|STRESS)$|(?:TEMPLATE_)?TEST_CASE(?:_[A-Z]+)*\(\s*((?:"(?:[^"\\]|\\.)*"\s*)+))/mg) {
      if ($1) { $ENV{TIER} = lc $1; next }
      my $case = $2;
      $case =~ s/"\s*"//g;
      $case =~ s/^"|"\s*$//g;
      print "$case\t$ENV{NAME}\t$ENV{TIER}\n";
    }'
done | sort

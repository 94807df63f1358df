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
  # A section #if PHISTEP_FULL is of the tier full; what stands outside of a file's sections is of all tiers that it names.
  show "$file" | NAME=${name%.*.cpp} TIER=$tier perl -0777 -ne '
    my @all = map { lc } /^#(?:el)?if PHISTEP_(QUICK|FULL|STRESS)$/mg;
    my %once;
    @all = grep { !$once{$_}++ } @all ? @all : ($ENV{TIER});
    my ($depth, $section, @now) = (0, 0, @all);  # of #ifs; where the section began
    while (/^(?:#(?:el)?if PHISTEP_(QUICK|FULL|STRESS)$|#(ifn?(?:def)?|endif)\b|(?:TEMPLATE_)?TEST_CASE(?:_[A-Z]+)*\(\s*((?:"(?:[^"\\]|\\.)*"\s*)+))/mg) {
      if ($1) {
        $section = ++$depth if !$section;
        @now = (lc $1);
      } elsif ($2 && $2 ne "endif") {
        ++$depth;
      } elsif ($2) {
        if ($depth-- == $section) { $section = 0, @now = @all }
      } else {
        my $case = $3;
        $case =~ s/"\s*"//g;
        $case =~ s/^"|"\s*$//g;
        print "$case\t$ENV{NAME}\t$_\n" for @now;
      }
    }'
done | sort

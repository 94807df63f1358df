#!/usr/bin/env python3
"""python3 scripts/tests_of.py BUILD: writes tests/tests_of.txt, which tests see a change of a header, the nearest first.

BUILD has the quick and the full tests, compiled with line tables: configure it with -DCMAKE_CXX_FLAGS=-g1 -DPHISTEP_FULL=ON, build
phistep_quick_tests and phistep_full_tests. A test sees the lines of a header that were compiled into its program. The test of the
header's own path comes first; then, one by one, the one that sees most lines that none before it saw, small programs preferred:
until nine tenths are seen, or there are four. Quick tests serve where one sees the header, full ones elsewhere. A header without a
line of its own (concepts, tables of contents) is seen by the tests that include it by its name, of those headers that do, or of
those that it includes.
"""
import json
import math
import pathlib
import re
import subprocess
import sys

root = pathlib.Path(__file__).resolve().parent.parent
library = root / "include" / "phistep"
MOST, ENOUGH = 4, 0.9  # about a minute to build and run

HEAD = """\
# Which tests see a change of a header, the nearest first: paths relative to include/phistep, then tests by their names
# under tests/ without ".test.cpp". They are quick ones where one sees the header, and not all: the whole suite has the last word.
# Written by scripts/tests_of.py; read by scripts/touched.sh (who has touched one header runs these) and scripts/mutations.sh.
"""


def programs(build):
    """Name and program of each quick and each full test that is compiled from one file of tests/."""
    listed = json.loads(subprocess.run(["ctest", "--test-dir", build, "--show-only=json-v1"], check=True, capture_output=True, text=True).stdout)
    for test in listed["tests"]:
        command = test.get("command", [])
        if len(command) == 1 and source_of(test["name"]) and pathlib.Path(command[0]).is_file():
            yield test["name"], command[0]


def source_of(test):
    """Its file; None if there is none."""
    name = test.removeprefix("full/")
    files = [root / "tests" / f"{name}.{tier}.cpp" for tier in (("test", "full") if name != test else ("test",))]
    return next((file for file in files if file.is_file()), None)


def lines_of(program):
    """The lines of the library's headers in a program's line table."""
    seen, header = set(), None
    table = subprocess.run(["objdump", "--dwarf=decodedline", program], check=True, capture_output=True, text=True).stdout
    for line in table.splitlines():
        path = re.match(r"(?:CU: )?(\S+):$", line)
        if path:
            inside = path.group(1).rpartition("include/phistep/")
            header = inside[2] if inside[1] and inside[2].endswith(".hpp") else None
        elif header:
            row = re.match(r"\S+\s+(\d+)\s+0x", line)
            if row:
                seen.add((header, int(row.group(1))))
    return seen


def choose(header, tests, size):
    """The tests that see most of the header, of those in `tests`: its lines by test."""
    own = next((test for test in tests if test.removeprefix("full/") == header[: -len(".hpp")]), None)
    chosen = [own] if own else []
    todo = set().union(*tests.values())
    enough = (1 - ENOUGH) * len(todo)
    todo -= tests.get(own, set())
    while tests and len(todo) > enough and len(chosen) < MOST:
        best = max(sorted(tests), key=lambda test: len(tests[test] & todo) / size[test])
        chosen.append(best)
        todo -= tests[best]
    return chosen


def main(build):
    seen = {name: lines_of(program) for name, program in programs(build)}
    if not any(seen.values()):
        sys.exit(f"no test in {build} has line tables: configure it with -DCMAKE_CXX_FLAGS=-g1")
    headers = sorted(str(path.relative_to(library)) for path in library.rglob("*.hpp"))
    includes = re.compile(r"^#include [<\"]phistep/([^>\"]+)[>\"]", re.M)
    included = {h: includes.findall((library / h).read_text()) for h in headers}
    users = {h: [u for u in headers if h in included[u]] for h in headers}
    by_name = {test: set(includes.findall(source_of(test).read_text())) for test in seen}
    of_header = {h: {} for h in headers}
    for test, lines in seen.items():
        for header, line in lines:
            if header in of_header:
                of_header[header].setdefault(test, set()).add(line)
    size = {test: math.sqrt(max(len(lines), 1)) for test, lines in seen.items()}

    found = {}
    for header, tests in of_header.items():
        quick = {test: lines for test, lines in tests.items() if not test.startswith("full/")}
        found[header] = choose(header, quick or tests, size)
        if not found[header]:
            naming = sorted((test for test in seen if header in by_name[test]), key=lambda test: (test.startswith("full/"), size[test]))
            found[header] = naming[:2]
    for header in headers:  # nobody names it, and it has no line: breadth first through those that include it
        known, near = {header}, users[header]
        while not found[header] and near:
            found[header] = list(dict.fromkeys(test for user in near for test in found[user][:2]))[:2]
            known.update(near)
            near = sorted({u for n in near for u in users[n]} - known)
        if not found[header]:  # a table of contents that nobody names: what it holds
            found[header] = list(dict.fromkeys(test for other in included[header] for test in found[other][:1]))[:2]
    text = HEAD + "".join(f"{header}: {' '.join(tests)}\n" for header, tests in found.items())
    (root / "tests" / "tests_of.txt").write_text(text)
    print(f"{len(headers)} headers, {len(seen)} tests; {sum(not t for t in found.values())} headers without a test")


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    main(sys.argv[1])

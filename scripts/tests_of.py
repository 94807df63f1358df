#!/usr/bin/env python3
"""python3 scripts/tests_of.py BUILD: writes tests/tests_of.txt, which quick tests see a change of a header, the nearest first.

BUILD has the quick tests, compiled with line tables: configure it with -DCMAKE_CXX_FLAGS=-g1, build phistep_quick_tests. A test sees
the lines of a header that were compiled into its program. The test of the header's own path comes first; then, one by one, the
one that sees most lines that none before it saw, small programs preferred: until nine tenths are seen, or there are four. A header
without a line of its own (concepts, tables of contents) is seen by the tests of those that include it.
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
# under tests/ without ".test.cpp". They are quick ones, and not all: the whole suite has the last word.
# Written by scripts/tests_of.py; read by scripts/touched.sh (who has touched one header runs these) and scripts/mutations.sh.
"""


def quick_tests(build):
    """Name and program of each quick test that is one of tests/<name>.test.cpp."""
    listed = json.loads(subprocess.run(["ctest", "--test-dir", build, "--show-only=json-v1"], check=True, capture_output=True, text=True).stdout)
    for test in listed["tests"]:
        name, command = test["name"], test.get("command", [])
        if len(command) == 1 and (root / "tests" / f"{name}.test.cpp").is_file():
            yield name, command[0]


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


def main(build):
    seen = {name: lines_of(program) for name, program in quick_tests(build)}
    if not any(seen.values()):
        sys.exit(f"no test in {build} has line tables: configure it with -DCMAKE_CXX_FLAGS=-g1")
    headers = sorted(str(path.relative_to(library)) for path in library.rglob("*.hpp"))
    included = {h: re.findall(r"^#include <phistep/([^>]+)>", (library / h).read_text(), re.M) for h in headers}
    users = {h: [u for u in headers if h in included[u]] for h in headers}
    of_header = {h: {} for h in headers}
    for test, lines in seen.items():
        for header, line in lines:
            if header in of_header:
                of_header[header].setdefault(test, set()).add(line)
    size = {test: math.sqrt(max(len(lines), 1)) for test, lines in seen.items()}

    found = {}
    for header, tests in of_header.items():
        own = header[: -len(".hpp")]
        chosen = [own] if own in seen else []
        todo = set().union(*tests.values())
        enough = (1 - ENOUGH) * len(todo)
        todo -= tests.get(own, set())
        while tests and len(todo) > enough and len(chosen) < MOST:
            best = max(sorted(tests), key=lambda test: len(tests[test] & todo) / size[test])
            if not tests[best] & todo:
                break
            chosen.append(best)
            todo -= tests[best]
        found[header] = chosen
    for header in headers:  # those without a line: breadth first through those that include them
        known, near = {header}, users[header]
        while not found[header] and near:
            found[header] = list(dict.fromkeys(test for user in near for test in found[user][:2]))[:2]
            known.update(near)
            near = sorted({u for n in near for u in users[n]} - known)
    text = HEAD + "".join(f"{header}: {' '.join(tests)}\n" for header, tests in found.items())
    (root / "tests" / "tests_of.txt").write_text(text)
    print(f"{len(headers)} headers, {len(seen)} tests; {sum(not t for t in found.values())} headers without a test")


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    main(sys.argv[1])

#!/usr/bin/env python3
"""Compares the runs of pinned.hpp with what is pinned.

    check.py hashes PROGRAM hashes.txt [--write]           the bits, by any compiler under the portable flags
    check.py threads PROGRAM                               the bits of 1 to 4 threads are equal, under any flags
    check.py counts PROGRAM counts.txt COMPILER [--write WHY]
                                                           instructions, by callgrind: 2 % more is said, 5 % is an error

--write renews the file. A run that takes 5 % more instructions than its line says is red until the line says so and why:
    check.py counts PROGRAM counts.txt COMPILER --write "the error norm is checked for NaN"
"""
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

SAID, REFUSED = 1.02, 1.05


def output(program, *arguments, **environment):
    return subprocess.run([program, *arguments], env={**os.environ, **environment}, check=True, capture_output=True, text=True).stdout


def hashes(program, path, *rest):
    found = dict(re.findall(r"^(.*?) +([0-9a-f]{16})$", output(program), re.M))
    if rest == ("--write",):
        path.write_text("".join(f"{name:<44} {bits}\n" for name, bits in sorted(found.items())))
    pinned = dict(re.findall(r"^(.*?) +([0-9a-f]{16})$", path.read_text(), re.M))
    wrong = sorted(name for name in found.keys() | pinned.keys() if found.get(name) != pinned.get(name))
    for name in wrong:
        print(f"{name}: {found.get(name, 'no such run')}, pinned {pinned.get(name, 'nowhere')}")
    print(f"{len(found)} runs, {len(wrong)} with other bits than {path.name}")
    return not wrong


def threads(program):
    one = output(program, OMP_NUM_THREADS="1")
    right = True
    for number in "234":
        many = output(program, OMP_NUM_THREADS=number)
        for a, b in zip(one.splitlines(), many.splitlines(), strict=True):
            if a != b:
                right = False
                print(f"{number} threads: {b}\n1 thread:  {a}")
    print(f"{len(one.splitlines())} runs by 1 to 4 threads: {'the same bits' if right else 'other bits'}")
    return right


def instructions(program, name):
    with tempfile.TemporaryDirectory() as folder:
        out = pathlib.Path(folder) / "out"
        subprocess.run(["valgrind", "--tool=callgrind", f"--callgrind-out-file={out}", program, "--only", name],
                       env={**os.environ, "OMP_NUM_THREADS": "1"}, check=True, capture_output=True)
        return int(re.search(r"^(?:summary|totals): (\d+)", out.read_text(), re.M).group(1))


def counts(program, path, compiler, *rest):
    lines = path.read_text().splitlines()
    made_by = re.search(r"^# compiler: (.*)$", path.read_text(), re.M).group(1)
    if rest[:1] != ("--write",) and (compiler != made_by or not shutil.which("valgrind")):
        print(f"skipped: {compiler}, counted with {made_by}; valgrind: {shutil.which('valgrind')}")
        return True
    before = instructions(program, "nothing")
    right, renewed = True, []
    for line in lines:
        match = re.match(r"(.*?)  +(\d+)( +#.*)?$", line)
        if not match or line.startswith("#"):
            renewed.append(f"# compiler: {compiler}" if line.startswith("# compiler: ") else line)
            continue
        name, pinned, why = match.group(1), int(match.group(2)), match.group(3) or ""
        found = instructions(program, name) - before
        ratio = found / pinned
        if ratio > REFUSED:
            right = False
        remark = "MORE: explain it in the file" if ratio > REFUSED else "more" if ratio > SAID else "less" if ratio < 2 - SAID else ""
        print(f"{name:<44} {found:>12}  {ratio:6.3f}  {remark}")
        if rest[:1] == ("--write",) and abs(ratio - 1) > SAID - 1:
            pinned, why = found, f"  # {rest[1]}"
        renewed.append(f"{name:<44}  {pinned:>12}{why}")
    if rest[:1] == ("--write",):
        path.write_text("\n".join(renewed) + "\n")
        return True
    return right


if __name__ == "__main__":
    what, program, *rest = sys.argv[1:]
    if what == "threads":
        sys.exit(not threads(program))
    sys.exit(not {"hashes": hashes, "counts": counts}[what](program, pathlib.Path(rest[0]), *rest[1:]))

#!/usr/bin/env python3
"""self_test.py FOLDER: plants one fault at a time in a sound page and demands that check_page.py, check_links.py or reference.py
names it."""
import pathlib
import shutil
import subprocess
import sys

HERE = pathlib.Path(__file__).resolve().parent
sys.path.append(str(HERE.parent.parent / "scripts"))
from reference import unmentioned  # noqa: E402
PROGRAM = "```cpp\n#include <cstdio>\nint main() { std::puts(\"one\"); }\n```\n"
FRAGMENT = "```cpp\nint n = 2;\nstd::printf(\"%d\\n\", n);\n```\n"
FAILS = "<!-- fails -->\n```cpp\nint n = \"two\";\n```\n"


def run(*command):
    done = subprocess.run([sys.executable, *map(str, command)], capture_output=True, text=True)
    return done.returncode, done.stdout + done.stderr


def demand(name, result, sound, text):
    returned, said = result
    if (returned == 0) != sound or text not in said:
        sys.exit(f"{name}: expected {'a sound page' if sound else text!r}, got exit {returned} and\n{said}")
    print(f"{name}: {text}")


def page(folder, name, text, sound, expected):
    path = folder / f"{name}.md"
    path.write_text(text, encoding="utf-8")
    demand(name, run(HERE / "check_page.py", path, "--work", folder / name, "--root", HERE.parent.parent), sound, expected)


def links(folder, name, text, sound, expected):
    root = folder / f"links_{name}"
    (root / "docs").mkdir(parents=True)
    (root / "examples").mkdir()
    (root / "README.md").write_text("# Home\n[a](docs/a.md)\n", encoding="utf-8")
    (root / "CONTRIBUTING.md").write_text("# C\n", encoding="utf-8")
    (root / "docs" / "a.md").write_text("# A page\n## A section, named\n" + text, encoding="utf-8")
    (root / "docs" / "mkdocs.yml").write_text("nav:\n  - A: a.md\n", encoding="utf-8")
    demand(name, run(HERE / "check_links.py", root), sound, expected)


def signatures(name, now, log, count, more=()):
    """Before: `int a()`, `int b()` and more; `count` of them are not mentioned."""
    found = unmentioned(["a: int a()", "b: int b()", *more], now, f"# Changelog\n\n## 2\n{log}\n\n## 1\n`a`, `c` are new.\n")
    demand(name, (len(found), "\n".join(found)), count == 0, "doesn't name" if count else "")


def main():
    folder = pathlib.Path(sys.argv[1])
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    shown, count = "```text\none\n```\n", "```text\n2\n```\n"
    error = "```text\nerror: invalid conversion from\n```\n"
    page(folder, "sound", PROGRAM + shown + FRAGMENT + count + FAILS + error, True, "1 programs, 2 outputs compared, 1 fragments, 1 errors")
    page(folder, "another_output", PROGRAM + "```text\ntwo\n```\n", False, "prints")
    page(folder, "longer_output", PROGRAM + "```text\none\ntwo\n```\n", False, "prints")
    page(folder, "another_fragment", FRAGMENT + "```text\n3\n```\n", False, "prints")
    page(folder, "any_output", PROGRAM + "```text\no…\n```\n", True, "1 outputs compared")
    page(folder, "not_any_output", PROGRAM + "```text\nt…\n```\n", False, "prints")
    page(folder, "no_program", PROGRAM.replace(";", ""), False, "does not compile")
    page(folder, "warns", PROGRAM.replace("{ ", "{ int n; "), False, "does not compile without a warning")
    page(folder, "crashes", PROGRAM.replace("; }", "; return 3; }"), False, "returns 3")
    page(folder, "does_not_fail", FAILS.replace('"two"', "2"), False, "must not")
    page(folder, "fails_otherwise", FAILS + "```text\nerror: something else\n```\n", False, "the compiler does not say")
    page(folder, "no_code", "# Nothing\n", False, "no code")
    links(folder, "links", "[b](../README.md#home) [c](#a-section-named)\n", True, "2 links, all there".replace("2", "3"))
    links(folder, "dead_link", "[b](b.md)\n", False, "there is no such file")
    links(folder, "dead_section", "[b](#another)\n", False, "no heading of that name")
    links(folder, "lost", "[b](../README.md)\n", True, "all there")
    (folder / "links_lost" / "docs" / "lost.md").write_text("# Lost\n", encoding="utf-8")
    demand("lost_page", run(HERE / "check_links.py", folder / "links_lost"), False, "no page leads to it")
    signatures("kept_and_new", ["a: int a()", "b: int b()", "c: int c()"], "", 0)
    signatures("vanished", ["b: int b()"], "All is well.", 1)
    signatures("changed", ["a: int a(int)", "b: int b()"], "`aa` is new.", 1)
    signatures("member", ["a: int a()", "b: int b()"], "`b` has changed.", 1, ["b::c: int c()"])
    signatures("member_mentioned", ["a: int a()", "b: int b()"], "`b::c` has changed.", 0, ["b::c: int c()"])
    signatures("with_its_class", ["a: int a()"], "`b` is gone.", 0, ["b::c: int c()"])
    signatures("mentioned", ["a: int a(int)"], "`a(int)` in place of `a()`; b is gone.", 0)


main()

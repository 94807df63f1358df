#!/usr/bin/env python3
"""Compiles and runs the code of a Markdown page, and compares what it prints with what the page shows.

    check_page.py PAGE --work FOLDER --compiler g++ --root REPOSITORY [--system FOLDER ...] [--precompiled FOLDER]

What the page holds (a directive is an HTML comment of its own, before the block it is for):

    ```cpp with `int main`     a program: it compiles without a warning and returns 0
    ```cpp without             a fragment: the body of a function, or at namespace scope where it begins with struct, template,
                               #include, using or namespace; the fragments of a page are one unit, run in order
    ```text after either       what it prints, exactly; "…" stands for the rest of a word or line, a line "…" for any lines
    ```diff                    a program before and after: both compile, and print the same
    <!-- prelude ... -->       hidden code at namespace scope, for all fragments that follow
    <!-- setup ... -->         hidden first lines of the next fragment
    <!-- compile only -->      compiled, not run
    <!-- fails -->             must not compile; the compiler's message has every line of the ```text block that follows
    <!-- flags: -fopenmp -->   more flags for the next program
    <!-- needs: a/header.h --> left out, visibly, where the compiler doesn't find the header
    <!-- file: name -->        the next block, of any kind, is saved in the working folder under this name
    <!-- run -->               the next ```sh block is run in the working folder, where phistep/ is the repository; the ```text
                               that follows is what it prints

All programs of a page share the working folder, and run in the order of the page.
"""
import argparse
import os
import re
import subprocess
import sys

FENCE = re.compile(r"^( *)(```+|~~~+)(\w*)[^\n]*\n(.*?)^\1\2 *$", re.M | re.S)
DIRECTIVE = re.compile(r"<!-- *(prelude|setup|compile only|fails|flags|needs|file|run)\b:?(.*?)-->", re.S)
NAMESPACE_SCOPE = re.compile(r"(struct|class|template|#include|using|namespace|inline|constexpr)\b")
ANY_LINES = r"(?:[^\n]*\n)*"
WARNINGS = "-Wall -Wextra -Wpedantic -Wconversion -Wshadow".split()


class Block:
    def __init__(self, line, kind, text):
        self.line, self.kind, self.text = line, kind, text
        self.directives, self.shown = {}, None


def blocks_of(page):
    """The code blocks of a page in order, each with its directives and, where a text block follows, what it shows."""
    marks = [(m.start(), m) for m in FENCE.finditer(page)]
    inside = [(m.start(), m.end()) for _, m in marks]
    marks += [(m.start(), m) for m in DIRECTIVE.finditer(page) if not any(b < m.start() < e for b, e in inside)]
    found, waiting = [], {}
    for start, m in sorted(marks, key=lambda mark: mark[0]):
        line = page.count("\n", 0, start) + 1
        if m.re is DIRECTIVE:
            name, value = m.group(1), m.group(2)
            if name == "prelude":
                found.append(Block(line, "prelude", value))
            elif name == "setup":
                waiting[name] = waiting.get(name, "") + value
            else:
                waiting[name] = value.strip()
            continue
        indent, kind, text = m.group(1), m.group(3), m.group(4)
        text = re.sub("^" + indent, "", text, flags=re.M)
        if kind == "text" and found and found[-1].shown is None and not waiting and found[-1].kind != "prelude":
            found[-1].shown = text
            continue
        block = Block(line, kind, text)
        block.directives, waiting = waiting, {}
        found.append(block)
    if waiting:
        raise SystemExit(f"directives without a block at the end of the page: {waiting}")
    return found


def matches(shown, printed):
    """Whether they are the same, "…" being any rest of a word or line, and a line of its own any lines."""
    lines = [ANY_LINES if line == "…" else re.escape(line).replace("…", r"[^\n]*") + r"\n" for line in shown.rstrip().split("\n")]
    return re.fullmatch("".join(lines), printed.rstrip() + "\n") is not None


class Checker:
    def __init__(self, page, args):
        self.page, self.args = page, args
        self.problems, self.counts, self.left_out = [], {}, []
        first = [f"-I{args.precompiled}"] if args.precompiled else []
        includes = [*first, f"-I{args.root}/include"] + [f"-isystem{d}" for d in args.system]
        self.flags = ["-std=c++20", "-O1", *WARNINGS, *includes]
        os.makedirs(args.work, exist_ok=True)
        link = os.path.join(args.work, "phistep")
        if not os.path.islink(link):
            os.symlink(os.path.abspath(args.root), link)

    def problem(self, line, text):
        self.problems.append(f"{self.page}:{line}: {text}")

    def count(self, what):
        self.counts[what] = self.counts.get(what, 0) + 1

    def path(self, name):
        return os.path.join(self.args.work, name)

    def write(self, name, text):
        with open(self.path(name), "w", encoding="utf-8") as out:
            out.write(text)
        return self.path(name)

    def compile(self, source, *more):
        command = self.args.launcher + [self.args.compiler, *self.flags, source, *more]
        return subprocess.run(command, capture_output=True, text=True, errors="replace", cwd=self.args.work)

    def run(self, command, line):
        done = subprocess.run(command, capture_output=True, text=True, errors="replace", cwd=self.args.work, timeout=120)
        if done.returncode != 0:
            self.problem(line, f"returns {done.returncode}\n{done.stdout}{done.stderr}")
            return None
        return done.stdout

    def compare(self, block, printed):
        if block.shown is not None and printed is not None:
            self.count("outputs compared")
            if not matches(block.shown, printed):
                self.problem(block.line, f"prints\n{printed}\nwhere the page shows\n{block.shown}")

    def is_missing(self, block):
        header = block.directives.get("needs")
        if header is None:
            return False
        probe = self.write("probe.cpp", f"#include <{header}>\n")
        more = block.directives.get("flags", "").split()
        if self.compile(probe, "-w", "-fsyntax-only", *[f for f in more if f.startswith(("-I", "-std", "-f"))]).returncode == 0:
            return False
        self.left_out.append(f"line {block.line} ({header} is missing)")
        return True

    def must_fail(self, block, text):
        self.count("errors")
        said = self.compile(self.write("fails.cpp", text), "-fsyntax-only", *block.directives.get("flags", "").split())
        if said.returncode == 0:
            self.problem(block.line, "compiles, where the page says that it must not")
        for line in (block.shown or "").splitlines():
            pattern = re.escape(line.strip()).replace("…", r"[^\n]*")
            if line.strip() not in ("", "…") and not re.search(pattern, said.stderr):
                self.problem(block.line, f"the compiler does not say\n{line}\nbut\n{said.stderr[:3000]}")

    def program(self, block, name):
        self.count("programs")
        source = self.write(block.directives.get("file") or f"{name}.cpp", block.text)
        more = block.directives.get("flags", "").split()
        said = self.compile(source, "-o", self.path(name), *more)
        if said.returncode != 0 or said.stderr:
            self.problem(block.line, f"does not compile without a warning\n{said.stderr[:6000]}")
        elif "compile only" not in block.directives:
            self.compare(block, self.run([self.path(name)], block.line))

    def before_and_after(self, block, name):
        self.count("programs before and after")
        printed = []
        for side, other in (("before", "+"), ("after", "-")):
            lines = [line for line in block.text.splitlines() if not line.startswith(other)]
            source = self.write(f"{name}_{side}.cpp", "\n".join(line[1:] for line in lines) + "\n")
            said = self.compile(source, "-ffp-contract=off", "-o", self.path(f"{name}_{side}"))
            if said.returncode != 0 or said.stderr:
                self.problem(block.line, f"({side}) does not compile without a warning\n{said.stderr[:6000]}")
                return
            printed.append(self.run([self.path(f"{name}_{side}")], block.line))
        if printed[0] != printed[1] or not printed[0]:
            self.problem(block.line, f"prints\n{printed[0]}before, and\n{printed[1]}after")
        self.compare(block, printed[1])

    def fragments(self, blocks):
        """One unit of all fragments; `#line` leads the compiler's messages to the page."""
        unit, prelude = ["#include <cstdio>\n"], ""  # of texts, and of blocks that are bodies of functions
        for block in blocks:
            here = f'#line {block.line + 1} "{self.page}"\n'
            if block.kind == "prelude":
                unit.append(f'#line {block.line} "{self.page}"\n{block.text}\n')
                prelude += block.text + "\n"
            elif "fails" in block.directives:
                body = block.text
                if not NAMESPACE_SCOPE.match(body):
                    body = f"void fragment() {{\n{block.directives.get('setup', '')}\n{body}}}\n"
                self.must_fail(block, prelude + body)
            elif self.is_missing(block):
                continue
            elif NAMESPACE_SCOPE.match(block.text):
                self.count("fragments")
                unit.append(here + block.text + "\n")
                prelude += block.text + "\n"
            else:
                self.count("fragments")
                unit.append(block)
        if len(unit) == 1:
            return
        text, calls = "", ""
        for part in unit:
            if isinstance(part, str):
                text += part
                continue
            text += f"static void fragment_{part.line}() {{\n" + part.directives.get("setup", "") + "\n"
            text += f'std::printf("\\036{part.line}\\n"); std::fflush(stdout);\n'
            text += f'#line {part.line + 1} "{self.page}"\n{part.text}\n}}\n'
            if "compile only" in part.directives:
                calls += f"  if (false) fragment_{part.line}();\n"
            else:
                calls += f"  fragment_{part.line}();\n  std::cout.flush();\n"
        first = "#include <phistep/phistep.hpp>\n" if self.args.precompiled else ""
        source = self.write("fragments.cpp", first + "#include <iostream>\n" + text + "int main() {\n" + calls + "}\n")
        # A fragment may show a declaration for itself: what it leaves unused is no fault.
        flags = [f for block in blocks for f in block.directives.get("flags", "").split() if "int main" not in block.text]
        said = self.compile(source, "-Wno-unused", "-Wno-shadow", "-o", self.path("fragments"), *flags)
        if said.returncode != 0 or said.stderr:
            self.problem(blocks[0].line, f"the fragments do not compile without a warning\n{said.stderr[:6000]}")
            return
        printed = self.run([self.path("fragments")], blocks[0].line)
        if printed is None:
            return
        outputs = dict(re.findall("\x1e(\\d+)\n([^\x1e]*)", printed))
        for block in blocks:
            if str(block.line) in outputs:
                self.compare(block, outputs[str(block.line)])

    def check(self):
        with open(self.page, encoding="utf-8") as page:
            blocks = blocks_of(page.read())
        fragments = []
        for number, block in enumerate(blocks):
            name = f"program_{number}"
            is_program = block.kind == "cpp" and re.search(r"\bint main\(", block.text)
            if block.kind == "prelude" or (block.kind == "cpp" and not is_program):
                fragments.append(block)
            elif is_program and "fails" in block.directives:
                self.must_fail(block, block.text)
            elif is_program:
                if not self.is_missing(block):
                    self.program(block, name)
            elif block.kind == "diff":
                self.before_and_after(block, name)
            elif block.kind == "sh" and "run" in block.directives:
                self.count("commands")
                self.compare(block, self.run(["sh", "-euc", block.text], block.line))
            elif "file" in block.directives:
                self.write(block.directives["file"], block.text)
        self.fragments(fragments)
        if not self.counts:
            self.problem(1, "no code")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("page")
    parser.add_argument("--work", required=True)
    parser.add_argument("--precompiled", default="", help="where phistep/phistep.hpp.gch is, for g++")
    parser.add_argument("--root", default=os.path.join(os.path.dirname(__file__), "..", ".."))
    parser.add_argument("--compiler", default=os.environ.get("CXX", "g++"))
    parser.add_argument("--launcher", default="", type=lambda text: text.split())
    parser.add_argument("--system", action="append", default=[])
    args = parser.parse_args()
    args.work, args.root = os.path.abspath(args.work), os.path.abspath(args.root)
    checker = Checker(os.path.abspath(args.page), args)
    checker.check()
    if checker.problems:
        print("\n\n".join(checker.problems))
        print(f"{len(checker.problems)} problems")
        sys.exit(1)
    said = ", ".join(f"{n} {what}" for what, n in checker.counts.items())
    print(f"{args.page}: {said}" + "".join(f"\nleft out: {text}" for text in checker.left_out))


if __name__ == "__main__":
    main()

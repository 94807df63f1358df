#!/usr/bin/env python3
"""gather_pages.py FOLDER: copies README.md, CONTRIBUTING.md, CHANGELOG.md, docs/ and examples/README.md into one folder, as MkDocs
wants it, docs/ at its top; links that left docs/ follow, and the files they lead to are copied beside."""
import os
import pathlib
import re
import shutil
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent


def place(path):
    """Where a file of the repository lies in the folder."""
    name = path.relative_to(ROOT).as_posix()
    return name.removeprefix("docs/")


def main():
    folder = pathlib.Path(sys.argv[1])
    shutil.rmtree(folder, ignore_errors=True)
    sources = [ROOT / n for n in ("README.md", "CONTRIBUTING.md", "CHANGELOG.md", "examples/README.md")] + sorted((ROOT / "docs").rglob("*.md"))
    linked = set()
    for source in (s for s in sources if s.exists()):
        to = folder / place(source)

        def moved(link):
            path, hash_, anchor = link.group(2).partition("#")
            target = (source.parent / path).resolve()
            if not path or re.match(r"[a-z]+:", path) or not target.exists() or ROOT not in target.parents:
                return link.group(0)
            if target.is_dir():
                target = target / "README.md"
            linked.add(target)
            return link.group(1) + os.path.relpath(folder / place(target), to.parent) + hash_ + anchor + ")"

        text = re.sub(r"(\]\()([^()\s]+)\)", moved, source.read_text(encoding="utf-8"))
        to.parent.mkdir(parents=True, exist_ok=True)
        to.write_text(text, encoding="utf-8")
    for target in linked:
        if target not in sources:
            (folder / place(target)).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(target, folder / place(target))


main()

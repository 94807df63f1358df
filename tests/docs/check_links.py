#!/usr/bin/env python3
"""check_links.py REPOSITORY: every relative link and image of README.md, CONTRIBUTING.md, docs/ and examples/ leads somewhere.

A link to a page's section needs a heading of that name; a page of docs/ must be reached from another one and be in the site's
contents (docs/mkdocs.yml). Links to other sites are not tried.
"""
import pathlib
import re
import sys

LINK = re.compile(r"!?\[(?:[^\[\]]|\[[^\]]*\])*\]\(([^()\s]+(?:\([^()\s]*\)[^()\s]*)*)\)")


def without_code(text):
    text = re.sub(r"^( *)(```+).*?^\1\2 *$", "", text, flags=re.M | re.S)
    return re.sub(r"`[^`\n]*`", "", text)


def anchors(path):
    """The names that a heading gets on a code host and on the site: lower case, punctuation dropped, hyphens for spaces."""
    found = set()
    text = re.sub(r"^( *)(```+).*?^\1\2 *$", "", path.read_text(encoding="utf-8"), flags=re.M | re.S)
    for heading in re.findall(r"^#+ +(.*?) *$", text, re.M):
        heading = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", heading).lower()
        name = re.sub(r"[^\w\- ]", "", heading)
        found.add(name.replace(" ", "-"))
    found.update(re.findall(r'<a (?:id|name)="([^"]+)"', text))
    return found


def main():
    root = pathlib.Path(sys.argv[1]).resolve()
    pages = [root / "README.md", root / "CONTRIBUTING.md", *sorted((root / "docs").rglob("*.md")), *sorted((root / "examples").rglob("*.md"))]
    problems, reached, links = [], set(), 0
    for page in pages:
        for target in LINK.findall(without_code(page.read_text(encoding="utf-8"))):
            if re.match(r"[a-z]+:", target):
                continue
            links += 1
            path, _, anchor = target.partition("#")
            to = (page.parent / path).resolve() if path else page
            here = f"{page.relative_to(root)}: {target}"
            if not to.exists():
                problems.append(f"{here}: there is no such file")
            elif anchor and to.suffix == ".md" and anchor not in anchors(to):
                problems.append(f"{here}: no heading of that name")
            if to != page:
                reached.add(to)
    contents = (root / "docs" / "mkdocs.yml").read_text(encoding="utf-8")
    for page in pages:
        name = page.relative_to(root).as_posix()
        if name.startswith("docs/"):
            if page not in reached:
                problems.append(f"{name}: no page leads to it")
            if f" {name.removeprefix('docs/')}\n" not in contents:
                problems.append(f"{name}: not in docs/mkdocs.yml")
    for name in re.findall(r": ([\w/]+\.md)$", contents, re.M):
        if not (root / "docs" / name).exists() and not (root / name).exists():
            problems.append(f"docs/mkdocs.yml: {name} does not exist")
    if problems:
        print("\n".join(problems))
        sys.exit(f"{len(problems)} problems")
    print(f"{len(pages)} pages, {links} links, all there")


main()

#!/usr/bin/env python3
"""check_words.py <root> | --self-test | --sample <seed> <root>

Comments of headers at which a reader with a textbook would stumble: each with its file, line and reason. What a machine can
find stands in RULES; the rest is CONTRIBUTING's section Words. --sample draws ten comments of each room for somebody to read who
hasn't seen the code: at most one in ten may be hard at first sight (2026-11-28: seeds 20261128, 7 and 99)."""
import pathlib
import random
import re
import sys

RULES = (
    ("begins with …: say the whole, editors show a comment alone", r"^…", 0),
    ("people: name the part of the program", r"\b(who|whom|nobody|somebody|anybody|everybody)\b", re.I),
    ("'told': say what was given, left or measured", r"\b(un)?told\b", re.I),
    ("'look': say what is read, computed or checked", r"(?<!-)\b(looks|looked|looking|look (at|for|into|after|around|back|inside))\b", re.I),
    ("the subject is missing", r"^(Of|That of|Those of|The same of)\b[^.;:]*\.?$", 0),
    ("one spelling, -ize", r"\b(?:linear|factor|vector|initial|special|normal|symmetr|optim)is(?:e|ed|es|ing|ation|ations)\b", re.I),
)
BAD = ("… and Δt.", "Whom it touches.", "The scheme told its error.", "Looks at r.", "Of the last move.", "The linearised Ψ.")
GOOD = ("The sum of … and Δt.", "Left-looking, by columns.", "The size of the last move.", "`look(x)` is called once.", "The linearized Ψ.")


def comments(text):
    """(first line, words) of each comment; lines that follow one another are one. Code between backquotes isn't prose."""
    block, first = [], 0
    for number, line in enumerate([*text.splitlines(), ""], 1):
        alone = re.match(r"\s*///?\s?(.*)$", line)
        if alone:
            first = first if block else number
            block.append(alone.group(1).strip())
            continue
        if block:
            yield first, " ".join(block)
            block = []
        behind = re.search(r"[;,{})]\s*//+<?\s?(.*)$", line)
        if behind:
            yield number, behind.group(1).strip()


def faults(text):
    for number, comment in comments(text):
        prose = re.sub(r"`[^`]*`|@t?param \w+|\w+\.hpp", "", comment)
        for reason, pattern, flags in RULES:
            found = re.search(pattern, prose, flags)
            if found:
                yield number, reason, prose[max(0, found.start() - 30) : found.end() + 50]


def sample(seed, root):
    draw = random.Random(seed)
    for room in sorted(path for path in (root / "include" / "phistep").iterdir() if path.is_dir()):
        found = [
            (path.relative_to(root), number, comment)
            for path in sorted(room.rglob("*.hpp"))
            for number, comment in comments(path.read_text())
            if not comment.startswith("namespace")
        ]
        for path, number, comment in draw.sample(found, 10):
            print(f"{path}:{number}: {comment}\n")


def main():
    if sys.argv[1] == "--sample":
        return sample(sys.argv[2], pathlib.Path(sys.argv[3]))
    if sys.argv[1] == "--self-test":
        wrong = [x for x in BAD if not list(faults(f"/// {x}\n"))] + [x for x in GOOD if list(faults(f"int x;  // {x}\n"))]
        print("judged wrongly:", wrong)
        return len(wrong)
    root = pathlib.Path(sys.argv[1])
    found = [
        f"{path.relative_to(root)}:{number}: {reason}: {where}"
        for path in sorted((root / "include").rglob("*.hpp"))
        for number, reason, where in faults(path.read_text())
    ]
    print("\n".join(found))
    return 1 if found else 0


sys.exit(main())

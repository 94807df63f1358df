#!/usr/bin/env python3
"""check_words.py <root> | --self-test

Comments of headers at which a reader with a textbook would stumble: each with its file, line and reason. What a machine can
find stands in RULES; the rest is CONTRIBUTING's section Words."""
import pathlib
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


def main():
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

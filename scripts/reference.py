#!/usr/bin/env python3
"""The reference: every public name, from its docstring.

    reference.py --xml FOLDER [--write] [--site FOLDER]

docs/reference/names.md lists the public names by subject. For each of them this looks up the docstring in Doxygen's XML and the
pages whose code uses it. It fails where
- a listed name doesn't exist, or it, a parameter that its docstring begins to describe, or a field of it has no docstring;
- a listed name is used in no page's code;
- a page's code uses a name of the library that is not listed;
- a signature in docs/reference/signatures.txt is gone, and CHANGELOG.md's first section doesn't name it.
--write renews the table's other columns and the signatures; --site writes the table with links, and a page for each subject in api/: signatures,
defaults, docstrings, examples.
"""
import argparse
import functools
import os
import pathlib
import re
import sys
import xml.etree.ElementTree as ElementTree

ROOT = pathlib.Path(__file__).resolve().parent.parent
UMBRELLAS = ["phistep", "sparse", "krylov", "autodiff", "particles", "fields", "io", "in_place", "preflight", "advise", "battery"]


def plain(element):
    """The text of an element, white space normalized."""
    return re.sub(r"\s+", " ", "".join(element.itertext())).strip() if element is not None else ""


def lead(para):
    """The text of a paragraph up to its first block of code or list."""
    text = para.text or ""
    for child in para:
        if child.tag in ("verbatim", "programlisting", "itemizedlist", "parameterlist", "simplesect"):
            break
        text += "".join(child.itertext()) + (child.tail or "")
    return re.sub(r"\s+", " ", text).strip()


def markdown(element):
    """A docstring as Markdown: paragraphs, code, lists; without its parameters."""
    if element is None:
        return ""
    text = element.text or ""
    for child in element:
        tag = child.tag
        if tag == "para":
            text += "\n\n" + markdown(child) + "\n\n"
        elif tag == "computeroutput":
            text += "`" + plain(child) + "`"
        elif tag in ("verbatim", "preformatted", "programlisting"):
            lines = [plain_code(line) for line in child.iter("codeline")] if tag == "programlisting" else (child.text or "").split("\n")
            text += "\n\n```\n" + "\n".join(lines).strip("\n") + "\n```\n\n"
        elif tag == "itemizedlist":
            items = [markdown(item).strip().replace("\n\n", "\n") for item in child.iter("listitem")]
            text += "\n\n" + "\n".join("- " + item for item in items) + "\n\n"
        elif tag in ("parameterlist", "simplesect", "xrefsect"):
            pass
        else:
            text += markdown(child)
        text += child.tail or ""
    return re.sub(r"\n{3,}", "\n\n", text)


def plain_code(line):
    return "".join(" " if e.tag == "sp" else (e.text or "") for e in line.iter() if e.tag in ("sp", "highlight", "ref"))


class Entry:
    """One declaration: a function, a variable, an alias, or a class with its members."""

    def __init__(self, name, kind, element, header):
        self.name, self.kind, self.element, self.header = name, kind, element, header
        self.members, self.specialised = [], False

    def docstring(self):
        brief = markdown(self.element.find("briefdescription")).strip()
        detail = markdown(self.element.find("detaileddescription")).strip()
        return (brief + "\n\n" + detail).strip()

    def brief(self):
        """The docstring's first sentence: a period after a single capital or an abbreviation ends none."""
        first = plain(self.element.find("briefdescription"))
        detail = self.element.find("detaileddescription")
        if not first and detail is not None and detail.find("para") is not None:
            first = lead(detail.find("para"))
        sentences = re.split(r"(?<![A-Z]\.)(?<!eq\.)(?<!sect\.)(?<!Proc\.)(?<=[.;:]) (?=[A-Z`(])", first)
        short = sentences[0] if len(sentences[0]) > 20 else " ".join(sentences[:2])  # "φ = 1." says little
        return re.sub(r"\. \[\w+\]$", "", short).rstrip(".:;")

    def described(self, kind):
        """[(names, text)] of a parameterlist: param, exception, tparam."""
        found = []
        for parameters in self.element.iter("parameterlist"):
            if parameters.get("kind") == kind:
                for item in parameters.findall("parameteritem"):
                    names = ", ".join(plain(n) for n in item.iter("parametername"))
                    found.append((names, plain(item.find("parameterdescription"))))
        return found

    def section(self, kind):
        return " ".join(plain(s) for s in self.element.iter("simplesect") if s.get("kind") == kind)

    def line(self):
        return self.element.find("location").get("line")

    def signature(self):
        e = self.element
        template = e.find("templateparamlist")
        text = ""
        if template is not None and self.kind in ("function", "concept", "class", "struct"):
            parameters = []
            for p in template.findall("param"):
                default = plain(p.find("defval"))
                declared = plain(p.find("declname"))
                parameter = plain(p.find("type")) + (" " + declared if declared else "")
                parameters.append(parameter + (" = " + default if default else ""))
            if parameters:
                text = "template <" + ", ".join(parameters) + ">\n"
        if self.kind == "function":
            text += (plain(e.find("type")) + " " + self.name).strip() + plain(e.find("argsstring"))
        elif self.kind in ("variable", "typedef"):
            text += plain(e.find("definition")) + " " + plain(e.find("initializer"))
        elif self.kind == "enum":
            text += "enum class " + self.name
        else:
            text += self.kind + " " + self.name
        text = text.replace("phistep::", "").replace("[[nodiscard]] ", "")
        text = re.sub(r" (&+|\*+) ?", r"\1 ", text.replace("< ", "<").replace(" >", ">"))
        return re.sub(r" +", " ", re.sub(r"([&*]) ([,)>])", r"\1\2", text)).rstrip()


def read_entries(xml):
    """name -> its declarations, of the library's namespace; header -> what it says of itself."""
    entries, headers = {}, {}

    def add(entry):
        entries.setdefault(entry.name, []).append(entry)

    for compound in ElementTree.parse(xml / "index.xml").getroot().findall("compound"):
        kind, name = compound.get("kind"), compound.findtext("name")
        if kind == "file":
            definition = ElementTree.parse(xml / f"{compound.get('refid')}.xml").getroot().find("compounddef")
            headers[definition.find("location").get("file")] = Entry(name, kind, definition, name).docstring()
        if kind not in ("namespace", "class", "struct", "concept") or not name.startswith("phistep"):
            continue
        definition = ElementTree.parse(xml / f"{compound.get('refid')}.xml").getroot().find("compounddef")
        if kind == "namespace":
            if name != "phistep":
                continue
            for member in definition.iter("memberdef"):
                if member.get("prot") == "public" and "<" not in member.findtext("name"):
                    header = member.find("location").get("file")
                    add(Entry(member.findtext("name"), member.get("kind"), member, header))
            continue
        short = name.removeprefix("phistep::")
        base = re.sub(r"<.*", "", short).strip()
        if "::" in base or not base:
            continue
        location = definition.find("location")
        entry = Entry(base, kind, definition, location.get("file") if location is not None else "?")
        entry.specialised = "<" in short
        for member in definition.iter("memberdef"):
            if member.get("prot") == "public" and member.get("kind") in ("function", "variable", "enum", "typedef"):
                is_trait = member.get("kind") == "variable" and member.get("static") == "yes"
                if not is_trait:  # what a type says of itself to the library
                    entry.members.append(Entry(member.findtext("name"), member.get("kind"), member, entry.header))
        add(entry)
    return entries, headers


def umbrella_of(header):
    """The first umbrella from which a header is reached."""
    for umbrella in UMBRELLAS:
        if header in reached(f"phistep/{umbrella}.hpp"):
            return umbrella
    return header.removeprefix("phistep/").removesuffix(".hpp")


@functools.cache
def reached(header):
    """A header and all that it includes."""
    todo, seen = [header], {header}
    while todo:
        text = (ROOT / "include" / todo.pop()).read_text(encoding="utf-8")
        for included in re.findall(r'#include "(phistep/[^"]+)"', text):
            if included not in seen:
                seen.add(included)
                todo.append(included)
    return seen


def pages():
    """Page -> the code it shows, in the order of the site."""
    order = re.findall(r"[\w/]+\.md", (ROOT / "docs" / "mkdocs.yml").read_text(encoding="utf-8"))
    found = {}
    for name in order:
        path = ROOT / "docs" / name
        if name == "README.md":
            path = ROOT / "README.md"
        elif name.startswith("examples/"):
            path = ROOT / name
        if path.exists() and "reference" not in path.parts:
            text = path.read_text(encoding="utf-8")
            code = "\n".join(re.findall(r"^ *```(?:cpp|diff)\n(.*?)^ *```", text, re.M | re.S))
            found[path] = re.sub(r'"(?:\\.|[^"\\])*"|//[^\n]*', "", code)
    return found


def users(code, name):
    """The pages whose code uses the library's name, not another of that spelling: std::sqrt, a member, a variable. Where none
    qualifies it, those that let its arguments find it."""
    plain = rf"(?<!std::)(?<!\.)\b{name}\b"
    qualified = rf"\bphistep::(?:\w+::)?{name}\b"
    found = [p for p, text in code.items() if re.search(plain if "using namespace phistep" in text else qualified, text)]
    return found or [p for p, text in code.items() if re.search(plain, text)]


def link(path, start, on_site=False):
    """From a page in the folder `start` of docs/. On the site, what lies beside docs/ lies in it."""
    if on_site and ROOT / "docs" not in path.parents:
        path = ROOT / "docs" / path.relative_to(ROOT)
    return pathlib.Path(os.path.relpath(path, ROOT / "docs" / start)).as_posix()


def title(page):
    return page.relative_to(ROOT).as_posix().removeprefix("docs/").removesuffix(".md").removesuffix("/README").replace("_", " ")


def declarations(entries, name):
    """Without a class's specializations."""
    return [e for e in entries[name] if not e.specialised] or entries[name]


def without_names(entry):
    """Its signature without the names of parameters, which may change."""
    text = entry.signature()
    for name in filter(None, map(plain, entry.element.findall("param/declname"))):
        text = re.sub(rf" ?\b{name}\b(?= ?[,)=])", "", text)
    return re.sub(r"\s+", " ", text)


def signatures(entries, names):
    """A line for each overload, member and enumerator of the public names, sorted."""
    lines = set()
    for name in names:
        for entry in declarations(entries, name):
            lines.add(f"{name}: {without_names(entry)}")
            lines.update(f"{name}::{v.findtext('name')}" for v in entry.element.findall("enumvalue"))
            lines.update(f"{name}::{m.name}: {without_names(m)}" for m in entry.members if m.kind == "variable" or m.docstring())
    return sorted(lines)


def unmentioned(before, now, changelog):
    """A line for each signature that is gone or has changed, and whose name isn't a word of the changelog's first section. For a
    member of a class that stays this is the member's name."""
    section = re.split(r"^## ", changelog, maxsplit=2, flags=re.M)[1]
    stay, found = {line.partition(":")[0] for line in now}, []
    for line in (line for line in before if line not in now):
        owner, *members = re.findall(r"\w+", line.partition(": ")[0])
        name = members[-1] if members and owner in stay else owner
        if not re.search(rf"\b{name}\b", section):
            found.append(f"gone or changed, but CHANGELOG.md's first section doesn't name {name}: {line}")
    return found


def section_of(entries, name, used, said):
    """The section of one name on the site; `said`: what its header says, empty if said already."""
    text = f"\n## `{name}`\n\n"
    found = declarations(entries, name)
    text += f"`#include <phistep/{umbrella_of(found[0].header)}.hpp>` · {found[0].header}\n\n"
    if said:
        text += said + "\n\n"
    seen = set()
    for entry in sorted(found, key=lambda e: e.kind not in ("class", "struct", "enum", "concept")):
        signature = entry.signature()
        if signature in seen:
            continue
        seen.add(signature)
        text += f"```cpp\n{signature}\n```\n\n"
        if entry.docstring():
            text += entry.docstring() + "\n\n"
        text += tail(entry)
        if entry.kind == "enum":
            for value in entry.element.findall("enumvalue"):
                text += f"- `{value.findtext('name')}`: {plain(value.find('briefdescription')) or plain(value.find('detaileddescription'))}\n"
            text += "\n"
        fields = [m for m in entry.members if m.kind == "variable"]
        if fields:
            text += "| field | default | |\n|---|---|---|\n"
            shared = {f.line(): f.docstring() for f in fields if f.docstring()}  # `double a, b;  ///< …` is said of b
            for field in fields:
                default = plain(field.element.find("initializer")).lstrip("= ").replace("|", "\\|")
                what = shared.get(field.line(), "").replace("\n\n", " ").replace("\n", " ").replace("|", "\\|")
                text += f"| `{plain(field.element.find('type'))} {field.name}` | {'`' + default + '`' if default else ''} | {what} |\n"
            text += "\n"
        members = [m for m in entry.members if m.kind == "function" and m.docstring()]
        for member in members:
            text += f"**`{member.signature().splitlines()[-1]}`**\n\n{member.docstring()}\n\n" + tail(member)
    if used:
        text += "Example: " + ", ".join(f"[{title(p)}]({link(p, 'reference/api', True)})" for p in used[:3]) + "\n"
    return text


def tail(entry):
    text = ""
    for names, what in entry.described("param"):
        text += f"- `{names}`: {what}\n"
    if entry.section("return"):
        text += f"- returns {entry.section('return')}\n"
    for names, what in entry.described("exception"):
        text += f"- throws `{names}`: {what}\n"
    return text + ("\n" if text else "")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--xml", required=True, type=pathlib.Path)
    parser.add_argument("--write", action="store_true")
    parser.add_argument("--site", type=pathlib.Path)
    args = parser.parse_args()
    names_page = ROOT / "docs" / "reference" / "names.md"
    (entries, headers), code, problems = read_entries(args.xml), pages(), []

    listed, lines, subject, subjects = [], [], None, {}
    for line in names_page.read_text(encoding="utf-8").splitlines():
        if line.startswith("## "):
            subject = line[3:]
        row = re.match(r"\| `(\w+)` \|", line)
        if row:
            name = row.group(1)
            listed.append(name)
            subjects.setdefault(subject, []).append(name)
            if name not in entries:
                problems.append(f"{name}: no such name in the headers")
                lines.append(line)
                continue
            used = users(code, name)
            documented = [e for e in entries[name] if e.docstring()]
            if not documented:
                problems.append(f"{name}: has no docstring ({entries[name][0].header})")
            if not used:
                problems.append(f"{name}: no page shows an example of it")
            for entry in entries[name]:
                for value in entry.element.findall("enumvalue"):
                    if not plain(value.find("briefdescription")) + plain(value.find("detaileddescription")):
                        problems.append(f"{name}::{value.findtext('name')}: has no docstring ({entry.header})")
                said = {m.line() for m in entry.members if m.docstring()}  # `double a, b;  ///< …` is said of b
                for member in entry.members:
                    if member.kind == "variable" and not member.docstring() and member.line() not in said:
                        problems.append(f"{name}::{member.name}: has no docstring ({entry.header})")
            brief = max(documented, key=lambda e: (not e.specialised, len(e.docstring()))).brief().replace("|", "\\|") if documented else ""
            where = ", ".join(f"[{title(p)}]({link(p, 'reference')})" for p in used[:3])
            line = f"| `{name}` | {brief} | `{umbrella_of(entries[name][0].header)}.hpp` | {where} |"
        lines.append(line)

    for page, text in code.items():
        used = set(re.findall(r"\bphistep::(?:\w+::)?(\w+)", text))
        for name in sorted(used - set(listed)):
            if name in entries:
                problems.append(f"{name}: used in {page.relative_to(ROOT)}, but not in docs/reference/names.md")
    for name in sorted({name for name in listed if listed.count(name) > 1}):
        problems.append(f"{name}: listed twice")

    text = "\n".join(lines) + "\n"
    now, kept = signatures(entries, [name for name in listed if name in entries]), names_page.with_name("signatures.txt")
    before = kept.read_text(encoding="utf-8").splitlines() if kept.exists() else []
    missing = unmentioned(before, now, (ROOT / "CHANGELOG.md").read_text(encoding="utf-8"))
    problems += missing
    for path, new in [(names_page, text), *([] if missing else [(kept, "\n".join(now) + "\n")])]:
        if args.write:
            path.write_text(new, encoding="utf-8")
        elif not path.exists() or new != path.read_text(encoding="utf-8"):
            problems.append(f"{path.relative_to(ROOT)} is out of date: sh scripts/docs.sh --write renews it")
    if args.site:
        (args.site / "api").mkdir(parents=True, exist_ok=True)
        for subject, names in subjects.items():
            slug = re.sub(r"\W+", "_", subject.lower()).strip("_")
            page = f"# {subject}\n\nFrom the docstrings of the headers. [All public names](../names.md)\n"
            told = set()
            for name in names:
                if name in entries:
                    header = entries[name][0].header
                    used = users(code, name)
                    page += section_of(entries, name, used, "" if header in told else headers.get(header, ""))
                    told.add(header)
                    text = text.replace(f"| `{name}` |", f"| [`{name}`](api/{slug}.md#{name.lower()}) |", 1)
            (args.site / "api" / f"{slug}.md").write_text(page, encoding="utf-8")
        text = re.sub(r"\]\(\.\./\.\./(README|examples)", r"](../\1", text)
        (args.site / "names.md").write_text(text, encoding="utf-8")
    if problems:
        print("\n".join(problems), file=sys.stderr)
        sys.exit(f"{len(problems)} problems")
    print(f"{len(listed)} public names, each with a docstring and an example")


if __name__ == "__main__":
    main()

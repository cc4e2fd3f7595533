#!/usr/bin/env python3
"""Comments and documents keep to the rules of CONTRIBUTING.md, "Words".

Comments of C sources, in the rooms of ROOMS: no line beyond COLUMNS, no sentence that begins with one of BEGINNINGS, no
question. Documents, those of PAGES: no line beyond COLUMNS but in a table, no such beginning, a mean sentence of MEAN
words at most and none above LONGEST; code blocks, tables, headings, equations and references are no sentences. Both: no
synonym that the glossary forbids. One line a failure: the file, its line, and the words. A copy with faults put in must show each.

Both lists only grow. `test_words.py --all` reports every room and page.

Quick.
"""
import re
import shutil
import sys
from collections import namedtuple
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
from talus_test import ROOT, Test  # noqa: E402

ROOMS = ("src", "include", "physics", "materials", "tests/unit")
PAGES = ("README.md", "CONTRIBUTING.md", "docs/*.md", "examples/*/README.md", "scripts/bench/README.md",
         "materials/README.md", "physics/README.md", "tests/README.md")
COLUMNS, MEAN, LONGEST = 120, 20, 40
BEGINNINGS = ("what", "it", "they", "that", "so", "the same")
ALL_ROOMS = ROOMS
ALL_PAGES = PAGES

TOKEN = re.compile(r"""/\*.*?\*/|//[^\n]*|"(?:\\.|[^"\\\n])*"|'(?:\\.|[^'\\\n])*'""", re.DOTALL)
BEGINNING = re.compile(rf"(?:^|[.!?]\s+)(?:{'|'.join(BEGINNINGS)})\b(?!['_(])", re.IGNORECASE)
QUESTION = re.compile(r"\w\)?\?(?=\s|$)")
FENCE = re.compile(r"^ *```.*?^ *```$|^\$\$.*?^\$\$$|<!--.*?-->", re.MULTILINE | re.DOTALL)
LEFT_OUT = re.compile(r"^(?:#.*|\s*\|.*|\s*!\[.*|    [^\n]*)$", re.MULTILINE)  # headings, tables, pictures, equations
ITEM = re.compile(r"^\s*(?:[-*]|\d+\.)\s+", re.MULTILINE)
SENTENCE = re.compile(r"(?<![.\s][A-Z]\.)(?<!et al\.)(?<!e\.g\.)(?<!i\.e\.)(?<!cf\.)(?<!vs\.)(?<!Fig\.)(?<!No\.)(?<!Eq\.)"
                      r"(?<=[.!?])[)\"*_]*\s+(?=[A-Z`*\[(\"_\d$-])")
REFERENCE = re.compile(r"doi\.org|doi:10|^Sources?\b|^[A-Z]\. [A-Z]|^\[?[A-Z]\.")

Fault = namedtuple("Fault", "kind path line text")


def glossary(root):
    """Terms by each synonym of the rows of CONTRIBUTING.md's glossary: term, meaning, words not to use."""
    terms = {}
    section = (root / "CONTRIBUTING.md").read_text(encoding="utf-8").partition("## Glossary")[2].partition("\n## ")[0]
    for row in re.findall(r"^\|([^|]*)\|[^|]*\|([^|]*)\|$", section, re.MULTILINE):
        for synonym in re.findall(r"`([^`]+)`", row[1]):
            terms.setdefault(synonym, []).append(row[0].strip())
    return terms


def find_synonyms(kind, path, line, text, forbidden):
    for synonym, terms in forbidden.items():
        if re.search(rf"\b[{synonym[0]}{synonym[0].upper()}]{re.escape(synonym[1:])}\b", text):
            yield Fault(kind, path, line, f"says `{synonym}`, must be {' or '.join(terms)}")


def comments(text):
    """(line, column where it starts, text) of each comment of a C source."""
    for match in TOKEN.finditer(text):
        if match.group().startswith("/"):
            line = text.count("\n", 0, match.start()) + 1
            yield line, match.start() - text.rfind("\n", 0, match.start()) - 1, match.group()


def check_source(path, text, forbidden):
    rows = text.split("\n")
    for line, _, comment in comments(text):
        for number in range(line, line + comment.count("\n") + 1):
            if len(rows[number - 1]) > COLUMNS:
                yield Fault("columns", path, number, f"{len(rows[number - 1])} columns")
        words = re.sub(r"\n\s*\*?", "\n", comment.strip("/* \t\n"))
        for match in BEGINNING.finditer(words):
            at = line + words.count("\n", 0, match.start())
            yield Fault("beginning", path, at, f"begins with {match.group().strip()!r}")
        if QUESTION.search(words):
            yield Fault("question", path, line, "asks")
        yield from find_synonyms("synonym", path, line, re.sub(r"`[^`]*`", "", words), forbidden)


def sentences(text):
    """(line, words) of each sentence of a page."""
    def blank(match):
        return "\n" * match.group().count("\n")

    text = LEFT_OUT.sub("", FENCE.sub(blank, text))
    text = ITEM.sub(lambda match: "\n" * match.group().count("\n") + "\x00", text)
    place = 0
    for paragraph in re.split(r"(\n[ \t]*(?=\n)|\x00)", text):
        start, place = place, place + paragraph.count("\n")
        plain = re.sub(r"\]\([^)]*\)", "]", re.sub(r"`[^`]*`", "`code`", paragraph))
        for sentence in SENTENCE.split(plain):
            words = [word for word in sentence.split() if re.search(r"\w", word)]
            at = start + max(paragraph.count("\n", 0, paragraph.find(" ".join(sentence.split()[:2]))), 0)
            if words and not REFERENCE.search(sentence.strip()):
                yield at + 1, words


def check_page(path, text, forbidden):
    for number, line in enumerate(FENCE.sub(lambda match: "\n" * match.group().count("\n"), text).split("\n"), 1):
        if len(line) > COLUMNS and not LEFT_OUT.match(line):
            yield Fault("columns", path, number, f"{len(line)} columns")
        if "Glossary" not in text:
            yield from find_synonyms("synonym", path, number, re.sub(r"`[^`]*`", "", line), forbidden)
    found = list(sentences(text))
    for line, words in found:
        if words[0][0].isupper() and BEGINNING.match(" ".join(words[:3])):
            yield Fault("beginning", path, line, f"begins with {' '.join(words[:3])!r}")
        if len(words) > LONGEST:
            yield Fault("sentence", path, line, f"{len(words)} words: {' '.join(words[:8])} ...")
    mean = sum(len(words) for _, words in found) / max(len(found), 1)
    if mean > MEAN:
        yield Fault("mean", path, 1, f"{mean:.1f} words a sentence")


def files(root, rooms, pages):
    for room in rooms:
        for path in sorted((root / room).rglob("*.[ch]")):
            yield path, check_source
    for page in pages:
        for path in sorted(root.glob(page)):
            yield path, check_page


def check(root, rooms, pages):
    """All faults below a root."""
    forbidden = glossary(root)
    for path, checker in files(root, rooms, pages):
        yield from checker(str(path.relative_to(root)), path.read_text(encoding="utf-8"), forbidden)


FAULTS = (  # (kind, file of the copy, text that is put in)
    ("columns", "src/base/fault.c", f"int long_line; /* {'x' * COLUMNS} */\n"),
    ("beginning", "src/base/fault.c", "int first; /* what is left */\n"),
    ("beginning", "src/base/fault.c", "/* A row.\n   The same holds for columns. */\n"),
    ("question", "src/base/fault.c", "/* Does it converge? */\n"),
    ("synonym", "src/base/fault.c", "/* velocity after a kick */\n"),
    ("beginning", "docs/fault.md", "A word. It fails.\n"),
    ("columns", "docs/fault.md", "x" * COLUMNS + "y\n"),
    ("sentence", "docs/fault.md", "Word" + "\nword" * LONGEST + ".\n" + "A word.\n" * 9),
    ("mean", "docs/fault.md", ("Word" + "\nword" * MEAN + ".\n") * 3),
    ("synonym", "docs/fault.md", "Velocities after a kick.\n"),
)
FAULTLESS = '/* True where a row is empty. */\nconst char *text = "what is left?"; /* a text, 0: none */\n'


def check_faults(test):
    """Every fault is found in a copy, and only there."""
    for number, (kind, path, text) in enumerate(FAULTS):
        folder = test.folder()
        shutil.copy(ROOT / "CONTRIBUTING.md", folder / "CONTRIBUTING.md")
        for content, expected in ((FAULTLESS if path.endswith(".c") else "A word.\n", 0), (text, 1)):
            (folder / path).parent.mkdir(parents=True, exist_ok=True)
            (folder / path).write_text(content, encoding="utf-8")
            found = {fault.kind for fault in check(folder, ("src/base",), ("docs/*.md",))}
            test.check(f"fault:{number}:{kind}:{expected}", int(found == ({kind} if expected else set())), 1, 1)


def main():
    if "--all" in sys.argv:
        for fault in check(ROOT, ALL_ROOMS, ALL_PAGES):
            print(f"{fault.path}:{fault.line}: {fault.kind}: {fault.text}")
        return
    with Test() as test:
        faults = list(check(ROOT, ROOMS, PAGES))
        for fault in faults:
            print(f"{fault.path}:{fault.line}: {fault.kind}: {fault.text}")
        for kind in ("columns", "beginning", "question", "synonym", "sentence", "mean"):
            test.check(kind, sum(fault.kind == kind for fault in faults), None, 0)
        test.check("glossary", len(glossary(ROOT)), lower=5)
        check_faults(test)


if __name__ == "__main__":
    main()

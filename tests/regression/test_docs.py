#!/usr/bin/env python3
"""The commands and scenes of README.md and docs/ work as they are printed.

Fenced blocks are read in their order, page by page, in a folder that looks like the repository's root:

    sh        commands: a line each, continued by a backslash; `# exit status N` at its end says how it ends, else 0
    console   commands that a test cannot run, and what programs print; left alone
    others    a file, whose first line names it (`# ground.yaml`)

A file that nothing uses, by its name or by that of its folder, is a failure, and so are a link to nowhere and a block without a language. The sources' comments
name nothing that does not exist, and none stands on another one, away from what it describes.
"""
import os
import re
import shlex
import subprocess
import sys
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
from talus_test import ENVIRONMENT, ROOT, TIME_LIMIT, Test  # noqa: E402
import warm_python  # noqa: E402

FENCE = re.compile(r"^```(\S*)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
LINK = re.compile(r"\]\(([^)#:]+)(?:#[^)]*)?\)")
STATUS = re.compile(r"#\s*exit status (\d+)\s*$")
COMMENT = re.compile(r"/\*.*?\*/", re.DOTALL)
PUBLIC = re.compile(r"\b(?:Mpm|MPM_)\w+(?!\w*\.\.\.)")
STACKED = re.compile(r"^/\*(?! ----)(?:(?!\*/).)*\*/\n/\*(?! ----)", re.DOTALL | re.MULTILINE)
NAME = re.compile(r"# (\S+)\s*$")


def pages():
    """README.md, then docs/README.md and the pages that it lists, in its order."""
    index = ROOT / "docs" / "README.md"
    listed = [ROOT / "docs" / name for name in re.findall(r"\]\(([\w-]+\.md)\)", index.read_text(encoding="utf-8"))]
    return [ROOT / "README.md", index] + [page for page in dict.fromkeys(listed) if page.exists()]


def commands(text):
    """The commands of a block with the exit status that each has to end with."""
    for line in re.sub(r"\\\n\s*", " ", text).splitlines():
        if line.strip() and not line.startswith("#"):
            expected = STATUS.search(line)
            yield line.strip(), int(expected.group(1)) if expected else 0


def surroundings(test):
    """A folder with all that the root has, but for results and builds; its environment."""
    folder = test.folder()
    for path in ROOT.iterdir():
        if not path.name.startswith((".", "build", "out")):
            (folder / path.name).symlink_to(path)
    (folder / "build").mkdir()
    for program in test.program.parent.iterdir():
        if program.is_file() and (os.access(program, os.X_OK) or program.name == "cmake_install.cmake"):
            (folder / "build" / program.name).symlink_to(program)
    return folder, {**ENVIRONMENT, "OMPI_MCA_rmaps_base_oversubscribe": "1"}


def run(folder, environment, command):
    """Runs a command; its exit status and what it said."""
    process = subprocess.run(["bash", "-c", command], cwd=folder, env=environment, capture_output=True, text=True,
                             timeout=TIME_LIMIT, check=False)
    return process.returncode, process.stdout + process.stderr


def write_file(folder, page, text):
    """Writes a block that is a file to the name in its first line; returns the name."""
    first, rest = text.split("\n", 1)
    name = NAME.match(first)
    if not name:
        sys.exit(f"{page}: a block that is a file does not begin with its name: {first}")
    if (folder / name.group(1)).exists():
        sys.exit(f"{page}: {name.group(1)} exists already")
    (folder / name.group(1)).write_text(rest, encoding="utf-8")
    return name.group(1)


def read_page(test, page, folder, environment, unused):
    """Writes a page's files and runs its commands; the number of commands."""
    label, text, count = page.relative_to(ROOT), page.read_text(encoding="utf-8"), 0
    for target in LINK.findall(text):
        test.check(f"{label}:link:{target}", int((page.parent / target).exists()), 1, 1)
    for language, block in FENCE.findall(text):
        if language == "console":
            continue
        if not language:
            sys.exit(f"{label}: a block without a language:\n{block}")
        if language != "sh":
            unused -= {name for name in unused if name in block}
            unused.add(write_file(folder, label, block))
            continue
        for command, expected in commands(block):
            start = time.monotonic()
            status, said = run(folder, environment, command)
            print(f"{time.monotonic() - start:6.1f} s  {command}", flush=True)
            if status != expected:
                print(said)
            test.check(f"{label}:{shlex.split(command)[0]}:exit_status", status, expected, expected)
            unused -= {name for name in unused if name in command or str(Path(name).parent) in command.split()}
            count += 1
    return count


def check_comments(test):
    sources = {path: path.read_text(encoding="utf-8") for folder in ("include", "src", "materials", "tests")
               for path in (ROOT / folder).rglob("*.[ch]")}
    known = {name for text in sources.values() for name in PUBLIC.findall(COMMENT.sub("", text))}
    for path, text in sources.items():
        unknown = {name for comment in COMMENT.findall(text) for name in PUBLIC.findall(comment)} - known
        stacked = STACKED.findall(text)
        if unknown or stacked:
            print(f"{path}: no such name {sorted(unknown)}, comments on comments {stacked}")
        test.check(f"{path.relative_to(ROOT)}:comments", len(unknown) + len(stacked), None, 0)


def main():
    with Test() as test:
        check_comments(test)
        folder, environment = surroundings(test)
        unused, count, place = set(), 0, str(test.folder())
        with warm_python.serve(place, ROOT) as python:
            environment |= {"TALUS_PYTHON": python, warm_python.NAME: place}
            for page in pages():
                count += read_page(test, page, folder, environment, unused)
        test.check("commands", count, lower=30)
        for path in (ROOT / "docs").glob("*.md"):
            test.check(f"listed:{path.name}", int(path in pages()), 1, 1)
        for name in sorted(unused):
            test.check(f"{name}:is_used", 0, 1, 1)


if __name__ == "__main__":
    main()

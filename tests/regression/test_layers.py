#!/usr/bin/env python3
"""The sources stand in layers, and what is in them stays small enough to be read.

A folder of src/ includes and uses only the folders before it (LAYERS); include/ stands below all of them; the kernels of
materials/ and physics/ include only talus/point and use nothing of the engine. What a file includes is read from its
text, what it uses from the symbols of its object file beside the program. What a header declares is defined in its
folder. One line a failure: the file, and what is wrong. The same reading of a copy with faults put in must find each of them.

Quick.
"""
import re
import shutil
import subprocess
import sys
from collections import namedtuple
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
from talus_test import ROOT, Test  # noqa: E402

LAYERS = ("base", "options", "files", "io", "maps", "voxels", "geometry", "ground", "point", "grid", "release", "handover", "particles", "selection", "space", "action", "extension", "transfer", "bc", "assembly", "points", "terrain", "volume", "rigid",
          "facets", "contact", "pairs", "loads", "problem", "precondition", "levels", "solve", "query", "scene", "entrainment", "step", "integrators", "schedule", "geostatic", "runout", "observe", "stepmap", "watermap", "sensitivity", "laboratory", "checkpoint", "ensemble", "model", "members", "inverse", "run")
KERNELS = ("materials", "physics")
ENGINE_KERNELS = ("src/point/k0_law.c", "src/point/column_law.c", "src/point/stretch.c")  # compiled like a law, once for each number of directions
GENERATED = re.compile(r"mpm_\w+\.h")
FUNCTION_LINES, FUNCTION_ARGUMENTS, STRUCT_MEMBERS, FILE_LINES, FOLDER_LINES = 60, 7, 20, 600, 4000
NEAR, NEAR_COUNT = 0.9, 3  # of a kind, so many at most have more than this share of their bound
DIMENSION, DIMENSIONS = re.compile(r"dim == [23]"), 40  # comparisons of the dimension in src/
WEIGHTS = r"shape\[0\]|basis->basis"  # of shape functions, which the space alone reads
CALL_CIRCLE = 3  # files that call each other in a circle
SHARE = 1 / 3  # of the .c files of src/: as many may see a header, by whatever way; base/ is what all stand on
# a term by its place or address, a physics by its name; a reason in the solver's memory, a shallow copy of a model
IDENTITY = (r"term\[0\]", r"[!=]= &MpmTerm", r"strcmp\(.*physics", r"solver(\.|->)lost", r"\*second *= \*model")
CALLBACKS = ("HandleError",)  # functions whose arguments are PETSc's

INCLUDE = re.compile(r'^#include "([^"]+)"', re.MULTILINE)
SYMBOL = re.compile(r"^(?:[0-9a-f]+)? +(\w) (\w+)$", re.MULTILINE)
QUOTED = re.compile(r"""/\*.*?\*/|//[^\n]*|"(?:\\.|[^"\\\n])*"|'(?:\\.|[^'\\\n])*'""", re.DOTALL)
BODY = re.compile(r"^(?P<head>(?:[A-Za-z_][^\n]*\n(?:[ \t][^\n]*\n)*))\{\n.*?^\}", re.MULTILINE | re.DOTALL)
STRUCT = re.compile(r"^(?:typedef )?struct(?: \w+)? \{\n(.*?)^\}", re.MULTILINE | re.DOTALL)
DECLARED = re.compile(r"^(?!static)\w[\w *]*?\b(Mpm\w+)\(", re.MULTILINE)

Fault = namedtuple("Fault", "kind path text")


def blank(match):
    """A comment or a literal as blanks of the same lines."""
    return re.sub(r"[^\n]", " ", match.group())


def layer(path):
    """The folder that a path belongs to: one of LAYERS, `include`, `talus/point`, or one of KERNELS."""
    parts = path.split("/")
    if parts[0] == "src":
        return parts[1]
    return "talus/point" if path.startswith("include/talus/point/") else parts[0]


def allowed(user, used):
    """May a file of the folder `user` include one of the folder `used`?"""
    if used == "talus/point":
        return True
    if user == "talus/point":
        return False
    if used == "include":
        return user not in KERNELS
    if user in LAYERS and used in LAYERS:
        return LAYERS.index(used) <= LAYERS.index(user)
    return user == used


def pieces(text, separator):
    """Splits at a separator that stands outside of parentheses and brackets."""
    depth, found = 0, [""]
    for letter in text:
        depth += (letter in "([{") - (letter in ")]}")
        if letter == separator and not depth:
            found.append("")
        else:
            found[-1] += letter
    return [piece for piece in found if piece.strip()]


class Sources:
    """The C files below a root: their texts, what they include, and the headers that each sees."""

    def __init__(self, root):
        self.root = root
        paths = [path for folder in ("src", "include", *KERNELS) for path in sorted((root / folder).rglob("*.[ch]"))]
        self.text = {str(path.relative_to(root)): path.read_text(encoding="utf-8") for path in paths}
        self.plain = {path: QUOTED.sub(blank, text) for path, text in self.text.items()}
        self.includes = {path: self._find_includes(path) for path in self.text}

    def _find_includes(self, path):
        found = []
        for name in INCLUDE.findall(self.text[path]):
            beside = str(Path(path).parent / name)
            places = [place for place in (beside, "src/" + name, "include/" + name) if place in self.text]
            if places or not GENERATED.fullmatch(name):
                found.append(places[0] if places else name)
        return found

    def seen(self, path):
        """All headers that a file sees."""
        found, ways = set(), list(self.includes[path])
        while ways:
            header = ways.pop()
            if header not in found:
                found.add(header)
                ways += self.includes.get(header, ())
        return found


def check_includes(sources):
    for path, includes in sources.includes.items():
        for header in includes:
            if header not in sources.text:
                yield Fault("include", path, f"includes {header}, which does not exist")
            elif not allowed(layer(path), layer(header)):
                yield Fault("include", path, f"includes {header}")
        if path in sources.seen(path):
            yield Fault("circle", path, "includes itself by way of " + " and ".join(
                header for header in includes if path in sources.seen(header)))


def check_shares(sources):
    """Headers that too many files see."""
    files = [path for path in sources.text if path.startswith("src/") and path.endswith(".c")]
    count = {path: 0 for path in sources.text if path.endswith(".h")}
    for path in files:
        for header in sources.seen(path) & count.keys():
            count[header] += 1
    for header, number in sorted(count.items(), key=lambda item: -item[1]):
        if layer(header) in ("base", "include", "talus/point"):
            continue
        if number / len(files) > SHARE:
            yield Fault("share", header, f"is seen by {number} of {len(files)} files, more than {SHARE:.0%}")


def check_identity(sources):
    """Lines that know a term or a physics by what it is and not by a property of it."""
    for path, text in sources.text.items():
        for line in text.splitlines() if path.startswith("src/") else ():
            for pattern in IDENTITY:
                if re.search(pattern, line):
                    yield Fault("identity", path, f"has {line.strip()}")


def sizes(sources):
    """(kind, size, path, name) of files, functions with their arguments, structs and folders of src/."""
    folders = {}
    for path, text in sources.plain.items():
        lines = text.count("\n")
        yield "file", lines, path, "the file"
        if path.startswith("src/"):
            folders[layer(path)] = folders.get(layer(path), 0) + lines
        for match in BODY.finditer(text):
            head = match.group("head")
            called = re.search(r"(\w+)\s*\((.*)\)\s*$", re.sub(r"(?m)^#.*\n", "", head), re.DOTALL)
            if not called:
                continue
            yield "function", match.group().count("\n") + 1, path, called.group(1) + "()"
            if called.group(1) not in CALLBACKS:
                yield "arguments", len(pieces(called.group(2), ",")), path, called.group(1) + "()"
        for match in STRUCT.finditer(text):
            count = sum(len(pieces(member, ",")) for member in pieces(match.group(1), ";"))
            yield "struct", count, path, re.match(r"\s*(\w*)", text[match.end():]).group(1) or "a struct"
    for folder, lines in folders.items():
        yield "folder", lines, f"src/{folder}", "the folder"


def bound(kind):
    return {"folder": FOLDER_LINES, "file": FILE_LINES, "function": FUNCTION_LINES, "arguments": FUNCTION_ARGUMENTS, "struct": STRUCT_MEMBERS}[kind]


def check_sizes(sources):
    for kind, size, path, name in sizes(sources):
        if size > bound(kind):
            unit = {"arguments": "arguments", "struct": "members"}.get(kind, "lines")
            yield Fault(kind, path, f"{name} has {size} {unit}, more than {bound(kind)}")


def print_nearest(sources):
    """The ten of each kind that are nearest to their bound; how many are near, by kind."""
    found = list(sizes(sources))
    near = {}
    for kind in ("file", "function", "struct", "folder"):
        nearest = sorted((entry for entry in found if entry[0] == kind), key=lambda entry: -entry[1] / bound(kind))[:10]
        near[kind] = sum(entry[1] > NEAR * bound(kind) for entry in nearest)
        print(f"nearest to the bound of a {kind}:", ", ".join(
            f"{path}{'' if name.startswith('the ') else ' ' + name} {size} of {bound(kind)}" for _, size, path, name in nearest))
    return near


def read_objects(build):
    """For each source whose object file is in the build tree: the symbols that it defines, and those that it uses."""
    found = {}
    paths = sorted(build.glob("CMakeFiles/*.dir/**/*.o"))
    texts = subprocess.run(["nm", "--extern-only", *paths], capture_output=True, text=True, check=True).stdout.split("\n\n")
    for path, text in zip(paths, texts, strict=True):
        source = str(path.relative_to(build)).split(".dir/", 1)[1][: -len(".o")]
        if source.split("/")[0] not in ("src", *KERNELS) or not (ROOT / source).exists():
            continue
        heading, *lines = text.strip().split("\n")
        if heading != f"{path}:":
            sys.exit(f"nm speaks of {heading} and not of {path}")
        listed = SYMBOL.findall("\n".join(lines))
        defined, used = found.setdefault(source, (set(), set()))
        defined |= {name for kind, name in listed if kind.isupper() and kind != "U"}
        used |= {name for kind, name in listed if kind == "U"}
    return found


def check_symbols(objects):
    home = {name: source for source, (defined, _) in objects.items() for name in defined}
    for source, (_, used) in objects.items():
        kernel = layer(source) in KERNELS or source in ENGINE_KERNELS
        for name in sorted(used & home.keys()):
            if home[name] == source:
                continue
            if kernel or not (allowed(layer(source), layer(home[name])) or layer(home[name]) in KERNELS):
                yield Fault("symbol", source, f"uses {name} of {home[name]}")


def call_circles(objects):
    """Sets of files of the engine that call each other by whatever way (Tarjan's strongly connected components)."""
    home = {name: source for source, (defined, _) in objects.items() for name in defined}
    calls = {source: {home[name] for name in used & home.keys()} - {source} for source, (_, used) in objects.items()}
    number, low, stack, found = {}, {}, [], []

    def visit(file):
        number[file] = low[file] = len(number)
        stack.append(file)
        for other in calls[file]:
            if other not in number:
                visit(other)
            if other in stack:
                low[file] = min(low[file], low[other])
        if low[file] == number[file]:
            place = stack.index(file)
            found.append(stack[place:])
            del stack[place:]

    for file in calls:
        if file not in number:
            visit(file)
    return [circle for circle in found if len(circle) > 1]


def check_calls(objects):
    for circle in call_circles(objects):
        if len(circle) > CALL_CIRCLE:
            yield Fault("calls", circle[0], f"calls in a circle, {len(circle)} files: {' '.join(sorted(circle))}")


def check_homes(sources, objects):
    """What a header declares is defined in its folder."""
    home = {name: source for source, (defined, _) in objects.items() for name in defined}
    for path, text in sources.plain.items():
        if path.startswith("src/") and path.endswith(".h"):
            for name in DECLARED.findall(text):
                if name in home and layer(home[name]) != layer(path):
                    yield Fault("home", path, f"declares {name}, which {home[name]} defines")


def find_faults(sources, objects):
    for check in (check_includes, check_shares, check_sizes, check_identity):
        yield from check(sources)
    yield from check_calls(objects)
    yield from check_symbols(objects)
    yield from check_homes(sources, objects)


def plant(folder, objects):
    """Puts faults into a copy of the sources; the kind and the file of each, and the symbols with one more use."""
    def add(path, text):
        (folder / path).write_text((folder / path).read_text(encoding="utf-8") + text, encoding="utf-8")

    add("src/grid/shape.c", '#include "step/step.h"\n')
    add("materials/j2.c", '#include "point/material.h"\n')
    add("src/space/space.h", '#include "grid/grid.h"\n')
    add("src/files/stl_file.h", '#include "files/hdf5_rows.h"\n')
    add("src/files/hdf5_rows.h", '#include "files/stl_file.h"\n')
    for path in sorted((folder / "src").rglob("*.c")):
        if path.parent.name == "model":
            add(path.relative_to(folder), '#include "precondition/pc_band.h"\n')
    for path in sorted((folder / "src").rglob("*.c")):
        if path.parent.name in ("model", "observe", "scene", "step", "integrators", "schedule", "solve", "contact", "inverse", "laboratory",
                                "sensitivity"):
            add(path.relative_to(folder), '#include "run/planted.h"\n')
    (folder / "src/run/planted.h").write_text("#pragma once\n", encoding="utf-8")
    arguments = ", ".join(f"int a{k}" for k in range(FUNCTION_ARGUMENTS + 1))
    add("src/bc/dirichlet.c", f"\nstatic int Many({arguments})\n{{\n  return a0;\n}}\n")
    add("src/bc/node_frames.c", "\nstatic int Long(void)\n{\n" + "  ;\n" * FUNCTION_LINES + "  return 0;\n}\n")
    add("src/bc/bc.h", "\ntypedef struct {\n" + "  int a, *b;\n" * (STRUCT_MEMBERS // 2 + 1) + "} Large;\n")
    add("src/base/monitor.c", "\n" * FILE_LINES)
    add("src/grid/grid.h", "\nvoid MpmStageBegin(int stage);\n")
    objects = {source: (set(defined), set(used)) for source, (defined, used) in objects.items()}
    objects["src/bc/dirichlet.c"][1].add("MpmStageBegin")
    add("src/bc/constraints.c", "\n" * FOLDER_LINES)
    for k in range(CALL_CIRCLE + 1):
        objects[f"src/run/circle{k}.c"] = ({f"MpmCircle{k}"}, {f"MpmCircle{(k + 1) % (CALL_CIRCLE + 1)}"})
    objects["physics/solid.c"][1].add("MpmRealText")
    for name, line in (("energy", "terms->term[0]"), ("failure", "term == &MpmTermGhost"),
                       ("water_state", 'strcmp(model->scene.physics.name, "solid")'),
                       ("step_begin", "model->solver.lost"), ("step_trial", "*second = *model")):
        add(f"src/step/{name}.c", f"\nstatic int Named = {line};\n")
    return objects, (("include", "src/grid/shape.c"), ("include", "materials/j2.c"), ("circle", "src/files/stl_file.h"),
                     ("circle", "src/files/hdf5_rows.h"), ("share", "src/run/planted.h"), ("share", "src/grid/grid.h"),
                     ("arguments", "src/bc/dirichlet.c"), ("function", "src/bc/node_frames.c"),
                     ("struct", "src/bc/bc.h"), ("file", "src/base/monitor.c"), ("symbol", "src/bc/dirichlet.c"),
                     ("symbol", "physics/solid.c"), ("home", "src/grid/grid.h"),
                     ("folder", "src/bc"), ("calls", "src/run/circle0.c"), ("identity", "src/step/energy.c"),
                     ("identity", "src/step/failure.c"), ("identity", "src/step/water_state.c"),
                     ("identity", "src/step/step_begin.c"), ("identity", "src/step/step_trial.c"))


def main():
    with Test() as test:
        sources, objects = Sources(ROOT), read_objects(test.program.parent)
        compiled = [path for path in sources.text if path.endswith(".c")]
        test.check("files", len(compiled), lower=60)
        test.check("files_without_object", len(set(compiled) - objects.keys()), upper=0)
        faults = list(find_faults(sources, objects))
        for kind, count in print_nearest(sources).items():
            test.check(f"near_{kind}", count, upper=NEAR_COUNT)
        engine = {path: text for path, text in sources.text.items() if path.startswith("src/")}
        test.check("dimensions", sum(len(DIMENSION.findall(text)) for text in engine.values()), upper=DIMENSIONS)
        test.check("weights", sum(len(re.findall(WEIGHTS, text)) for path, text in engine.items() if not path.startswith("src/space/")), upper=0)
        for fault in faults:
            print(f"{fault.path}: {fault.text}")
        for kind in ("include", "circle", "symbol", "home", "share", "function", "arguments", "struct", "file", "folder", "calls",
                     "identity"):
            test.check(f"{kind}_faults", sum(fault.kind == kind for fault in faults), upper=0)

        folder = test.folder()
        for name in ("src", "include", *KERNELS):
            shutil.copytree(ROOT / name, folder / name)
        objects, planted = plant(folder, objects)
        found = {(fault.kind, fault.path) for fault in find_faults(Sources(folder), objects)}
        for kind, path in planted:
            test.check(f"finds_{kind}:{path}", int((kind, path) in found), lower=1)


if __name__ == "__main__":
    main()

#!/usr/bin/env python3
"""Feeds Talus spoilt scenes, options and files, and judges how it takes them.

    fuzz.py build/talus --cases 1000 --seed 7       # 1000 cases from seed 7; the same again gives the same cases
    fuzz.py build/talus --seed 7 --only 123         # one of them

The scenes are those of the examples, with the maps that they make, made coarse and short; what to spoil in them is drawn
from their options and from what the program's own -help says of them, so that a new example or option is fuzzed with no
change here.

A case passes when the program ends within the time limit with status 0 or 3 and finite results, or with status 2, one
line that names an option or the file, and nothing written; and when no number given as NaN or infinity was accepted. A
scene may ask for more work than the limit allows: then the program is asked to stop, by SIGUSR1, and must end its step,
leave a checkpoint and exit within the same time again; the last line counts such cases. A case that fails is kept in a
folder with the command that repeats it.
"""
import argparse
import concurrent.futures
import io
import json
import math
import os
import random
import re
import shlex
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
import time
from collections import Counter
from pathlib import Path

import h5py
import numpy as np
import yaml

ROOT = Path(__file__).resolve().parent.parent
ENVIRONMENT = {**os.environ, "OMP_NUM_THREADS": "1", "OMPI_ALLOW_RUN_AS_ROOT": "1",
               "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1", "ASAN_OPTIONS": "detect_leaks=0"}
# One rank needs no daemon, and no look at a network's hardware: starts ten times as fast.
SESSIONS = "OMPI_MCA_orte_tmpdir_base"
ALONE = {"OMPI_MCA_ess_singleton_isolated": "1", "OMPI_MCA_pml": "ob1"}
CRASHES = ("PETSC ERROR", "MPI_ABORT", "Caught signal", "Sanitizer", "runtime error:", "*** Process received signal",
           "terminate called", "malloc():", "free():", "corrupted")
GUARD = {"mpm_memory_limit": "0.02"}  # GB: a case that is valid but large is refused, and so is short
SLOW = 2.0  # s: an example that has been made coarse must run in less


# ---- scenes ----

def parse_scene(text):
    """The options of a scene, name -> value as text, as PETSc takes them from YAML: names of nested maps joined by _."""
    options = {}

    def take(prefix, value):
        if isinstance(value, dict):
            for key, inner in value.items():
                take(f"{prefix}_{key}" if prefix else key, inner)
        else:
            options[prefix] = value

    take("", yaml.load(text, Loader=yaml.BaseLoader))
    return options


class Option:
    """What the program says of an option."""

    def __init__(self, text):
        words = re.search(r"one of ([^();]+)", text)
        self.words = words[1].strip().split(", ") if words else []
        kind = text[text.rfind(" (") + 2:]
        self.text = text
        self.numeric = not self.words and not re.match(r"text|names|true or false", kind)


def ask_help(program, options):
    """The options of a scene by name, as -help tells them."""
    words = [word for name, value in options.items() for word in ("-" + name, value)]
    with tempfile.TemporaryDirectory(prefix="talus_fuzz_") as folder:  # runs at a time would share sessions, and remove them
        output = subprocess.run([program, *words, "-help"], env={**ENVIRONMENT, **ALONE, SESSIONS: folder}, capture_output=True,
                                text=True, timeout=60, check=False).stdout
    output = re.sub(r"\n {10,}", " ", output)  # lines that go on
    return {name: Option(text) for name, text in re.findall(r"^  -(mpm_\w+) +(.*)$", output, re.MULTILINE)
            if not re.search("_(NAME|BLOCK)_", name)}


class Scene:
    """An example, made coarse: its text, its options, and the options that make it coarse."""

    def __init__(self, path):
        self.lock, self.runs = threading.Lock(), None  # not known yet
        self.name = f"{path.parent.name}/{path.name}"
        self.text = path.read_text(encoding="utf-8")
        self.options = parse_scene(self.text)
        self.source, self.maps = path.parent, []

    def prepare(self, program):
        """Makes it coarse when it is first asked for, and its maps; False where no coarse form of it runs."""
        with self.lock:
            if self.runs is None:
                self.make_maps()
                self.runs = self.shrink(program)
                if not self.runs:
                    print(f"{self.name}: no coarse form of it runs", file=sys.stderr)
        return self.runs

    def make_maps(self):
        """Some examples write maps and tables, into a folder that scenes call out."""
        self.folder = self.source
        if (self.source / "make.py").is_file():
            self.made = tempfile.TemporaryDirectory(prefix="talus_fuzz_")
            self.folder = Path(self.made.name)
            shutil.copytree(self.source, self.folder, dirs_exist_ok=True)
            subprocess.run([sys.executable, self.source / "make.py", self.folder / "out"], capture_output=True, check=False)
            self.maps = sorted(f"out/{name.name}" for name in self.folder.glob("out/*") if name.suffix in (".asc", ".csv"))

    def coarse(self, divisor):
        """Options of a coarse and short form: cells divided, one or two points a cell, two steps."""
        if "mpm_grid_cells" not in self.options:  # a laboratory's
            return {"mpm_output_prefix": "case", "mpm_point_steps": "2"}
        cells = [int(n) for n in self.options["mpm_grid_cells"].split(",")]
        change = {"mpm_grid_cells": ",".join(str(max(n // divisor, 1)) for n in cells), "mpm_output_prefix": "case"}
        if self.options.get("mpm_output_every") == "0":
            change["mpm_output_every"] = "1"
        if "mpm_time_step" in self.options:
            change["mpm_time_end"] = repr(2.0 * float(self.options["mpm_time_step"]))
        elif "mpm_time_end" in self.options:  # explicit steps may choose their length
            change["mpm_time_end"] = repr(0.02 * float(self.options["mpm_time_end"]))
        for name, value in self.options.items():
            if name.endswith("_points_per_cell"):
                change[name] = ",".join("2" for _ in value.split(","))
            if name.endswith("_nearest"):
                change[name] = "1"
        return change

    def shrink(self, program):
        """Finds the coarsest form that runs. False where there is none."""
        for divisor in (16, 12, 10, 8, 5, 4, 3, 2, 1):
            change = self.coarse(divisor)
            with tempfile.TemporaryDirectory(prefix="talus_fuzz_") as folder:
                shutil.copytree(self.folder, folder, dirs_exist_ok=True)
                Path(folder, "scene.yaml").write_text(flat_yaml({**self.options, **change}), encoding="utf-8")
                begin = time.monotonic()
                try:
                    status = subprocess.run([program, "-options_file", "scene.yaml", "-mpm_quiet"], cwd=folder,
                                            env={**ENVIRONMENT, **ALONE, SESSIONS: folder}, capture_output=True, timeout=20.0 * SLOW,
                                            check=False).returncode
                except subprocess.TimeoutExpired:
                    return False
                if status == 0:
                    self.options.update(change)
                    self.overrides = change
                    self.help = ask_help(program, self.options)
                    self.take_points(program, Path(folder, "case.h5"))
                    return time.monotonic() - begin < SLOW
        return False

    def take_points(self, program, results):
        """The points of the coarse run as a file that a body can be read from, where the program does that."""
        self.point_file, body = None, self.options.get("mpm_bodies", "").split(",")[0]
        from_file = ask_help(program, {**self.options, f"mpm_body_{body}_region": "file"}) if body and results.exists() else ()
        if f"mpm_body_{body}_file" in from_file:
            self.body, self.point_file = body, results.read_bytes()
            with h5py.File(results, "r") as file:
                group = file["points"][sorted(file["points"])[0]]
                self.points = np.column_stack([group["position"][()], group["volume"][()]])


def quoted(text):
    """A double-quoted YAML scalar."""
    return json.dumps(text, ensure_ascii=False)


def flat_yaml(options):
    pairs = options.items() if isinstance(options, dict) else options
    return "".join(f"{name if re.fullmatch(r'[A-Za-z_]+[A-Za-z0-9_]*', name) else quoted(name)}: {quoted(value)}\n"
                   for name, value in pairs)


# ---- what is done to them ----

NOT_FINITE = ("nan", "NaN", "-nan", "nan(7)", "inf", "-inf", "Infinity", "1e400", "-1e999")
NUMBERS = ("0", "-0", "-1", "1", "1e-320", "1e-300", "1e300", "-1e300", "1e30", "1e-30", "1e10", "-1e10", "2147483647",
           "2147483648", "-2147483648", "4294967297", "9223372036854775808", "1000000007", "0x10", "1e", "e5", "1.2.3",
           "--1", "+-1", "1 2", "\uff11\uff12", "\u00bd", "1 MPa", "1e5m", "1d3", "1_000", "0.5", "1.5", "-0.3", "7")
WORDS = ("", " ", ",", ",,,", ":", "-", "--", "true", "false", "yes", "null", "~", "none", "auto", "off", "all", "box",
         "file", "sphere", "polygon", "x", "y,x", "x,x", "p", "-help", "-mpm_dim", "$(id)", "`id`", "%s%s%n", "..", "/",
         "/dev/null", "/proc/self/mem", "NAME", "a b", "a\tb", "a\nb", "a\rb", "\x1b[31m", "\x7f", "\u0085", "\u2028",
         "\u00fc", "\u4f60\u597d", "\U0001f4a5", "\ufeff", "\"", "'", "\\", "#", "# no", "&a", "*a", "!!int 3", "{", "}",
         "[1, 2]", "{a: 1}", "|", ">", "%", "@", "x" * 300, "x" * 5000, ",".join("a%d" % i for i in range(400)),
         ",".join("1" for _ in range(5000)), "1e" + "9" * 300, "0" * 1000 + "1", "9" * 1000)
PETSC = ("snes_rtol", "snes_max_it", "ksp_rtol", "ksp_max_it", "ksp_type", "pc_type", "snes_type", "snes_atol",
         "pc_factor_mat_solver_type", "ksp_gmres_restart", "snes_linesearch_type")
STEPS = re.compile(r"mpm_time_(step|end|step_min|step_max)$")


class Case:
    """A scene while it is being spoilt, and then what is run."""

    def __init__(self, seed, number, scenes, program):
        self.random = random.Random(f"{seed}:{number}")
        self.seed, self.number = seed, number
        self.scene = next((scene for scene in self.random.sample(scenes, len(scenes)) if scene.prepare(program)), None)
        if not self.scene:
            sys.exit("fuzz.py: no example runs")
        self.pairs = [list(pair) for pair in self.scene.options.items()]
        self.arguments, self.files, self.raw, self.notes = [], {}, None, []
        self.wrong_points = False
        self.ranks = 2 if self.random.random() < 0.04 else 1
        files = spoil_map if self.scene.maps else spoil_points if self.scene.point_file else spoil_options
        kinds = (spoil_options, spoil_finite, spoil_text, spoil_command, files)
        self.random.choices(kinds, (0.60, 0.06, 0.17, 0.10, 0.07))[0](self)
        if self.raw is None:
            self.write()

    def write(self):
        """The scene as a file of one of the forms that the program reads."""
        simple = all(re.fullmatch(r"[\w.,:+/-]+", value) and not value.startswith("-") for _, value in self.pairs)
        if simple and self.random.random() < 0.2:
            self.raw = "".join(f"-{name} {value}\n" for name, value in self.pairs).encode()
            self.file = "scene.opts"
        else:
            self.raw = flat_yaml(self.pairs).encode("utf-8", "surrogatepass")
            self.file = "scene.yaml"

    file = "scene.yaml"

    def note(self, text):
        self.notes.append(text[:200])

    def numeric(self, name):
        """Does the option hold numbers?"""
        return name in self.scene.help and self.scene.help[name].numeric

    def not_finite(self):
        """Names of the numeric options whose last value is not finite."""
        last = dict(map(tuple, self.pairs))
        return {name for name, value in last.items() if self.numeric(name) and name not in GUARD and
                any(part.strip() in NOT_FINITE for part in re.split("[,:]", value))}


def hostile_number(case, name, old):
    """A number that may be anything, but does not ask for a long run that would be valid."""
    dice = case.random.random()
    if dice < 0.1:
        return case.random.choice(NOT_FINITE)
    try:
        value = float(old)
    except ValueError:
        value = 1.0
    if dice < 0.75 and not STEPS.match(name):
        scale = case.random.choice((-1.0, 0.0, 0.5, 0.9, 1.1, 2.0, 3.0, 1e-15, 1e-6, 1e-3, 0.03, 30.0, 1e3, 1e6, 1e15, 1e100))
        value *= scale
        integer = re.fullmatch(r"-?\d+", old) and abs(value) < 1e18
        return str(int(value)) if integer else repr(value)
    return case.random.choice(NUMBERS)


def change_value(case, pair):
    """Spoils an option's value, or one number of its list."""
    name, old = pair
    choice, option = case.random, case.scene.help.get(name)
    parts = re.split("([,:])", old)
    dice = choice.random()
    if option and option.words and dice < 0.85:
        pair[1] = choice.choice(option.words)
    elif option and "true or false" in option.text and dice < 0.85:
        pair[1] = choice.choice(("true", "false"))
    elif name.endswith("_prefix"):  # no word that leads out of the case's folder
        pair[1] = choice.choice([word for word in WORDS + NUMBERS if not word.startswith("/")])
    elif case.numeric(name) and dice < 0.8:
        at = choice.randrange(0, len(parts), 2)
        parts[at] = hostile_number(case, name, parts[at])
        pair[1] = "".join(parts)
    elif len(parts) > 1 and dice < 0.85:
        at = choice.randrange(0, len(parts), 2)
        pair[1] = ",".join(choice.choice((parts[:at:2] + parts[at + 2::2], parts[::2] + parts[at:at + 1],
                                          parts[::2][::-1])))
    else:
        pair[1] = choice.choice(WORDS + NUMBERS)
    case.note(f"{name}: {old!r} -> {pair[1]!r}")


def drop_option(case, pair):
    case.pairs.remove(pair)
    case.note(f"{pair[0]} dropped")


def add_option(case, _pair):
    """One of the options that the program knows for this scene, with a value of its kind or any."""
    name = case.random.choice(sorted(case.scene.help))
    known = re.search(r"default ([^;()]*)\)?$", case.scene.help[name].text)
    pair = [name, known[1] if known else "1"]
    change_value(case, pair)
    case.pairs.append(pair)


def twice(case, pair):
    """An option given twice, the second time spoilt."""
    again = list(pair)
    case.pairs.append(again)
    change_value(case, again)


def misspell(case, pair):
    at = case.random.randrange(len(pair[0]))
    old = pair[0]
    pair[0] = case.random.choice((old[:at] + old[at + 1:], old[:at] + "_" + old[at:], old[:at] + "Q" + old[at + 1:],
                                  old.upper(), old + "_" + "y" * 300, old + "\u00e9", "mpm_" + old, old[4:], old + "_"))
    case.note(f"{old} -> {pair[0]}")


def rename_block(case, pair):
    """A block that is called otherwise in one place, or like another one."""
    names = [p for p in case.pairs if re.fullmatch(r"mpm_(materials|bodies|bcs|loads|tracks|stages|\w+s)", p[0])]
    if not names:
        return change_value(case, pair)
    pair = case.random.choice(names)
    old, first = pair[1], pair[1].split(",")[0]
    pair[1] = case.random.choice((old + ",other", "other", old + "," + first, old.upper(), first + "_1," + old,
                                  old.replace(",", ";"), first, old + ",", "," + old, "2", "grid", "x" * 400))
    return case.note(f"{pair[0]}: {old!r} -> {pair[1][:80]!r}")


def swap(case, pair):
    other = case.random.choice(case.pairs)
    if not (pair[0] + other[0]).endswith("_prefix"):
        pair[1], other[1] = other[1], pair[1]
    case.note(f"values of {pair[0]} and {other[0]} swapped")


def mix(case, _pair):
    """Options of another example besides."""
    names = sorted(case.scene.help)
    prefix = "_".join(case.random.choice(names).split("_")[:2])
    for name in names:
        if name.startswith(prefix) and case.random.random() < 0.5:
            pair = [name, "1"]
            change_value(case, pair)
            case.pairs.append(pair)


def many(case, _pair):
    """More options than anybody gives."""
    count = case.random.choice((100, 500, 1000))
    kind = case.random.choice(("mpm_unknown_{}", "mpm_body_{}_region", "user_{}"))
    case.pairs += [[kind.format(i), "box"] for i in range(count)]
    case.note(f"{count} options {kind}")


def spoil_finite(case):
    """One number that is not finite, and nothing else."""
    name = case.random.choice(sorted(name for name in case.scene.help if case.numeric(name) and name not in GUARD))
    case.pairs.append([name, case.random.choice(NOT_FINITE)])
    case.note(f"{name}: {case.pairs[-1][1]}")


def spoil_options(case):
    kinds = (change_value, drop_option, add_option, twice, misspell, rename_block, swap, mix, many)
    for _ in range(case.random.choices((1, 2, 4, 8), (0.6, 0.25, 0.1, 0.05))[0]):
        if case.pairs:
            case.random.choices(kinds, (50, 5, 26, 5, 4, 4, 3, 2, 1))[0](case, case.random.choice(case.pairs))


# ---- text ----

def insert(case, text, piece):
    at = case.random.randrange(len(text) + 1)
    return text[:at] + piece + text[at:]


def spoil_lines(case, text):
    """Lines that are lost, doubled, moved or indented otherwise."""
    lines = text.splitlines(keepends=True)
    at = case.random.randrange(len(lines))
    kind = case.random.choice(("drop", "double", "tab", "indent", "shuffle", "dedent", "bare", "list"))
    if kind == "drop":
        del lines[at]
    elif kind == "double":
        lines.insert(case.random.randrange(len(lines)), lines[at])
    elif kind == "tab":
        lines[at] = "\t" + lines[at].lstrip()
    elif kind == "indent":
        lines[at] = " " * case.random.randrange(1, 9) + lines[at]
    elif kind == "dedent":
        lines[at] = lines[at].lstrip()
    elif kind == "bare":
        lines[at] = lines[at].split(":")[0] + "\n"
    elif kind == "list":
        lines[at] = "- " + lines[at].lstrip()
    else:
        case.random.shuffle(lines)
    case.note(f"lines: {kind} {at + 1}")
    return "".join(lines)


def spoil_bytes(case, text):
    """Bytes that are lost or changed."""
    data = bytearray(text.encode())
    for _ in range(case.random.choice((1, 3, 10, 100))):
        at = case.random.randrange(len(data))
        data[at:at + case.random.randrange(3)] = bytes(case.random.choices(range(256), k=case.random.randrange(4)))
        if not data:
            break
    case.note("bytes changed")
    return bytes(data)


PIECES = ("\t", "\0", "\x01", "\ufeff", "\r\n", "---\n", "...\n", "&a", "*a ", "<<: *a\n", "!!binary ", "|\n", ">\n", "? ",
          "- ", "{", "}", "[", "]", "\"", "'", "#", "%YAML 1.1\n", "\u2028", ": ", "mpm:\n", "mpm: 3\n", "{a: {b: {c: 1}}}",
          "a: &x [*x]\n", "? {a: b}\n: c\n", "[[[]]]: 1\n", "$prefix_push: a_\n", "mpm_prefix_push: b_\n",
          "prefix_push: c_\n", "options_file: scene.yaml\n", "options_file_yaml: scene.yaml\n", "help:\n", "version:\n")


def nested(case, _text):
    depth = case.random.choice((10, 100, 1000, 20000))
    case.note(f"nested {depth} deep")
    if case.random.random() < 0.5:
        return "mpm: " + "{a: " * depth + "1" + "}" * depth + "\n"
    return "".join(" " * i + "a:\n" for i in range(min(depth, 1000))) + " " * depth + "b: 1\n"


def spoil_text(case):
    """The example's own text, spoilt, with the options that make it coarse on the command line."""
    text, choice = case.scene.text, case.random
    kind = choice.choice(("lines", "bytes", "piece", "cut", "nested", "garbage", "empty", "long", "end", "twice"))
    if kind == "lines":
        text = spoil_lines(case, text)
    elif kind == "bytes":
        text = spoil_bytes(case, text)
    elif kind == "piece":
        for _ in range(choice.choice((1, 1, 3))):
            piece = choice.choice(PIECES)
            text = insert(case, text, piece)
            case.note(f"inserted {piece!r}")
    elif kind == "cut":
        text = text[:choice.randrange(len(text))]
        case.note(f"cut after {len(text)}")
    elif kind == "nested":
        text = nested(case, text)
    elif kind == "garbage":
        text = bytes(choice.choices(range(256), k=choice.choice((1, 10, 1000, 20000))))
        case.note("binary garbage")
    elif kind == "empty":
        text = choice.choice(("", "\n", "\0", "---", "#", "mpm:", "mpm: {}", "[]", "mpm: []", "{}", "- mpm", "\ufeff"))
        case.note(f"nothing but {text!r}")
    elif kind == "long":
        text += choice.choice(("mpm_title: ", "x" * 600 + ": ", "# ")) + "y" * choice.choice((1000, 100000)) + "\n"
        case.note("long line")
    elif kind == "end":
        text = text.replace("\n", choice.choice(("\r\n", "\r", "\n\n", "\n\t\n", "\x85")))
        case.note("other line ends")
    else:
        text += text
        case.note("the text twice")
    case.raw = text if isinstance(text, bytes) else text.encode("utf-8", "surrogatepass")
    case.file = choice.choices(("scene.yaml", "scene.opts", "scene.yml", "scene"), (85, 5, 5, 5))[0]
    case.arguments = [word for name, value in case.scene.overrides.items() for word in ("-" + name, value)]
    case.pairs = []


# ---- command line ----

def spoil_command(case):
    """A sound scene and a command line that is not."""
    for _ in range(case.random.choice((1, 1, 2, 4))):
        kind = case.random.choice(("ours", "bare", "petsc", "file", "odd"))
        if kind == "ours":
            pair = list(case.random.choice(case.pairs))
            change_value(case, pair)
            case.arguments += ["-" + pair[0], pair[1].replace("\0", "")]
            case.pairs.append(pair)  # so that what was given last is known
        elif kind == "bare":
            name = case.random.choice(sorted(case.scene.help))
            case.arguments.append(case.random.choice(("-", "--", "-mpm_", "")) + name)
        elif kind == "petsc":
            word = case.random.choice(WORDS[:20] + NUMBERS + NOT_FINITE)
            case.arguments += ["-" + case.random.choice(PETSC), word]
        elif kind == "file":
            name = case.random.choice(("", "nowhere.yaml", ".", "/", "scene.yaml", "/dev/null", "x" * 300, "/etc/shadow"))
            case.arguments += [case.random.choice(("-options_file", "-options_file_yaml"))] + [name] * (name != "")
        else:
            case.arguments += case.random.choice((["word"], [""], ["-"], ["--"], ["-1"], ["\u00e9"], ["-mpm"], ["-mpm_"],
                                                  ["-x" * 400], ["-options_string_yaml", "a: ["], ["-prefix_push", "a_"],
                                                  ["-prefix_pop"], ["-options_left"], ["=", "-mpm_dim=3"]))
    case.note("command line: " + shlex.join(case.arguments)[:150])
    if case.arguments and case.arguments[-1].startswith("-") and case.random.random() < 0.2:
        case.arguments.append("-mpm_quiet")


# ---- files of points ----

def spoil_table(case):
    """A CSV file of points with something wrong."""
    names = ["x", "y", "z"][:case.scene.points.shape[1] - 1] + ["volume"]
    rows = [names] + [[repr(float(value)) for value in row] for row in case.scene.points]
    choice, kind = case.random, case.random.choice(("number", "number", "name", "row", "cut", "bytes", "column", "good"))
    at, column = choice.randrange(1, len(rows)), choice.randrange(len(names))
    if kind == "number":
        rows[at][column] = choice.choice(NOT_FINITE + NUMBERS + WORDS[:30])
        case.wrong_points = rows[at][column] in NOT_FINITE
    elif kind == "name":
        rows[0][column] = choice.choice(("", "x", "volume", "F", "stress_xx", "mass", "id", "material", "\u00fc", "x" * 5000))
    elif kind == "row":
        rows[at] = choice.choice(([], rows[at] * 2, rows[at][:-1], rows[at] + [""], ["#"], rows[0]))
    elif kind == "column":
        for row, value in zip(rows, [choice.choice(("mass", "stress_xx", "F_xx", "half_length_x", "material"))]
                              + [choice.choice(NUMBERS[:12] + NOT_FINITE[:2]) for _ in rows[1:]]):
            row.append(value)
    data = "\n".join(",".join(row) for row in rows).encode("utf-8", "surrogatepass")
    if kind == "cut":
        data = data[:choice.choice((0, 1, 5, choice.randrange(len(data))))]
    elif kind == "bytes":
        data = spoil_bytes(case, data.decode())
    case.note(f"points.csv: {kind} {rows[min(at, len(rows) - 1)]}")
    return data


def spoil_datasets(case):
    """A file of results with something wrong in it."""
    choice, kind = case.random, case.random.choice(("bytes", "cut", "value", "shape", "drop", "type", "group", "good"))
    data = bytearray(case.scene.point_file)
    if kind == "cut":
        data = data[:choice.choice((0, 8, 100, choice.randrange(len(data))))]
    elif kind == "bytes":
        for _ in range(choice.choice((1, 10, 200))):
            data[choice.randrange(choice.choice((200, 5000, len(data))))] = choice.randrange(256)
    elif kind != "good":
        buffer = io.BytesIO(bytes(data))
        with h5py.File(buffer, "r+") as file:
            group = file["points"][sorted(file["points"])[-1]]
            name = choice.choice(sorted(group))
            case.note(f"dataset {name}")
            spoil_dataset(case, group, name, kind)
        data = buffer.getvalue()
    case.note(f"points.h5: {kind}")
    return bytes(data)


def spoil_dataset(case, group, name, kind):
    """One dataset of a group, replaced."""
    values = group[name][()]
    del group[name]
    if kind == "value":
        values = values.astype(float)
        values.flat[case.random.randrange(values.size)] = value = case.random.choice((math.nan, math.inf, -1.0, 0.0, 1e300))
        case.wrong_points = not math.isfinite(value) and name in ("position", "volume", "F", "stress", "mass")
        group[name] = values
    elif kind == "shape":
        group[name] = case.random.choice((values[:-1], values.reshape(-1)[:1], values[:0], values[..., None], 3.0))
    elif kind == "type":
        group[name] = case.random.choice(("text", values.astype("S8"), values.astype(complex), values.astype("i1")))
    elif kind == "group":
        group.create_group(name)


def spoil_points(case):
    """A body that is read from a file."""
    prefix = f"mpm_body_{case.scene.body}_"
    gone = [prefix + name for name in ("lower", "upper", "points_per_cell", "center", "radius", "vertices")]
    name = case.random.choice(("points.csv", "points.h5"))
    case.pairs = [pair for pair in case.pairs if pair[0] not in gone and pair[0] != prefix + "region"]
    case.pairs += [[prefix + "region", "file"], [prefix + "file", name]]
    case.files[name] = spoil_table(case) if name == "points.csv" else spoil_datasets(case)
    if case.random.random() < 0.1:
        case.wrong_points, case.pairs[-1][1] = False, case.random.choice(("nowhere.csv", ".", "scene.yaml", "", "/dev/null"))


def spoil_map(case):
    """A map or a table of a scene with something wrong in it."""
    choice, name = case.random, case.random.choice(case.scene.maps)
    text = (case.scene.folder / name).read_text(encoding="utf-8")
    kind = choice.choice(("number", "number", "head", "head", "row", "cut", "bytes"))
    lines = [line.split() if name.endswith(".asc") else line.split(",") for line in text.splitlines()]
    at = choice.randrange(6) if kind == "head" and len(lines) > 6 else choice.randrange(len(lines))
    if kind in ("number", "head"):
        lines[at][choice.randrange(len(lines[at]))] = choice.choice(NOT_FINITE + NUMBERS + WORDS[:30])
    elif kind == "row":
        lines[at] = choice.choice(([], lines[at] * 2, lines[at][:-1], ["#"], lines[0]))
    data = "\n".join((" " if name.endswith(".asc") else ",").join(line) for line in lines).encode("utf-8", "surrogatepass")
    if kind == "cut":
        data = data[:choice.choice((0, 1, 5, choice.randrange(len(data))))]
    elif kind == "bytes":
        data = spoil_bytes(case, text)
    case.note(f"{name}: {kind} {lines[at][:3] if kind == 'head' else ''}")
    case.files[name] = data


# ---- judging ----

def command_of(case, program):
    command = ["mpiexec", "--oversubscribe", "-n", str(case.ranks)] if case.ranks > 1 else []
    guard = [word for name, value in GUARD.items() for word in ("-" + name, value)]
    return [*command, str(program), "-options_file", case.file, *guard, *case.arguments]


def wait(process, seconds):
    """The exit status, or None where there is none within this time."""
    try:
        return process.wait(timeout=seconds)
    except subprocess.TimeoutExpired:
        return None


class Outcome:
    """How a case ended: status (None: not when asked to, either), whether it was asked, output, files left behind."""

    def __init__(self, case, program, folder, limits):
        self.folder, kept = folder, set(os.listdir(folder))
        sessions = tempfile.mkdtemp(prefix="s", dir=limits.place)  # cases at a time would share it, and remove it
        environment = {**ENVIRONMENT, SESSIONS: sessions, **(ALONE if case.ranks == 1 else {})}
        command = ["/bin/sh", "-c", f'ulimit -v {limits.memory}; ulimit -c 0; exec "$@"', "sh", *command_of(case, program)]
        if limits.memory == 0:
            command = command[4:]
        with open(folder / ".out", "wb") as out, open(folder / ".err", "wb") as err:
            process = subprocess.Popen(command, cwd=folder, env=environment, stdin=subprocess.DEVNULL, stdout=out,
                                       stderr=err, start_new_session=True)
            self.status, self.asked = wait(process, limits.time), False
            if self.status is None:
                self.asked = True
                process.send_signal(signal.SIGUSR1)
                self.status = wait(process, limits.time)
            if self.status is None:
                os.killpg(process.pid, signal.SIGKILL)
                process.wait()
        shutil.rmtree(sessions, ignore_errors=True)
        self.output, self.errors = ((folder / name).read_text(encoding="utf-8", errors="replace")
                                    for name in (".out", ".err"))
        self.written = sorted(set(os.listdir(folder)) - kept - {".out", ".err"})


def known_words(case):
    """What an error message may name."""
    names = {name.lower() for name in case.scene.help} | {str(name).lower() for name, _ in case.pairs}
    names |= {word.lstrip("-").lower() for word in case.arguments if word.startswith("-")}
    names |= {word.lstrip("-").lower() for word in case.raw.decode("utf-8", "replace").split()}
    return names | {"command", "options_file", "options_file_yaml", *PETSC, *GUARD}


def is_known(case, name):
    """Long names are cut off in a line; of a file that is not the case's, no word is known."""
    words = known_words(case)
    return name in words or "/etc/shadow" in case.arguments or (len(name) >= 200 and any(name in word for word in words))


def refusal_faults(case, outcome):
    """Of a run with status 2."""
    lines = [line for line in outcome.errors.split("\n") if line.strip()]
    told = [line for line in lines if line.startswith("talus: error:")]
    if len(told) != 1:
        yield f"{len(told)} lines of error"
    elif case.ranks == 1 and len(lines) > 1:  # mpiexec adds lines of its own
        yield "more than one line"
    for line in told[:1]:
        option = re.match(r"talus: error: (?:-+|(?=command line))([^\s:]+)", line)
        if not option:
            yield "the line does not start with an option's name"
        elif not re.match(r"mpm_", option[1], re.IGNORECASE) and not is_known(case, option[1].lower()):
            yield f"the line names -{option[1]}, which nobody gave"
        if re.search(r"[\x00-\x1f\x7f]", line) or len(line) > 1000:
            yield "the line is not fit for a terminal"
    if outcome.written:
        yield "wrote " + ", ".join(outcome.written)


def result_faults(outcome):
    """Of a run with status 0 or 3: are the results there and finite?"""
    summaries = [name for name in outcome.written if name.endswith("_summary.json")]
    if not summaries:
        return (yield "no summary")
    summary = json.loads((outcome.folder / summaries[0]).read_text(encoding="utf-8", errors="replace"), strict=False)
    stopped = outcome.asked and summary["status"] == "interrupted"
    if (stopped or summary["status"] == "completed") != (outcome.status == 0):
        yield f"status {outcome.status}, summary: {summary['status']}"
    if outcome.status == 3 and "gave up" not in outcome.errors:
        yield "gave up without a word"
    for name in outcome.written:
        if name.endswith("_history.csv") and re.search(r"\b(nan|inf)\b", (outcome.folder / name).read_text().lower()):
            yield f"not finite: {name}"
        if name.endswith(".h5") and (wrong := hdf5_fault(outcome.folder / name)):
            yield wrong


def hdf5_fault(path):
    """The first dataset of a result file that holds a number which is not finite; None where there is none."""
    found = []
    with h5py.File(path, "r") as file:
        file.visititems(lambda name, item: found.append(name) if isinstance(item, h5py.Dataset) and
                        item.dtype.kind == "f" and not np.isfinite(item[()]).all() else None)
    return f"not finite: {found[0]}" if found else None


def faults(case, outcome):
    """What is wrong with how the program took the case."""
    everything = outcome.output + outcome.errors
    if outcome.status is None:
        yield "does not end in time, nor when asked to"
        return
    crash = [word for word in CRASHES if word in everything]
    if crash or outcome.status not in (0, 2, 3):
        yield f"crash: status {outcome.status} {' '.join(crash)}"
    elif outcome.status == 2:
        yield from refusal_faults(case, outcome)
    elif not asked_for_help(case, everything):
        yield from result_faults(outcome)
        if case.wrong_points:
            yield "accepted points that are not finite"
        for name in sorted(case.not_finite()):
            yield f"accepted a number that is not finite for -{name}"


def asked_for_help(case, output):
    """A scene may ask for help or the version: then there are no results."""
    words = case.raw + " ".join(case.arguments).encode("utf-8", "replace")
    return (b"help" in words or b"version" in words) and ("-mpm_" in output or "Release" in output)


# ---- running ----

def run_case(number, arguments, scenes):
    """One case: its faults, its status."""
    case = Case(arguments.seed, number, scenes, arguments.program)
    folder = Path(tempfile.mkdtemp(prefix=f"{number}_", dir=arguments.place))
    for name in os.listdir(case.scene.folder):
        if name.endswith((".csv", ".h5")) and name != "reference.csv":
            shutil.copy(case.scene.folder / name, folder)
    if case.scene.maps:
        shutil.copytree(case.scene.folder / "out", folder / "out")
    (folder / case.file).write_bytes(case.raw)
    for name, data in case.files.items():
        (folder / name).write_bytes(data)
    outcome = Outcome(case, arguments.program, folder, arguments)
    found = list(faults(case, outcome))
    if found:
        keep(case, outcome, found, arguments)
    shutil.rmtree(folder)
    return found, f"{outcome.status} when asked to stop" if outcome.asked else str(outcome.status), case


def keep(case, outcome, found, arguments):
    """Saves a failing case: its files, what was said, and the command that repeats it."""
    place = Path(arguments.keep) / f"{case.seed}_{case.number}"
    shutil.rmtree(place, ignore_errors=True)
    shutil.copytree(outcome.folder, place)
    guard = f"cd {shlex.quote(str(place.resolve()))} && " + shlex.join(command_of(case, arguments.program))
    (place / "command.sh").write_text(guard + "\n", encoding="utf-8", errors="replace")
    told = [f"scene {case.scene.name}", *case.notes, *found, f"status {outcome.status}", outcome.errors[:3000]]
    (place / "report.txt").write_text("\n".join(told) + "\n", encoding="utf-8", errors="replace")


def find_scenes(folder=ROOT / "examples"):
    """The examples, or scenes of another such folder, but for those of many runs each."""
    scenes = [Scene(path) for path in sorted(folder.glob("*/case*.yaml"))]
    return [scene for scene in scenes if scene.options.get("mpm_task") not in ("inverse", "ensemble")]


def parse(words):
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program", type=Path, help="path of talus")
    parser.add_argument("--seed", type=int, default=1, help="the same seed gives the same cases (1)")
    parser.add_argument("--cases", type=int, default=1000, help="how many (1000)")
    parser.add_argument("--only", type=int, help="the number of the one case to run")
    parser.add_argument("--jobs", type=int, default=os.cpu_count(), help="how many at a time (one a processor)")
    parser.add_argument("--time", type=float, default=10.0, help="s, for one case (10)")
    parser.add_argument("--memory", type=int, default=8000000,
                        help="kB of address space for one case (8000000); 0: no limit, as sanitizers need it")
    parser.add_argument("--scenes", type=Path, default=ROOT / "examples", help="folder with scenes */case*.yaml (examples)")
    parser.add_argument("--keep", default="fuzz_failures", help="folder for failing cases (fuzz_failures)")
    arguments = parser.parse_args(words)
    arguments.program = arguments.program.resolve()
    return arguments


def main(words=None):
    arguments = parse(words)
    statuses, failed, begin = Counter(), 0, time.monotonic()
    scenes = find_scenes(arguments.scenes)
    numbers = range(arguments.cases) if arguments.only is None else [arguments.only]
    with tempfile.TemporaryDirectory(prefix="talus_fuzz_") as place:
        arguments.place = place
        with concurrent.futures.ThreadPoolExecutor(arguments.jobs) as pool:
            for found, status, case in pool.map(lambda number: run_case(number, arguments, scenes), numbers):
                statuses[status] += 1
                if found:
                    failed += 1
                    print(f"case {case.number} ({'; '.join(case.notes)[:120]}): {'; '.join(found)}", flush=True)
    seconds = time.monotonic() - begin
    ended = ", ".join(f"{statuses[status]} with status {status}" for status in sorted(statuses, key=str))
    print(f"{len(numbers)} cases, seed {arguments.seed}: {ended}; {failed} failed; {seconds:.0f} s"
          + (f"; failing cases are in {arguments.keep}" if failed else ""))
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())

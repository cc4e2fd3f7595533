#!/usr/bin/env python3
"""Runs examples on one rank and on several, and compares what they leave behind.

    ranks.py build/talus                            # every example on 7 ranks, the first steps of each stage
    ranks.py build/talus --ranks 4 --steps 20 pipe discs

Each line has an example, its steps, and the largest differences of the last state, of the history's columns and of
other tables: over the largest value of the field, or of the columns of one kind. Input of an example is made first.
Inverse analyses take one iteration, ensembles two members. Ends with 1 where a run fails, takes other steps or differs
by more than 1e-9; with contact 1e-8. Long: by hand. Falls and relaxations of thousands of steps differ by what rounding
grows to: --steps 1 for relaxation_slope.
"""
import argparse
import csv
import os
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
import yaml

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "scripts"))
from results import Results  # noqa: E402  (the folder has to be known first)

ENVIRONMENT = {**os.environ, "OMP_NUM_THREADS": "1", "OMPI_ALLOW_RUN_AS_ROOT": "1",
               "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1", "OMPI_MCA_pml": "ob1", "OMPI_MCA_mpi_yield_when_idle": "1",
               "OMPI_MCA_hwloc_base_binding_policy": "none"}
REACH, REACH_CONTACT, REACH_TASK = 1e-9, 1e-8, 1e-6
VANISHES = ("residual",)  # columns of a fit: differences of other ones
OWN_PROGRAM = {"bps"}  # examples whose physics a program of their own has
PART = 0.01  # of the time of steps that the program chooses, for each step asked for


def shortened(mpm, steps):
    """Options that end each stage after about so many steps, and tasks of several runs after the first ones."""
    if "task" in mpm:
        return {"ensemble": {"mpm_ensemble_members": 2}, "inverse": {"mpm_inverse_iterations": 1}}[mpm["task"]]
    options = {}
    blocks = {"mpm_": mpm, **{f"mpm_stage_{name}_": mpm.get(f"stage_{name}") or {}
                              for name in str(mpm.get("stages", "")).split(",") if name}}
    for prefix, block in blocks.items():
        time = block.get("time") or {}
        if "end" not in time:
            continue
        end, step = float(time["end"]), time.get("step", (mpm.get("time") or {}).get("step"))
        by = float(step) if step is not None else end * PART
        options[f"{prefix}time_end"] = min(end, steps * by)
    return options


def command_of(program, path, ranks, options):
    command = ["mpiexec", "--oversubscribe", "-n", str(ranks)] if ranks > 1 else []
    command += [str(program), "-options_file", str(path)]
    for name, value in options.items():
        command += ["-" + name, str(value)]
    return command


def run(program, path, ranks, options, folder, where, limit):
    """The results of a run and its status; None and the reason where it fails or hangs."""
    command = command_of(program, path, ranks, {**options, "mpm_output_prefix": folder / f"on{ranks}"})
    try:
        process = subprocess.run(command, cwd=where, env=ENVIRONMENT, capture_output=True, text=True,
                                 timeout=limit, check=False)
    except subprocess.TimeoutExpired:
        return None, f"hangs on {ranks}: {' '.join(command)}"
    if process.returncode not in (0, 3):
        return None, f"status {process.returncode} on {ranks}: {' '.join(command)}\n{process.stderr[-800:]}"
    return Results(folder / f"on{ranks}"), process.returncode


def make(name, folder):
    """Writes the input of an example that comes from a program of its own; the folder to run in."""
    program = ROOT / "examples" / name / "make.py"
    if not program.is_file() or "out/" not in (program.parent / "case.yaml").read_text(encoding="utf-8"):
        return ROOT
    subprocess.run([sys.executable, program, folder / "out"], cwd=folder, capture_output=True, check=True)
    return folder


def numbers(text):
    return np.array([float(x) for x in str(text).split(",")])


def rounding(mpm):
    """Strain that rounding of the places of nodes and points may leave: eps by extent over cell, ten times."""
    grid = mpm["grid"]
    size = (numbers(grid["upper"]) - numbers(grid["lower"])) / numbers(grid["cells"])
    return 10.0 * np.finfo(float).eps * np.max(np.abs([numbers(grid["lower"]), numbers(grid["upper"])])) / np.min(size)


def modulus(mpm):
    """The largest constrained modulus of the materials, Pa; of soils without E none."""
    found = [0.0]
    for name in str(mpm.get("materials", "")).split(","):
        block = mpm.get(f"material_{name}") or {}
        if "E" in block:
            nu = float(block.get("nu", 0.0))
            found.append(float(block["E"]) * (1.0 - nu) / (1.0 + nu) / max(1.0 - 2.0 * nu, 1e-6))
    return max(found)


def weight(mpm, mass):
    """Of all points, N: what the forces of a scene at rest are made of. A flow's gravity is 9.81 m/s2 unless given."""
    loads = [mpm.get(f"load_{name}") or {} for name in str(mpm.get("loads", "")).split(",")]
    values = [numbers(load["value"]) for load in loads if load.get("type") == "gravity"]
    if mpm.get("physics") == "depth_averaged" and not values:
        values = [np.array([9.81])]
    return float(np.sum(mass)) * max((np.linalg.norm(value) for value in values), default=0.0)


def difference(one, other, least=0.0):
    """Largest difference over the largest value, or over `least` if that is larger."""
    if np.shape(one) != np.shape(other):
        return np.inf
    scale = max(np.nanmax(np.abs(one), initial=0.0), least)
    return float(np.nanmax(np.abs(one - other), initial=0.0) / (scale or 1.0))


def kind(column):
    """Columns of one kind share their scale: forces, moments, all tracks."""
    first = column.split("_")[0]
    return {"reaction": "force", "angular": "momentum"}.get(first, first)


def fields(one, other, least):
    """Differences of the fields of the last states; of strains and stresses over what rounding may leave, at least."""
    here, there = one.state("last"), other.state("last")
    return {name: difference(np.asarray(value), np.asarray(there[name]), least.get(name, 0.0))
            for name, value in here.fields.items() if np.issubdtype(np.asarray(value).dtype, np.floating)}


def read_table(path):
    """Columns of a CSV file by name, of numbers or of words."""
    with open(path, newline="", encoding="utf-8") as file:
        names, *rows = csv.reader(file)
    for name, values in zip(names, zip(*rows)):
        try:
            yield name, np.array(values, dtype=float)
        except ValueError:
            yield name, values


def tables(one, other):
    """Differences of the tables of tasks, column by column; words differ or not."""
    found = {}
    for path in sorted(Path(one.prefix).parent.glob(Path(one.prefix).name + "_*.csv")):
        suffix = path.name[len(Path(one.prefix).name):]
        if suffix != "_history.csv":
            there = dict(read_table(other.prefix + suffix))
            found[suffix[1:-4]] = max(
                difference(values, there[name]) if isinstance(values, np.ndarray) else float(values != there[name])
                for name, values in read_table(path) if name not in VANISHES)
    return found


def compare(one, other, mpm):
    """The largest differences, by name. What may vanish is measured by what it is made of."""
    if "task" in mpm:
        return tables(one, other)
    found, columns, least = {}, {}, {}
    if "grid" in mpm:  # a laboratory has none, and no points
        grid = mpm["grid"]
        cells = (numbers(grid["upper"]) - numbers(grid["lower"])) / numbers(grid["cells"])
        strain = rounding(mpm) / REACH
        stress = modulus(mpm) * strain
        state, way = one.state("last"), strain * np.min(cells)
        speed = way / one.column("dt")[-1]
        found = fields(one, other, {"strain": strain, "stress": stress, "displacement": way, "velocity": speed,
                                    "velocity_gradient": speed / np.min(cells)})
        least["force"] = max(stress * np.min(cells) ** (len(cells) - 1), weight(mpm, state["mass"]))
        least["track"] = max(np.max(np.abs(state["displacement"]), initial=0.0), way)
        if "velocity" in state:
            least["momentum"] = np.sum(np.asarray(state["mass"])[:, None] * np.maximum(np.abs(state["velocity"]), speed))
            least["energy"] = 0.5 * np.sum(state["mass"]) * speed**2
    for name in one.history:
        if name not in ("newton", "linear"):
            columns.setdefault(kind(name), []).append(name)
    values = {name: [np.array([run.column(c) for c in members]) for run in (one, other)]
              for name, members in columns.items()}
    if "force" in values and "grid" in mpm:
        arm = np.max(np.abs(numbers(mpm["grid"]["upper"])))
        least["moment"] = arm * max(np.nanmax(np.abs(values["force"][0]), initial=0.0), least["force"])
    for name, (here, there) in values.items():
        found["history." + name] = difference(here, there, least.get(name, 0.0))
    return found


def check(program, name, arguments):
    """One line about an example; whether it is good."""
    path = ROOT / "examples" / name / "case.yaml"
    mpm = yaml.safe_load(path.read_text(encoding="utf-8"))["mpm"]
    options = shortened(mpm, arguments.steps)
    if "grid" in mpm:
        options["mpm_output_every"] = 1000000
    with tempfile.TemporaryDirectory(prefix="talus_") as folder:
        where = make(name, Path(folder))
        results, status = zip(*(run(program, path, ranks, options, Path(folder), where, arguments.limit)
                                for ranks in (1, arguments.ranks)))
        if None in results or status[0] != status[1]:
            print(f"{name}: FAILED {status[0]}; {status[1]}", flush=True)
            return False
        steps = [0 if "task" in mpm else len(result.column("time")) for result in results]
        if steps[0] != steps[1]:
            print(f"{name}: FAILED {steps[0]} steps on 1, {steps[1]} on {arguments.ranks}", flush=True)
            return False
        worst = sorted(compare(*results, mpm).items(), key=lambda item: -item[1])[:3]
    reach = REACH_TASK if mpm.get("task") == "inverse" else REACH_CONTACT if {"boundaries", "contacts"} & set(mpm) else REACH
    good = worst[0][1] <= reach
    print(f"{name}: {steps[0]} steps, " + ", ".join(f"{what} {value:.2g}" for what, value in worst)
          + ("" if good else "  FAILED"), flush=True)
    return good


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("program", type=Path)
    parser.add_argument("examples", nargs="*", help="names; all by default")
    parser.add_argument("--ranks", type=int, default=7)
    parser.add_argument("--steps", type=float, default=5, help="steps of a stage (default 5)")
    parser.add_argument("--limit", type=float, default=900.0, help="s for a run (default 900)")
    arguments = parser.parse_args()
    names = arguments.examples or sorted({path.parent.name for path in (ROOT / "examples").glob("*/case.yaml")} - OWN_PROGRAM)
    sys.exit(0 if all([check(arguments.program.resolve(), name, arguments) for name in names]) else 1)


if __name__ == "__main__":
    main()

#!/usr/bin/env python3
"""What a viewer finds in the files of a run: points and grid, in 2D and 3D, read through the XDMF index and drawn.

The grid's fields against what the history and the points say: the reactions' sum, the load's, the mass. The same on any
number of ranks. Bodies that come and go. Chosen fields, single precision, no output at all. With TALUS_PICTURES=FOLDER in the environment the
pictures are kept there.
"""
import os
import sys
from pathlib import Path

import h5py
import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
from talus_test import Test, call, difference, example  # noqa: E402
import matplotlib.image  # noqa: E402
import xdmf  # noqa: E402

FULL = [0, 3, 5, 3, 1, 4, 5, 4, 2]  # of xx, yy, zz, xy, yz, xz: the tensor row by row
PICTURES = os.environ.get("TALUS_PICTURES")
LOAD = -100e3  # N, the cantilever's at the end
HEAVY = """mpm:
  dim: 2
  grid: {lower: "0,0", upper: "2,2", cells: "4,4"}
  shape: gimp
  materials: soil
  material_soil: {type: hencky, E: 1e9, nu: 0.3, density: 1000}
  bodies: heavy
  body_heavy: {region: file, file: "heavy.csv", material: soil}
  bcs: base
  bc_base: {region: box, lower: "0,0", upper: "2,0", components: "x,y"}
  loads: weight
  load_weight: {type: gravity, value: "0,-10"}
  time: {step: 1}
  output: {prefix: heavy, grid: true}
"""


def h5(run):
    return h5py.File(run.prefix + ".h5", "r")


def by_place(state):
    """Order of the nodes that does not depend on their numbers."""
    return np.lexsort(state.position.T)


def in_full(values):
    """A field as the index shows it."""
    return values[:, FULL] if values.shape[-1:] == (6,) else values


def check_points(test, label, run, collections):
    """Every number of the index is that of the file."""
    results, states = run.results, collections["states"]
    test.check(f"{label}.states", len(states), len(results.steps), len(results.steps))
    for step, state in zip(results.steps, states):
        stored = results.state(step)
        test.check(f"{label}.{step}.time", state.time - stored.time, 0.0, 0.0)
        wrong = [name for name, values in state.fields.items() if not np.array_equal(values, in_full(stored[name]))]
        test.check(f"{label}.{step}.wrong_fields", len(wrong), None, 0)
        test.check(f"{label}.{step}.missing_fields", len(set(stored.fields) - set(state.fields) - {"id", "position"}),
                   None, 0)
        test.check(f"{label}.{step}.misplaced", np.count_nonzero(state.position != stored["position"]), None, 0)


def check_grid(test, label, run, collections, ranks, mass):
    """Cells hold the points; mass, reactions and ranks are what they should be."""
    results, grids = run.results, collections["grids"]
    test.check(f"{label}.grid_states", len(grids), len(results.steps), len(results.steps))
    lower, upper, cells = (np.array(results.numbers(f"mpm_grid_{name}")) for name in ("lower", "upper", "cells"))
    h = (upper - lower) / cells
    first = results.state("first")["position"]
    active = {tuple(row) for row in np.rint((grids[0].position[grids[0].cells[:, 0]] - lower) / h).astype(int)}
    without = sum(tuple(row) not in active for row in np.unique(np.floor((first - lower) / h).astype(int), axis=0))
    test.check(f"{label}.points_without_cell", without, None, 0)
    for grid in grids:
        corner = grid.position[grid.cells]
        spans = corner.max(axis=1) - corner.min(axis=1)
        test.check(f"{label}.cell_size_error", np.max(np.abs(spans - h)) / h.min(), None, 1e-6)
        test.check(f"{label}.twice_a_cell", len(grid.cells) - len(np.unique(grid.cells[:, 0])), None, 0)
        test.near(f"{label}.mass", grid.fields["mass"].sum(), mass, relative=1e-6)
        test.check(f"{label}.ranks", len(np.unique(grid.fields["rank"])), ranks, ranks)
    test.check(f"{label}.first_increment", np.abs(grids[0].fields["displacement_increment"]).max(), None, 0.0)
    test.check(f"{label}.last_increment", np.abs(grids[-1].fields["displacement_increment"]).max(), 1e-6, None)


def check_picture(test, label, run):
    """The picture shows something: points in many colours."""
    picture = Path(PICTURES or run.folder) / f"{label}.png"
    process = call([sys.executable, xdmf.__file__, run.prefix + ".xdmf", "--output", picture], run.folder)
    test.check(f"{label}.drawing_status", process.returncode, 0, 0)
    if process.returncode:
        print(process.stderr)
        return
    pixels = matplotlib.image.imread(picture)[:, :700, :3]  # without the colour bar
    coloured = pixels[np.ptp(pixels, axis=2) > 0.2]
    test.check(f"{label}.coloured", len(coloured) / pixels[:, :, 0].size, 0.005, None)
    test.check(f"{label}.colours", len(np.unique(np.rint(coloured * 15), axis=0)), 10, None)


def plane(test):
    """The cantilever: its load and reactions are known."""
    options = {"mpm_output_every": 5, "mpm_time_step": 0.1, "mpm_output_grid": "true", "mpm_quiet": None}
    runs = {ranks: test.run(example("cantilever"), ranks=ranks, **options) for ranks in (1, 4)}
    seen = {ranks: xdmf.read(run.prefix + ".xdmf") for ranks, run in runs.items()}
    for ranks, run in runs.items():
        label = f"plane_on_{ranks}"
        check_points(test, label, run, seen[ranks])
        check_grid(test, label, run, seen[ranks], ranks, run.table("mass").sum())
        grid = seen[ranks]["grids"][-1]
        held = grid.fields["held"].astype(int)
        reaction = grid.fields["reaction"]
        test.near(f"{label}.load", grid.fields["load"][:, 1].sum(), LOAD, relative=1e-9)
        test.near(f"{label}.reaction_x", reaction[held & 1 > 0, 0].sum(), run.results.column("reaction_root_x")[-1],
                  absolute=1e-6 * abs(LOAD))
        test.near(f"{label}.reaction_y", reaction[held & 2 > 0, 1].sum(), -LOAD, relative=1e-6)
        test.check(f"{label}.unbalanced", np.abs(reaction[held == 0]).max() / abs(LOAD), None, 1e-4)
        alone = xdmf.read(run.prefix + "_grid.xdmf")
        test.check(f"{label}.grid_alone", float(list(alone) == ["grids"] and
                                                np.array_equal(alone["grids"][-1].cells, grid.cells)), 1, 1)
    one, four = (seen[ranks]["grids"][-1] for ranks in (1, 4))
    for name in ("displacement_increment", "mass", "load"):
        test.check(f"plane.{name}_by_ranks",
                   difference(one.fields[name][by_place(one)], four.fields[name][by_place(four)]), None, 1e-8)
    held = [grid.fields["held"][by_place(grid)] for grid in (one, four)]
    test.check("plane.held_by_ranks", np.count_nonzero(held[0] != held[1]), None, 0)
    check_picture(test, "plane", runs[4])


def space(test):
    """A block in 3D, in both precisions, with some of the fields."""
    options = {"mpm_output_every": 1000, "mpm_time_step": 0.5, "mpm_output_grid": "true", "mpm_quiet": None}
    double = test.run(example("slump3d"), ranks=2, **options)
    single = test.run(example("slump3d"), ranks=2, mpm_output_precision="single",
                      mpm_output_fields="stress,displacement", **options)
    for label, run in (("space", double), ("space_single", single)):
        seen = xdmf.read(run.prefix + ".xdmf")
        check_points(test, label, run, seen)
        check_grid(test, label, run, seen, 2, double.table("mass").sum())
    with h5(single) as file:
        groups = sorted(file["points"])
        fields = [sorted(file["points"][group]) for group in groups]
        bytes_a_real = file["points"][groups[-1]]["stress"].dtype.itemsize
    test.check("fields.first", float(fields[0] == ["displacement", "id", "position", "position0", "stress"]), 1, 1)
    test.check("fields.last", float(fields[-1] == ["displacement", "id", "position", "stress"]), 1, 1)
    test.check("single.bytes", bytes_a_real, 4, 4)
    for name in ("stress", "position"):
        test.check(f"single.{name}", difference(double.table(name), single.table(name)), 1e-12, 1e-6)
    check_picture(test, "space", double)


def stages(test):
    """Bodies come and go: the index has each state's points, each once, and refers to no other; see also xdmf.read()."""
    run = test.run(Path(__file__).parent / "dig.yaml", ranks=2, mpm_output_grid="true", mpm_quiet=None)
    seen = xdmf.read(run.prefix + ".xdmf")
    check_points(test, "stages", run, seen)
    ids = [run.results.state(step)["id"] for step in run.results.steps]
    test.check("stages.ids_with_holes", sum(rows.max() >= len(rows) for rows in ids), 3, len(ids) - 1)
    corners = [np.count_nonzero(state.cells[:, 0] != np.arange(len(rows))) for state, rows in zip(seen["states"], ids)]
    test.check("stages.wrong_corners", sum(corners), None, 0)
    with h5(run) as file:
        counts = {len(rows) for rows in ids}
        test.check("stages.row_numbers", len(set(file["rows"]) ^ {str(count) for count in counts}), None, 0)


def own_masses(test):
    """Points from a file with masses of their own, two and a half times the law's density: the grid holds them."""
    folder = test.folder()
    places = [(0.125 + 0.25 * i, 0.125 + 0.25 * j) for j in range(4) for i in range(8)]
    mass = 2.5 * 1000.0 * 0.0625  # kg, of a point
    (folder / "heavy.csv").write_text("x,y,volume,mass\n" + "".join(f"{x},{y},0.0625,{mass}\n" for x, y in places))
    (folder / "heavy.yaml").write_text(HEAVY.replace("heavy.csv", str(folder / "heavy.csv")))
    run = test.run(folder / "heavy.yaml", mpm_quiet=None)
    for grid in xdmf.read(run.prefix + ".xdmf")["grids"]:
        test.near("own_masses.grid", grid.fields["mass"].sum(), mass * len(places), relative=1e-12)
    test.near("own_masses.load", grid.fields["load"][:, 1].sum(), -10.0 * mass * len(places), relative=1e-12)


def switched_off(test):
    """Without states there is no file of them; scripts/bench.py output measures that they cost nothing."""
    run = test.run(example("bar_elastic"), ranks=2, mpm_output_every=0, mpm_output_grid="true", mpm_quiet=None)
    test.check("off.files", len([name for name in run.files if name.endswith((".h5", ".xdmf"))]), None, 0)


def refused(test):
    run = test.run(example("bar_elastic"), status=2, mpm_output_fields="stress,strains")
    text = run.errors.strip()
    test.check("refused.lines", text.count("\n") + 1, 1, 1)
    test.check("refused.names_field", float("-mpm_output_fields strain" in text and "displacement" in text), 1, 1)
    test.check("refused.files", len(run.files), None, 0)


with Test() as test:
    plane(test)
    space(test)
    stages(test)
    own_masses(test)
    switched_off(test)
    refused(test)

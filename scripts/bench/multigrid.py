"""Iterations and seconds of multigrid on coarser lattices and lower orders, of GAMG and of point-block Jacobi.

`block`: a block in 3D with faces between the nodes (tests/verification/levels.yaml), 4, 8 and 16 cells an axis. `spheres`:
24 stiff grains in a binder, with 12 holes of soft air, in a box of 1 x 1 x 1.8, stretched from a unit cube; rollers on all
sides, the top moved by 1e-4; E of 4000, 300 and 5, 4 x 4 x 4 points a cell. One linear solve to 1e-8.
"""
import itertools
import tempfile
from pathlib import Path

import numpy as np

from bench.runs import ROOT, Table, median, repeated, run_scene

BLOCK = ROOT / "tests" / "verification" / "levels.yaml"
SPHERES = ROOT / "scripts" / "bench" / "spheres.yaml"
SOLVERS = {"hmg": {"mpm_solver": "hmg"}, "hmg-matfree": {"mpm_solver": "hmg", "mpm_jacobian": "matfree"},
           "amg": {"mpm_solver": "amg"}, "boomeramg": {"mpm_solver": "boomeramg"},
           "pbjacobi": {"mpm_solver": "pbjacobi", "mpm_jacobian": "matfree"}}
ORDERS = {"pmg": {"mpm_solver": "pmg"}, "pmg-matfree": {"mpm_solver": "pmg", "mpm_jacobian": "matfree"}}  # of elements
RATIO = 1.8  # height of the box of spheres over its width
GRAINS, HOLES, SIZES = 24, 12, (0.16, 0.07)
G = np.power(1.22074408460575947536, -np.arange(1.0, 4.0))  # quasi-random sequence in 3D, Roberts (2018)
NAMES = ("binder", "grains", "air")


def add_arguments(parser):
    parser.set_defaults(ranks=1)
    parser.add_argument("--problems", nargs="+", choices=("block", "spheres"), default=("block", "spheres"), help="(both)")
    parser.add_argument("--refine", type=int, nargs="+", metavar="N", help="of the block's cells (1 2 4; quick 1 2)")
    parser.add_argument("--cells", type=int, nargs="+", metavar="N", help="of the spheres across (5 10 15; quick 5)")
    parser.add_argument("--shapes", nargs="+", default=("gimp",), metavar="NAME", help="(gimp)")
    parser.add_argument("--order", type=int, metavar="P", help="elements of this order, 2 to 4, in place of the shapes")
    parser.add_argument("--solvers", nargs="+", choices=(*ORDERS, *SOLVERS), help="(all that serve the shape)")
    parser.add_argument("--limit", type=float, metavar="S", help="a run that takes longer is ended (1800; quick 120)")


def spheres(cells, folder):
    """Files of points by material; the options of the scene."""
    counts = (cells, cells, round(RATIO * cells))
    axes = [(np.arange(4 * count) + 0.5) / (4 * count) for count in counts]
    place = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    centre = np.mod(0.5 + np.arange(1, GRAINS + HOLES + 1)[:, None] * G, 1.0)
    material = np.zeros(len(place), int)
    for group, radius, which in ((centre[:GRAINS], SIZES[0], 1), (centre[GRAINS:], SIZES[1], 2)):
        for one in group:
            material[np.sum((place - one)**2, axis=1) < radius**2] = which
    volume = RATIO / len(place)
    options = {"mpm_grid_cells": ",".join(map(str, counts))}
    for which, name in enumerate(NAMES):
        path = Path(folder) / f"{name}.csv"
        points = place[material == which] * (1.0, 1.0, RATIO)
        np.savetxt(path, np.column_stack([points, np.full(len(points), volume)]), fmt="%.17g", delimiter=",",
                   header="x,y,z,volume", comments="")
        options[f"mpm_body_{name}_file"] = path
    return options


def measure(arguments, problem, table):
    for solver in arguments.solvers:
        options = {**problem["options"], **{**ORDERS, **SOLVERS}[solver], "mpm_output_every": 0}
        if arguments.order:
            options["mpm_order"] = arguments.order
            if problem["problem"] == "block":
                options["mpm_body_block_points_per_cell"] = ",".join(3 * [str(arguments.order + 1)])
        runs = repeated(arguments.repeat, lambda: run_scene(arguments.program, problem["scene"], options,
                                                            arguments.ranks, arguments.limit))
        values = {name: problem[name] for name in ("problem", "cells", "shape")}
        values.update(solver=solver, ranks=arguments.ranks, status=runs[0].status)
        if runs[0].summary:
            newton, linear = runs[0]["newton_iterations"], runs[0]["linear_iterations"]
            values.update(points=runs[0]["points"], unknowns=runs[0]["active_dofs_max"],
                          iterations_per_solve=linear / newton if newton else None, solve=median(runs, "solve"),
                          total=median(runs, "time_total_s"), memory_mb=median(runs, "memory_max_bytes") / 1e6)
        table.add(**values)


def problems(arguments, folder):
    for name, shape in itertools.product(arguments.problems, arguments.shapes):
        if name == "block":
            for refine in arguments.refine or ((1, 2) if arguments.quick else (1, 2, 4)):
                yield {"problem": name, "scene": BLOCK, "cells": 4 * refine, "shape": shape,
                       "options": {"mpm_grid_refine": refine, "mpm_shape": shape, "ksp_rtol": 1e-8}}
            continue
        for cells in arguments.cells or ((5,) if arguments.quick else (5, 10, 15)):
            yield {"problem": name, "scene": SPHERES, "cells": cells, "shape": shape,
                   "options": {**spheres(cells, folder), "mpm_shape": shape, "ksp_rtol": 1e-8}}


def run(arguments):
    arguments.repeat = arguments.repeat or (1 if arguments.quick else 3)
    arguments.shapes = ("element",) if arguments.order else arguments.shapes
    arguments.solvers = arguments.solvers or (*(ORDERS if arguments.order else ()), *SOLVERS)
    arguments.limit = arguments.limit or (120.0 if arguments.quick else 1800.0)
    table = Table(arguments.out, "multigrid", [
        "problem", "cells", "shape", "solver", "ranks", "points", "unknowns", "iterations_per_solve", "solve", "total",
        "memory_mb", "status"])
    with tempfile.TemporaryDirectory() as folder:
        for problem in problems(arguments, folder):
            measure(arguments, problem, table)

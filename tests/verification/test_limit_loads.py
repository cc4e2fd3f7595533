#!/usr/bin/env python3
"""Limit loads, by loads and by displacements: no state is accepted far above the exact limit, whatever the steps and wherever the body's edge
lies in its cells; a run by loads ends there and says what slides, the reaction to a displacement stays flat.

With --full: all shapes, grids, places of the edge and steps.
"""
import itertools
import math
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Callable

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
from talus_test import FULL, Test  # noqa: E402

HERE = Path(__file__).resolve().parent
SIGMA_Y = 240e6  # Pa, of the metal
S_U = 10e3  # Pa, of the clay without weight
METAL = {"inner": 0.1, "outer": 0.2}  # m, radii
SHAPES = ("gimp", "gimp_bspline2")
COARSE, FINE = 1.05, 1.03  # largest accepted load over the exact limit
TOLERANCE = 0.01  # between steps four times as long or short


@dataclass
class Case:
    """A scene with its points and options; load(results): the load of each step over the exact limit."""
    scene: str
    points: list  # (centre, edges) each, m
    file: str  # the option that names the table of points
    options: dict
    load: Callable


def numbers(*values):
    return ",".join(f"{value:.10g}" for value in values)


def rectangle(lower, upper, spacing):
    """Points of a rectangle, as near to the spacing as its edges let them."""
    counts = [round((u - v) / spacing) for v, u in zip(lower, upper)]
    edges = [(u - v) / n for v, u, n in zip(lower, upper, counts)]
    return [([v + (k + 0.5) * e for v, k, e in zip(lower, at, edges)], edges) for at in itertools.product(*map(range, counts))]


def shell(spacing, dim):
    """Points between the radii, in the quarter or octant of positive coordinates."""
    lattice = rectangle(dim * [0.0], dim * [METAL["outer"]], spacing)
    return [point for point in lattice if METAL["inner"] <= math.hypot(*point[0]) <= METAL["outer"]]


def hollow(drive, cells, part, dim):
    """A thick cylinder or sphere, with cells + part cells a radius; the points are `cells` of them, two to a cell."""
    radius = METAL["inner"]
    h = radius / (cells + part)
    count = math.ceil((1.1 * METAL["outer"]) / h - 1e-9)
    scene, body, pressure, limit, area = {
        2: ("thick_cylinder", "tube", 230e6, 2.0 / math.sqrt(3.0), radius),
        3: ("hollow_sphere", "ball", 360e6, 2.0, math.pi * radius**2 / 4.0)}[dim]
    limit *= SIGMA_Y * math.log(METAL["outer"] / METAL["inner"])
    options = {"mpm_grid_cells": numbers(*dim * [count]), "mpm_grid_upper": numbers(*dim * [count * h])}
    load = lambda results: results.column("load") * pressure / limit  # noqa: E731
    if drive == "way":
        options |= {"mpm_surfaces": "", "mpm_boundaries": "hole", "mpm_boundary_hole_type": "sphere", "mpm_boundary_hole_radius": radius,
                    "mpm_boundary_hole_center": numbers(*dim * [0.0]), "mpm_boundary_hole_growth": 8e-4}
        load = lambda results: np.abs(results.column("reaction_hole_x")) / area / limit  # noqa: E731
    return Case(scene, shell(radius / cells / 2, dim), f"body_{body}_file", options, load)


def cylinder(drive, cells, part):
    return hollow(drive, cells, part, 2)


def sphere(drive, cells, part):
    return hollow(drive, cells, part, 3)


def strip(drive, cells, part):
    """A strip load, 1 m from its middle to its edge: pressure; held nodes (rough), which bear half a cell beyond the last; a smooth plate."""
    h = 1.0 / cells
    base, count = -(2.0 + part * h), math.ceil(2.5 * cells)
    top = base + count * h
    options = {"mpm_grid_lower": numbers(0, base), "mpm_grid_upper": numbers(4, top), "mpm_grid_cells": numbers(4 * cells, count)}
    for name, (left, right, upper) in {"symmetry": (0, 0, top), "side": (4, 4, top), "base": (0, 4, base)}.items():
        options |= {f"mpm_bc_{name}_lower": numbers(left, base), f"mpm_bc_{name}_upper": numbers(right, upper)}
    limit = (2.0 + math.pi) * S_U
    load = lambda results: results.column("load") * 60e3 / limit  # noqa: E731
    if drive == "way":
        options |= {"mpm_surfaces": "", "mpm_bcs": "symmetry,side,base,footing", "mpm_bc_footing_region": "box", "mpm_bc_footing_lower": "0,0",
                    "mpm_bc_footing_upper": "1,0.4", "mpm_bc_footing_components": "x,y", "mpm_bc_footing_value": "0,-0.006",
                    "mpm_bc_footing_ramp": "0:0,1:1"}
        load = lambda results: -results.column("reaction_footing_y") / (1.0 + h / 2) / limit  # noqa: E731
    elif drive == "plate":
        options |= {"mpm_surfaces": "", "mpm_boundaries": "plate", "mpm_boundary_plate_type": "box", "mpm_boundary_plate_lower": "-1,0",
                    "mpm_boundary_plate_upper": "1,0.3", "mpm_boundary_plate_motion": "0,-0.006"}
        load = lambda results: np.abs(results.column("reaction_plate_y")) / limit  # noqa: E731
    return Case("clay_strip", rectangle((0, base), (4, 0), h / 2), "body_ground_file", options, load)


def cut(_, cells, part):
    """A vertical cut, `cells` to its height, 10 m; its face, its crest and its toe lie `part` of a cell beyond nodes."""
    h = 10.0 / cells
    left, base = 16.0 - h * (math.floor(16.0 / h + 1e-9) + part), 6.0 - h * (math.floor(6.0 / h + 1e-9) + part)
    across, up = math.ceil(26.0 / h - 1e-9), math.ceil(18.0 / h)
    right, top = left + across * h, base + up * h
    options = {"mpm_grid_lower": numbers(left, base), "mpm_grid_upper": numbers(right, top), "mpm_grid_cells": numbers(across, up)}
    for name, (lower, upper) in {"west": ((left, base), (left, top)), "east": ((right, base), (right, top)),
                                 "base": ((left, base), (right, base))}.items():
        options |= {f"mpm_bc_{name}_lower": numbers(*lower), f"mpm_bc_{name}_upper": numbers(*upper)}
    points = [point for lower, upper in (((left, base), (16, 6)), ((left, 6), (16, 16)), ((16, base), (right, 6)))
              for point in rectangle(lower, upper, h / 2)]
    return Case("heavy_cut", points, "body_cut_file", options, lambda results: results.column("load") * 200e3 / 60e3 / 3.776)


def bar(drive, cells, part):
    """A bar of 4 x 1 m; its top lies `part` of a cell beyond a row of nodes, and the end on which a stress acts, too."""
    h = 1.0 / cells
    length, height = 4.0 + (part * h if drive == "load" else 0.0), 1.0 + part * h
    limit = 2.0 * SIGMA_Y / math.sqrt(3.0)
    options = {"mpm_grid_cells": numbers(5 * cells, 2 * cells)}
    load = lambda results: results.column("load") * 320e6 / limit  # noqa: E731
    if drive == "way":
        options |= {"mpm_surfaces": "", "mpm_bcs": "left,bottom,right", "mpm_bc_right_region": "box", "mpm_bc_right_lower": "4,0",
                    "mpm_bc_right_upper": "4,2", "mpm_bc_right_components": "x", "mpm_bc_right_value": 0.02, "mpm_bc_right_ramp": "0:0,1:1"}
        load = lambda results: results.column("reaction_right_x") / height / limit  # noqa: E731
    return Case("tension_bar", rectangle((0, 0), (length, height), h / 2), "body_bar_file", options, load)


def trapdoor(drive, cells, part):
    """A trapdoor, 1 m from its middle to its edge, against the mechanism of rigid blocks. Of a pull on the door the last half cell goes to
    the node that is held at its edge."""
    h = 1.0 / cells
    height = 2.0 + part * h
    options = {"mpm_grid_cells": numbers(6 * cells, 4 * cells)}
    load = lambda results: results.column("load") * 25e3 * (1.0 - h / 2) / S_U / height  # noqa: E731
    if drive == "way":
        options |= {"mpm_surfaces": "", "mpm_bcs": "symmetry,side,base,door", "mpm_bc_door_region": "box", "mpm_bc_door_lower": "0,0",
                    "mpm_bc_door_upper": "1,0", "mpm_bc_door_components": "x,y", "mpm_bc_door_value": "0,-0.006",
                    "mpm_bc_door_ramp": "0:0,1:1", "mpm_bc_base_lower": numbers(1.0 + h, 0)}
        load = lambda results: -results.column("reaction_door_y") / S_U / height  # noqa: E731
    return Case("trapdoor_pulled", rectangle((0, 0), (6, height), h / 2), "body_ground_file", options, load)


def tabulate(points, path):
    """The points as a table that a body reads."""
    axes = "xyz"[: len(points[0][0])]
    rows = [numbers(*centre, math.prod(edges), *(edge / 2 for edge in edges)) for centre, edges in points]
    names = [*axes, "volume", *("half_length_" + axis for axis in axes)]
    path.write_text("\n".join([",".join(names), *rows]) + "\n", encoding="utf-8")


def largest(test, build, drive, shape, cells, part=0.0, steps=1.0, upper=COARSE):
    """Runs a case; the largest accepted load over the exact limit. Steps are 1/25 times `steps`."""
    case = build(drive, cells, part)
    table = test.folder() / "points.csv"
    tabulate(case.points, table)
    by_load = drive == "load"
    run = test.run(HERE / f"{case.scene}.yaml", status=3 if by_load else 0, mpm_quiet=None, mpm_output_every=0, mpm_shape=shape,
                   mpm_time_step=0.04 * steps, mpm_time_step_min=5e-4, **{"mpm_" + case.file: table}, **case.options)
    load = case.load(run.results)
    label = f"{build.__name__}.{drive}.{shape}.{cells}.{part:g}.{steps:g}"
    test.check(f"{label}.largest", load.max(), 0.85, upper)
    if by_load:
        test.check(f"{label}.told", float("slides" in run.errors or "points flow" in run.errors), 1)
    else:
        test.check(f"{label}.flat", 1.0 - load[-1] / load.max(), None, 0.015)
    return load.max()


def independent(test, build, drive, shape, cells, upper=COARSE):
    """The same with steps four times as long and as short."""
    loads = [largest(test, build, drive, shape, cells, 0.0, steps, upper) for steps in (1.0, 0.25, 4.0)]
    test.check(f"{build.__name__}.{drive}.{shape}.{cells}.steps", max(loads) / min(loads) - 1.0, None, TOLERANCE)


def matrix(test):
    """Cells a radius, a half width, a height; parts of a cell by which the edge is beyond nodes. Planes of conditions lie on grid lines."""
    for build, drives, grids, parts, shapes in (
            (cylinder, ("load", "way"), (5, 10), (0.01, 0.3, 0.5), SHAPES), (strip, ("load",), (4, 8), (0.01, 0.3, 0.5), SHAPES),
            (strip, ("way",), (4, 8), (), SHAPES), (strip, ("plate",), (8, 16), (0.3,), ("gimp",)),
            (cut, ("load",), (20, 40), (0.01, 0.5), SHAPES), (bar, ("load", "way"), (4, 8), (0.01, 0.3, 0.5), SHAPES),
            (trapdoor, ("load", "way"), (4, 8), (0.01, 0.3, 0.5), SHAPES), (sphere, ("load", "way"), (4,), (0.3,), SHAPES)):
        for drive, shape, cells in itertools.product(drives, shapes, grids):
            upper = FINE if cells == max(grids) and len(grids) > 1 else COARSE
            independent(test, build, drive, shape, cells, upper)
            for part in parts:
                largest(test, build, drive, shape, cells, part, 1.0, upper)
    for drive in ("load", "way"):
        largest(test, sphere, drive, "gimp", 8, upper=FINE)


with Test() as check:
    if FULL:
        matrix(check)
    else:
        for problem, grid in ((cylinder, 5), (strip, 4), (bar, 4), (trapdoor, 4)):
            independent(check, problem, "load", "gimp", grid)
            largest(check, problem, "load", "gimp_bspline2", grid)
            largest(check, problem, "load", "gimp", grid, 0.3)
            largest(check, problem, "way", "gimp", grid, steps=4.0)
        largest(check, cut, "load", "gimp_bspline2", 20, steps=4.0)

#!/usr/bin/env python3
"""Limit loads, and a support at rest: no viscosity in steps holds what the material does not, and nothing creeps away where nothing changes.

With --full: steps of a half, other shapes, 3 ranks, finer grids and more slopes.
"""
import itertools
import math
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
FULL = "--full" in sys.argv
if FULL:
    sys.argv.remove("--full")
from talus_test import Test  # noqa: E402

HERE = Path(__file__).resolve().parent
SHORT = {"mpm_quiet": None, "mpm_output_every": 0}
YOUNG, POISSON, LENGTH = 1e6, 0.49, 4.0  # Pa, -, m: of the bar
S_U = 10e3  # Pa: of the clay above the trapdoor
LIMIT, PRESSURE = 2 * 240e6 * math.log(2.0), 360e6  # Pa: of the sphere, and that at load factor 1


def bar(test, label, pull, reach, **options):
    """The reaction in each step: the bar's at once, and for good."""
    run = test.run(HERE / "held_bar.yaml", mpm_bc_right_value=pull, **SHORT, **options)
    stretch = 1.0 + pull / LENGTH
    exact = YOUNG / (1.0 - POISSON**2) * math.log(stretch) / stretch
    force = run.results.column("reaction_right_x")
    test.check(f"{label}.force", np.max(np.abs(force / exact - 1.0)), None, reach)
    test.check(f"{label}.drift", np.max(np.abs(force[2:] / force[2] - 1.0)), None, 1e-3)
    test.check(f"{label}.cuts", run.results.summary["step_cuts"], None, 0)


def sphere_points(path, d, inner, outer):
    """Points of an octant between two radii, on a lattice of spacing d."""
    lines = ["x,y,z,volume,half_length_x,half_length_y,half_length_z"]
    for at in itertools.product(range(round(outer / d)), repeat=3):
        x = [(k + 0.5) * d for k in at]
        if inner <= math.hypot(*x) <= outer:
            lines.append(",".join(f"{v:.10g}" for v in x + [d**3] + 3 * [d / 2]))
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")


def sphere(test, label, **options):
    """It gives up where the limit load is, and not beyond."""
    points = test.folder() / "sphere.csv"
    sphere_points(points, 0.1 / 8, 0.1, 0.2)
    run = test.run(HERE / "hollow_sphere.yaml", status=3, mpm_body_ball_file=points, **SHORT, **options)
    test.check(f"{label}.load", run.results.column("load")[-1] * PRESSURE / LIMIT, 0.95, 1.03)
    return run.results.column("load")[-1]


def trapdoor(test, label, **options):
    """The load on the door, flat once the clay flows."""
    run = test.run(HERE / "trapdoor.yaml", **SHORT, **options)
    load = -run.results.column("reaction_door_y") / S_U
    test.check(f"{label}.load", load[-1], 1.9, 2.03)
    test.check(f"{label}.most", load.max(), None, 2.03)
    test.check(f"{label}.falls", load.max() - load[-1], None, 0.01)


def slope(test, label, **options):
    """The factor of the slope of ACADS, 10 cells a height."""
    run = test.run(HERE / "acads_1a.yaml", **SHORT, **options)
    test.near(f"{label}.factor", run.results.summary["factor_of_safety"] / 1.5, 0.986, relative=0.03)


with Test() as check:
    for shape in ("gimp", "gimp_bspline2"):
        bar(check, f"bar.{shape}", 0.02, 0.006, mpm_shape=shape)
    bar(check, "bar.half_step", 0.02, 0.006, mpm_time_step=0.01, mpm_time_end=0.5, ranks=3)
    bar(check, "bar.far", 0.08, 0.02, mpm_time_step=0.1)
    sphere(check, "sphere")
    trapdoor(check, "trapdoor")
    slope(check, "slope")
    if FULL:
        for shape in ("linear", "bspline2", "bspline3"):
            bar(check, f"bar.{shape}", 0.02, 0.006, mpm_shape=shape)
            bar(check, f"bar.far.{shape}", 0.08, 0.02, mpm_time_step=0.1, mpm_shape=shape)
        bar(check, "bar.long", 0.02, 0.006, mpm_time_step=0.005)
        loads = [sphere(check, f"sphere.{step}", mpm_time_step=step) for step in (0.1, 0.02)]
        check.near("sphere.steps", loads[0], loads[1], relative=0.01)
        sphere(check, "sphere.spline", mpm_shape="gimp_bspline2")
        sphere(check, "sphere.ranks", ranks=3)
        trapdoor(check, "trapdoor.half_step", mpm_time_step=0.02)
        trapdoor(check, "trapdoor.soft", mpm_material_clay_E=1e6, mpm_bc_door_value="0,-0.2")
        trapdoor(check, "trapdoor.spline", mpm_shape="gimp_bspline2")
        trapdoor(check, "trapdoor.ranks", ranks=3)
        for shape in ("gimp", "gimp_bspline2"):
            slope(check, f"slope.fine.{shape}", mpm_grid_refine=2, mpm_shape=shape)
        slope(check, "slope.steps", mpm_stage_fail_time_step=0.16)

#!/usr/bin/env python3
"""Loads on surfaces of bodies: total force, uniform stress whatever the place of the faces on the grid, areas as they stand now,
faces that stop to bound the material, on any number of ranks and over a restart."""
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
from talus_test import Test, difference  # noqa: E402

HERE = Path(__file__).resolve().parent
COLUMN, DISC, BAR = (HERE / name for name in ("column.yaml", "disc.yaml", "bar3d.yaml"))
PRESSURE, WIDTH = 300e3, 2.0
NORMAL = {"mpm_surface_top_normal": -PRESSURE}


def column(test):
    """The reaction is the load to rounding; with domains the stress is uniform while the top sinks through the grid."""
    runs = {}
    for label, ranks, options in (("gimp", 1, NORMAL), ("traction", 2, {"mpm_surface_top_traction": f"0,{-PRESSURE}"}),
                                  ("on_2", 2, NORMAL), ("on_3", 3, NORMAL), ("on_4", 4, NORMAL),
                                  ("matfree", 1, {**NORMAL, "mpm_jacobian": "matfree"}),
                                  ("smooth", 1, {**NORMAL, "mpm_shape": "gimp_bspline2"}),
                                  ("linear", 1, {**NORMAL, "mpm_shape": "linear"}),
                                  ("spline", 1, {**NORMAL, "mpm_shape": "bspline2"}),
                                  ("cubic", 1, {**NORMAL, "mpm_shape": "bspline3"})):
        run = runs[label] = test.run(COLUMN, ranks=ranks, snes_rtol=1e-12, **options)
        domains = label not in ("linear", "spline", "cubic")
        test.near(f"{label}.force", run.results.column("reaction_base_y")[-1], PRESSURE * WIDTH, 1e-10 if domains else 1e-7)
        stress = run.table("stress")[:, 1]
        if domains:
            test.check(f"{label}.stress", np.max(np.abs(stress + PRESSURE)) / PRESSURE, None, 1e-10)
        else:  # the mean over what stands below the load, by virtual work: points' volumes are off where their strains waver
            volume, y = run.table("volume"), run.table("position")[:, 1]
            top = np.argmax(y)
            height = y[top] + 0.125 * volume[top] / run.table("volume", "first")[top]
            test.near(f"{label}.mean", np.sum(stress * volume) / (WIDTH * height), -PRESSURE, 1e-3)
    for label in ("traction", "on_2", "on_3", "on_4", "matfree", "smooth"):
        test.check(f"{label}.same", difference(runs["gimp"].table("displacement"), runs[label].table("displacement")), None, 1e-9)
    half = test.run(COLUMN, mpm_checkpoint_every=4, **NORMAL)
    again = test.run(COLUMN, ranks=3, mpm_restart=half.folder / "column_checkpoint_000004.h5", **NORMAL)
    test.check("again.same", difference(half.table("displacement"), again.table("displacement")), None, 1e-12)


def stages(test):
    """A load that leaves with its stage; and a second body, put onto the first, whose faces below it then bound nothing."""
    layer = {"mpm_grid_upper": "2,8", "mpm_grid_cells": "4,16", "mpm_bodies": "column,layer", "mpm_body_layer_region": "box",
             "mpm_body_layer_lower": "0,4.25", "mpm_body_layer_upper": "2,5", "mpm_body_layer_points_per_cell": "2,2",
             "mpm_body_layer_material": "soil", "mpm_stages": "first,second", "mpm_stage_second_bodies": "layer",
             "mpm_surface_top_normal": -1e3}
    run = test.run(COLUMN, **layer)
    force = run.results.column("reaction_base_y")
    test.near("covered.before", force[7], 1e3 * WIDTH, 1e-9)
    test.check("covered.after", np.abs(force[-1]) / (1e3 * WIDTH), None, 1e-9)
    run = test.run(COLUMN, mpm_stages="first,second", mpm_stage_second_surfaces="none", **NORMAL)
    test.check("left.after", np.abs(run.results.column("reaction_base_y")[-1]) / (PRESSURE * WIDTH), None, 1e-9)


def disc(test):
    """A pressure on all faces of a lattice cut at all angles: uniform, and in equilibrium without a force on what holds the disc."""
    first = None
    for ranks in (1, 2, 4):
        run = test.run(DISC, ranks=ranks, snes_rtol=1e-12)
        first = first or run
        stress = run.table("stress")
        test.check(f"disc_on_{ranks}.stress", np.max(np.abs(stress[:, [0, 1, 3]] + [1e5, 1e5, 0])) / 1e5, None, 1e-9)
        test.check(f"disc_on_{ranks}.held", max(np.abs(run.results.column(name)[-1]) for name in
                                                ("reaction_center_x", "reaction_center_y", "reaction_right_y")) / 1e5, None, 1e-8)
        test.check(f"disc_on_{ranks}.same", difference(first.table("displacement"), run.table("displacement")), None, 1e-9)


def bar(test):
    """The stress is by the area that the pulled end has become, in 3D."""
    for label, options in (("normal", {"mpm_surface_end_normal": 200e3}), ("traction", {"mpm_surface_end_traction": "0,0,200e3"})):
        run = test.run(BAR, ranks=2, snes_rtol=1e-12, **options)
        stress, volume = run.table("stress"), run.table("volume").sum()
        test.check(f"bar_{label}.stress", np.max(np.abs(stress - [0, 0, 200e3, 0, 0, 0])) / 200e3, None, 1e-9)
        length = 2.25 * run.table("F")[:, 8].mean()
        test.near(f"bar_{label}.force", -run.results.column("reaction_z_z")[-1], 200e3 * volume / length, 1e-9)
        test.check(f"bar_{label}.shrinks", volume / length / 1.25, None, 0.95)


with Test() as check:
    column(check)
    stages(check)
    disc(check)
    bar(check)

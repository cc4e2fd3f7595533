#!/usr/bin/env python3
"""Parameters by height or field: a column's settlement against its integral, a shear strength that is reached height by height, a
jump of height against two materials, equal heights against numbers, fields on lattices and at scattered places, reduction,
restart, ranks.

Quick.
"""
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
from talus_test import Test, difference, example  # noqa: E402

FOLDER = Path(__file__).resolve().parent
QUIET = {"mpm_quiet": None, "mpm_output_every": 1000}


def equal_heights(test):
    """Numbers and equal heights are one and the same, to the last digit, in all laws and steps below."""
    cases = {
        "slope_reduction": ("soil", {"E": 20e6, "nu": 0.3, "density": 2000, "cohesion": 10e3, "friction": 20, "dilation": 20},
                            {"mpm_grid_cells": "54,16", "mpm_stage_fail_reduction": "0:1,1:1.2", "mpm_stage_fail_time_step": 0.5}),
        "terzaghi": ("clay", {"E": 1.5e6, "nu": 0.25, "porosity": 0.4, "permeability": 1e-15}, {"mpm_time_end": 2e6}),
        "column_collapse": ("sand", {"E": 1e6, "density": 1600, "friction": 36}, {"mpm_time_end": 0.2}),
        "collapse": ("soil", {"E": 1e6, "nu": 0.3, "yield_stress": 24494.897, "density": 1000}, {"mpm_time_end": 0.2}),
        "clay_rest": ("clay", {"kappa": 0.02, "lambda": 0.1, "M": 1.2, "G": 4e6, "specific_volume": 2.1, "density": 1800},
                      {"mpm_stage_load_time_end": 0.1}),
        "discs": ("rubber", {"E": 1e4, "nu": 0.3, "density": 1000}, {"mpm_time_end": 0.1}),
    }
    for name, (material, parameters, options) in cases.items():
        plain = test.run(example(name), **QUIET, **options)
        heights = {f"mpm_material_{material}_{key}": f"-100:{value},100:{value}" for key, value in parameters.items()}
        by_height = test.run(example(name), **QUIET, **options, **heights)
        one, two = (run.results.state("last") for run in (plain, by_height))
        test.check(f"{name}.displacement", difference(one["displacement"], two["displacement"]), None, 1e-11)
        test.check(f"{name}.stress", difference(one["stress"], two["stress"]), None, 1e-11)
        test.check(f"{name}.newton", int(plain.newton.sum() - by_height.newton.sum()), 0, 0)


def column(test):
    """Own weight with density and modulus by height: stress and displacement by quadrature; on ranks, and from a lattice of rows."""
    run = test.run(FOLDER / "by_height.yaml", **QUIET)
    y = run.table("position0", 0)[:, 1]
    fine = np.linspace(0.0, 10.0, 100001)
    middle, dy = 0.5 * (fine[1:] + fine[:-1]), fine[1] - fine[0]
    weight = 10.0 * np.cumsum(((2000.0 - 100.0 * middle) * dy)[::-1])[::-1]
    settled = -np.cumsum(weight / np.interp(middle, [0, 6, 10], [9e6, 3e6, 2e6])) * dy
    exact = np.interp(y, fine[1:], settled)
    test.check("column.settlement", difference(exact, run.table("displacement")[:, 1]), None, 1e-3)
    test.check("column.E", difference(np.interp(y, [0, 6, 10], [9e6, 3e6, 2e6]), run.table("E")), None, 1e-12)
    test.check("column.mass", difference(2000.0 - 100.0 * y, run.table("mass") / run.table("volume", 0)), None, 1e-12)
    ranks = test.run(FOLDER / "by_height.yaml", ranks=3, **QUIET)
    test.check("column.ranks", difference(run.table("displacement"), ranks.table("displacement")), None, 1e-11)
    rows = Path(run.folder) / "E.csv"
    places = [(x, h) for x in (0.0, 1.0) for h in (0, 6, 10)]
    rows.write_text("x,y,E\n" + "".join(f"{x},{h},{np.interp(h, [0, 6, 10], [9e6, 3e6, 2e6])}\n" for x, h in places))
    lattice = test.run(FOLDER / "by_height.yaml", **QUIET, mpm_material_clay_E=rows)
    test.check("column.lattice", difference(run.table("displacement"), lattice.table("displacement")), None, 1e-11)
    rows.write_text("x,y,E\n0,2,9e6\n0,7,3e6\n0,2,2e6\n")
    twice = test.run(FOLDER / "by_height.yaml", **QUIET, mpm_material_clay_E=rows, status=2)
    test.check("column.twice", int("two rows are at one place: x 0" in twice.errors), 1, 1)
    rows.write_text("x,y,E\n" + "0,1,1e6\n0.5,2.1,2e6\n1,9,3e6\n")
    scattered = test.run(FOLDER / "by_height.yaml", **QUIET, mpm_material_clay_E=rows)
    x = scattered.table("position0", 0)
    near = np.argmin([np.hypot(x[:, 0] - a, x[:, 1] - b) for a, b in ((0, 1), (0.5, 2.1), (1, 9))], axis=0)
    test.check("column.scattered", difference(1e6 * (1.0 + near), scattered.table("E")), None, 0)


def two_materials(test):
    """A jump of all parameters against two bodies of two materials, at rest by k0, reduced, and after a restart."""
    two = test.run(FOLDER / "two_layers.yaml", **QUIET)
    one = test.run(FOLDER / "one_layer.yaml", **QUIET)
    order = [np.lexsort(run.table("position0", 0).T) for run in (two, one)]
    for name in ("displacement", "stress"):
        values = [run.table(name)[rows] for run, rows in zip((two, one), order)]
        test.check(f"jump.{name}", difference(*values), None, 1e-7)
    test.check("jump.flows", np.abs(one.table("displacement")).max(), 1e-4)
    kept = test.run(FOLDER / "one_layer.yaml", **QUIET, mpm_checkpoint_every=2, mpm_checkpoint_keep=9)
    again = test.run(FOLDER / "one_layer.yaml", ranks=2, **QUIET, mpm_restart=f"{kept.prefix}_checkpoint_000002.h5")
    test.check("jump.restart", difference(one.table("stress"), again.table("stress")), None, 1e-6)
    state = one.results.state("last")
    factor = one.results.column("reduction")[-1]
    test.check("jump.reduced", difference(np.where(one.table("position0", 0)[:, 1] < 4.0, 30e3, 15e3) / factor, state["cohesion"]),
               None, 1e-12)


with Test() as test:
    equal_heights(test)
    column(test)
    two_materials(test)

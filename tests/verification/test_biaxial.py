#!/usr/bin/env python3
"""Biaxial compression of loose and dense Nor-Sand on a coarse grid: a homogeneous specimen's stress, history and force are those
of the laboratory, on any number of ranks, in few Newton iterations.
"""
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
from talus_test import EXAMPLES, Test, call, example  # noqa: E402

FOLDER = EXAMPLES / "biaxial_nor_sand"
COARSE = {"mpm_grid_upper": "0.036,0.078", "mpm_grid_cells": "12,13", "mpm_quiet": None}
SAND = {"loose": {}, "dense": {"mpm_material_sand_h": 120, "mpm_material_sand_specific_volume": 1.57,
                               "mpm_material_sand_preconsolidation": 1150e3}}


def follow(test, run, material):
    """The laboratory's run along the path of a run, beside it."""
    process = call([sys.executable, FOLDER / "laboratory.py", run.prefix], run.folder)
    if process.returncode:
        sys.exit(f"laboratory.py ended with status {process.returncode}\n{process.stderr}")
    test.run(FOLDER / "laboratory.yaml", mpm_point_table=f"{run.prefix}_path.csv", mpm_output_prefix=f"{run.prefix}_laboratory",
             mpm_quiet=None, **material)


def homogeneous(test, name, ranks, **options):
    run = test.run(example("biaxial_nor_sand"), ranks=ranks, mpm_time_step=0.04, **COARSE, **SAND[name], **options)
    follow(test, run, SAND[name])
    label = f"{name}_{ranks}"
    test.check_example(label, run, "biaxial_nor_sand")
    test.check(f"{label}.step_cuts", run.results.summary["step_cuts"], None, 0)
    return run


def seen(test, run):
    """The check tells a difference: a laboratory's run with another density."""
    follow(test, run, {**SAND["loose"], "mpm_material_sand_specific_volume": 1.7501})
    process = call([sys.executable, FOLDER / "check.py", run.prefix], run.folder)
    test.check("difference_seen", int(process.returncode == 1 and "stress_error" in process.stderr), 1, 1)


with Test() as test:
    seen(test, homogeneous(test, "loose", 1))
    homogeneous(test, "dense", 2)
    # points of another number and domain in the same grid: uniform all the same
    homogeneous(test, "dense", 1, mpm_body_specimen_points_per_cell="3,3", mpm_stabilization_fbar="false")
